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
};

/// The index of the scene to load: `wanted`, or the file's default if that is negative. -1: the file has no scenes, and
/// all its nodes are the level. Throws Error listing the scenes if there is none of that index.
[[nodiscard]] int choose_scene(const Document& document, int wanted);

/// All nodes of a scene (-1: of the file), parents first. Throws Error.
///
/// groups  names of those that nodes belong to are added, in the order of nodes
[[nodiscard]] std::vector<PlacedNode> place_nodes(const Document& document, int scene,
                                                  std::vector<std::string>& groups);

/// The transforms of what EXT_mesh_gpu_instancing makes of a node's mesh, or just the node's. Throws Error.
[[nodiscard]] std::vector<glm::dmat4> transforms_of(const Document& document, const PlacedNode& node);

}  // namespace lightgrid::gltf
