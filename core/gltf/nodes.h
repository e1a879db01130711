#pragma once

#include "core/gltf/document.h"

#include <glm/glm.hpp>

#include <string>
#include <vector>

namespace lightgrid::gltf {

/// A node of the scene. Transforms are to the level's coordinates, in double.
struct PlacedNode {
    int index = 0;
    glm::dmat4 transform{1};
    glm::dmat4 unscaled{1};  // without the node's own scale: what its light has
    int group = -1;          // that its light belongs to, its own or that of the nearest node above; -1: none
    bool hidden = false;     // by KHR_node_visibility, its own or that of a node above
};

/// Whether a transform leaves nothing of three axes: what it places is hidden, lights included (glTF 2.0, 5.25). A
/// flattened thing, as decals are, is not.
[[nodiscard]] bool is_scaled_away(const glm::dmat4& transform) noexcept;

/// What patterns are tried on: the node's name, or its mesh's where it has none.
[[nodiscard]] const std::string& ignorable_name(const Document& document, const tinygltf::Node& node);

/// The index of the scene to load: `wanted`, or the file's default if that is negative. -1: the file has no scenes, and
/// all its nodes are the level. Throws Error listing the scenes if there is none of that index.
[[nodiscard]] int choose_scene(const Document& document, int wanted);

/// The nodes of a scene.
struct Placement {
    std::vector<PlacedNode> nodes;    // that are part of the level, parents first
    std::vector<PlacedNode> ignored;  // the others; joints of a skin may be among them
    std::vector<std::string> groups;  // of lights, in the order of nodes
};

/// Throws Error, also for a pattern that fits no node.
///
/// scene   -1: all nodes of the file
/// ignore  see LoadOptions
[[nodiscard]] Placement place_nodes(const Document& document, int scene, const std::vector<std::string>& ignore);

/// The transforms of what EXT_mesh_gpu_instancing makes of a node's mesh, or just the node's. Throws Error.
[[nodiscard]] std::vector<glm::dmat4> transforms_of(const Document& document, const PlacedNode& node);

}  // namespace lightgrid::gltf
