#pragma once

#include "core/gltf/document.h"
#include "core/scene.h"

#include <glm/glm.hpp>

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace lightgrid::gltf {

/// A primitive of a mesh, and how the level wants it.
struct PrimitiveRequest {
    int mesh = 0;
    int primitive = 0;
    int material = 0;             // index in Scene::materials
    std::vector<int> uv_sets;     // what its material reads, increasing
    std::vector<double> weights;  // of its morph targets; empty: as it is
    int skin = -1;                // index in the file
    /// Of all nodes, to level coordinates; nothing for those that are not in the scene. Skins read their joints'.
    std::span<const std::optional<glm::dmat4>> node_transforms;
};

struct LoadedPrimitive {
    Mesh mesh;                  // in its own space; no triangles: nothing of it can be seen
    glm::dvec3 offset{0};       // skinned: where in the level (0, 0, 0) of `mesh` is
    bool turned = false;        // skinned: its first joint mirrors it
    bool unweighted = false;    // skinned: vertices without weights follow the first joint that they name
    std::size_t left_over = 0;  // vertices that make no whole triangle
    std::vector<int> missing_uv_sets;
    bool colors_clamped = false;
    std::size_t without_area = 0;  // triangles that were dropped
};

/// Drops triangles whose corners lie on one line, exactly. Returns how many.
std::size_t drop_triangles_without_area(Mesh& mesh);

/// 4, 5 or 6: the modes that make triangles.
[[nodiscard]] bool makes_triangles(const tinygltf::Primitive& primitive);

/// Whether load_primitive reads an attribute.
[[nodiscard]] bool is_read(const std::string& attribute, const PrimitiveRequest& request);

/// Throws Error naming mesh, primitive and attribute. Safe from several threads.
[[nodiscard]] LoadedPrimitive load_primitive(const Document& document, const PrimitiveRequest& request);

/// The positions of a primitive as they are stored: used or not, of any mode.
[[nodiscard]] std::vector<glm::vec3> load_positions(const Document& document, int mesh, int primitive);

}  // namespace lightgrid::gltf
