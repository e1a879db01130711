#pragma once

#include "core/gltf/document.h"
#include "core/gltf/nodes.h"
#include "core/scene.h"

#include <string>
#include <vector>

namespace lightgrid::gltf {

/// What an artist marked a node as, by extras {"lightgrid": "volume"}, "probe" or "ignore". The mesh of a marked node is
/// not part of the level; with "ignore", nothing below the node is either.
enum class Marker { none, volume, probe, ignore };

[[nodiscard]] Marker marker_of(const tinygltf::Node& node);

/// The group of lights that a node and all below it belong to, by extras {"lightgrid": {"group": "NAME"}}; empty: none
/// of its own.
[[nodiscard]] std::string group_name_of(const tinygltf::Node& node);

/// Fills the scene's volume and probe markers. A volume is the axis-aligned box around the node's mesh, or around the
/// cube from -0.5 to 0.5 if it has none; a probe stands where its node does.
void read_markers(const Document& document, const std::vector<PlacedNode>& nodes, Scene& scene, Notices& notices);

}  // namespace lightgrid::gltf
