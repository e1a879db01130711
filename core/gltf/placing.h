#pragma once

#include "core/gltf/meshes.h"
#include "core/gltf/shapes.h"
#include "core/scene.h"

#include <vector>

namespace lightgrid::gltf {

/// One primitive of a shape.
struct Part {
    std::size_t shape = 0;
    PrimitiveRequest request;
    LoadedPrimitive loaded;
};

/// Stands the meshes of a scene, each of which is that of the part with the same index, in their level: sets bounds and
/// origin; brings those that stand once into the level's space and lists them as placed; makes models and instances of
/// the others. Meshes without triangles go.
///
/// returns  how many triangles have no area once they stand in the level; they are dropped
/// Throws Error where the level reaches too far.
std::size_t place_parts(const std::vector<Shape>& shapes, const std::vector<Part>& parts, Scene& scene);

}  // namespace lightgrid::gltf
