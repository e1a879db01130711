#include "core/gltf/markers.h"

#include "core/gltf/meshes.h"

namespace lightgrid::gltf {
namespace {

std::vector<glm::vec3> vertices_of(const Document& document, const tinygltf::Node& node) {
    std::vector<glm::vec3> vertices;
    if (node.mesh < 0) {
        for (int corner = 0; corner < 8; ++corner)
            vertices.push_back(glm::vec3(corner & 1, corner >> 1 & 1, corner >> 2) - 0.5F);
        return vertices;
    }
    const std::size_t count = document.mesh(node.mesh).primitives.size();
    for (std::size_t i = 0; i < count; ++i) {
        const std::vector<glm::vec3> more = load_positions(document, node.mesh, static_cast<int>(i));
        vertices.insert(vertices.end(), more.begin(), more.end());
    }
    return vertices;
}

}  // namespace

Marker marker_of(const tinygltf::Node& node) {
    if (!node.extras.Has("lightgrid") || !node.extras.Get("lightgrid").IsString()) return Marker::none;
    const auto& name = node.extras.Get("lightgrid").Get<std::string>();
    if (name == "ignore") return Marker::ignore;
    return name == "volume" ? Marker::volume : Marker::probe;
}

std::string group_name_of(const tinygltf::Node& node) {
    if (!node.extras.Has("lightgrid") || !node.extras.Get("lightgrid").Has("group")) return {};
    return node.extras.Get("lightgrid").Get("group").Get<std::string>();
}

void read_markers(const Document& document, const std::vector<PlacedNode>& nodes, Scene& scene, Notices& notices) {
    for (const PlacedNode& placed : nodes) {
        const tinygltf::Node& node = document.node(placed.index);
        const Marker marker = marker_of(node);
        if (marker == Marker::probe) scene.probe_markers.emplace_back(placed.transform[3]);
        if (marker != Marker::volume) continue;
        if (is_scaled_away(placed.transform)) {
            notices.add(document.node_name(placed.index), "marks a volume, but is scaled to nothing");
            continue;
        }
        Box box;
        for (const glm::vec3& vertex : vertices_of(document, node))
            box.extend(placed.transform * glm::dvec4(vertex, 1));
        if (box.empty())
            notices.add(document.node_name(placed.index), "marks a volume, but its mesh has no vertices");
        else
            scene.volume_markers.push_back(box);
    }
}

}  // namespace lightgrid::gltf
