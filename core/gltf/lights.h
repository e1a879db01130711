#pragma once

#include "core/gltf/document.h"
#include "core/gltf/nodes.h"
#include "core/scene.h"

#include <vector>

namespace lightgrid::gltf {

/// Fills the scene's lights from KHR_lights_punctual, relative to scene.origin. Those without intensity are left out.
/// Throws Error.
void read_lights(const Document& document, const std::vector<PlacedNode>& nodes, Scene& scene, Notices& notices);

}  // namespace lightgrid::gltf
