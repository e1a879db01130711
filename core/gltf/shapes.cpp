#include "core/gltf/shapes.h"

#include "core/gltf/markers.h"
#include "core/gltf/materials.h"
#include "core/gltf/meshes.h"

#include <algorithm>
#include <map>

namespace lightgrid::gltf {
namespace {

bool is_skinned(const tinygltf::Mesh& mesh) {
    return std::any_of(mesh.primitives.begin(), mesh.primitives.end(),
                       [](const tinygltf::Primitive& primitive) { return primitive.attributes.contains("JOINTS_0"); });
}

bool emits(const Document& document, const tinygltf::Mesh& mesh) {
    return std::any_of(mesh.primitives.begin(), mesh.primitives.end(), [&](const tinygltf::Primitive& primitive) {
        return makes_triangles(primitive) && material_emits(document, primitive.material);
    });
}

Shape::Key key_of(const Document& document, const PlacedNode& placed) {
    const tinygltf::Node& node = document.node(placed.index);
    const tinygltf::Mesh& mesh = document.mesh(node.mesh);
    Shape::Key key{node.mesh, node.weights.empty() ? mesh.weights : node.weights};
    if (placed.group >= 0 && emits(document, mesh)) key.group = placed.group;
    if (std::all_of(key.weights.begin(), key.weights.end(), [](double weight) { return weight == 0; }))
        key.weights.clear();
    return key;
}

}  // namespace

std::vector<Shape> find_shapes(const Document& document, const std::vector<PlacedNode>& nodes) {
    std::vector<Shape> shapes;
    std::map<Shape::Key, std::size_t> known;
    for (const PlacedNode& placed : nodes) {
        const tinygltf::Node& node = document.node(placed.index);
        if (placed.hidden || node.mesh < 0 || marker_of(node) != Marker::none) continue;
        const tinygltf::Mesh& mesh = document.mesh(node.mesh);
        const Shape::Key key = key_of(document, placed);
        if (node.skin >= 0 && is_skinned(mesh)) {
            shapes.push_back({key, node.skin, {placed.transform}, {placed.index}});
            continue;
        }
        for (const glm::dmat4& transform : transforms_of(document, placed)) {
            if (is_scaled_away(transform)) continue;
            if (is_flat(glm::dmat3(transform))) {
                shapes.push_back({key, -1, {transform}, {placed.index}});
                continue;
            }
            const auto [entry, added] = known.emplace(key, shapes.size());
            if (added) shapes.push_back({key, -1, {}, {}});
            shapes[entry->second].transforms.push_back(transform);
            shapes[entry->second].nodes.push_back(placed.index);
        }
    }
    return shapes;
}

}  // namespace lightgrid::gltf
