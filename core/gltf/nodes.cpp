#include "core/gltf/nodes.h"

#include "core/error.h"
#include "core/gltf/accessors.h"
#include "core/gltf/markers.h"

#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>

#include <algorithm>
#include <cmath>
#include <string>

namespace lightgrid::gltf {
namespace {

struct Local {
    glm::dmat4 transform{1};
    glm::dmat4 unscaled{1};
};

Local local_transform(const tinygltf::Node& node) {
    if (!node.matrix.empty()) {
        const glm::dmat4 matrix = glm::make_mat4(node.matrix.data());
        return {matrix, matrix};
    }
    Local local;
    if (!node.translation.empty())
        local.unscaled = glm::translate(local.unscaled, glm::make_vec3(node.translation.data()));
    if (const std::vector<double>& q = node.rotation; !q.empty())
        local.unscaled *= glm::mat4_cast(glm::normalize(glm::dquat(q[3], q[0], q[1], q[2])));
    local.transform =
        node.scale.empty() ? local.unscaled : glm::scale(local.unscaled, glm::make_vec3(node.scale.data()));
    return local;
}

bool is_finite(const glm::dmat4& matrix) {
    double sum = 0;
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row) sum += 0 * matrix[column][row];
    return sum == 0;
}

std::vector<int> roots_of_file(const tinygltf::Model& model) {
    std::vector<bool> is_child(model.nodes.size(), false);
    for (const tinygltf::Node& node : model.nodes)
        for (const int child : node.children) is_child[static_cast<std::size_t>(child)] = true;
    std::vector<int> roots;
    for (std::size_t i = 0; i < is_child.size(); ++i)
        if (!is_child[i]) roots.push_back(static_cast<int>(i));
    return roots;
}

int group_of(const tinygltf::Node& node, int parent, std::vector<std::string>& groups) {
    const std::string name = group_name_of(node);
    if (name.empty()) return parent;
    const auto found = std::find(groups.begin(), groups.end(), name);
    const auto index = static_cast<int>(found - groups.begin());
    if (found == groups.end()) groups.push_back(name);
    return index;
}

}  // namespace

int choose_scene(const Document& document, int wanted) {
    const std::vector<tinygltf::Scene>& scenes = document.model().scenes;
    if (wanted < 0) return scenes.empty() ? -1 : document.default_scene();
    if (static_cast<std::size_t>(wanted) < scenes.size()) return wanted;
    if (scenes.empty()) throw Error(fmt::format("scene {} is asked for, but the file has none", wanted));
    std::string list;
    for (std::size_t i = 0; i < scenes.size(); ++i)
        list +=
            fmt::format("{}{}{}", i == 0 ? "" : ", ", i, scenes[i].name.empty() ? "" : " \"" + scenes[i].name + "\"");
    throw Error(fmt::format("scene {} is asked for, but the file has: {}", wanted, list), "", "Choose one of them.");
}

std::vector<PlacedNode> place_nodes(const Document& document, int scene, std::vector<std::string>& groups) {
    struct Waiting {
        int index;
        glm::dmat4 parent;
        int group;
    };
    std::vector<Waiting> waiting;
    const auto add_backwards = [&](const std::vector<int>& nodes, const glm::dmat4& parent, int group) {
        for (auto node = nodes.rbegin(); node != nodes.rend(); ++node) waiting.push_back({*node, parent, group});
    };
    add_backwards(scene < 0 ? roots_of_file(document.model()) : document.scene(scene).nodes, glm::dmat4(1), -1);

    // Each node has one parent, and roots have none: check_links has seen to it, so this ends.
    std::vector<PlacedNode> placed;
    while (!waiting.empty()) {
        const Waiting next = waiting.back();
        waiting.pop_back();
        const tinygltf::Node& node = document.node(next.index);
        const Local local = local_transform(node);
        placed.push_back({next.index, next.parent * local.transform, next.parent * local.unscaled,
                          group_of(node, next.group, groups)});
        if (!is_finite(placed.back().transform))
            throw Error("its transform is not finite", document.node_name(next.index),
                        "Check its scale and its parents'.");
        add_backwards(node.children, placed.back().transform, placed.back().group);
    }
    return placed;
}

std::vector<glm::dmat4> transforms_of(const Document& document, const PlacedNode& placed) {
    const tinygltf::Node& node = document.node(placed.index);
    const tinygltf::Value* instancing = find_extension(node.extensions, "EXT_mesh_gpu_instancing");
    if (instancing == nullptr) return {placed.transform};
    const tinygltf::Value& attributes = instancing->Get("attributes");
    const std::string where = document.node_name(placed.index);
    const auto elements = [&](const char* name) {
        try {
            return elements_of(document, attributes.Get(name).GetNumberAsInt(), name);
        } catch (const Error& error) {
            throw error.inside(where);
        }
    };
    // The accessors have the same count: check_links has seen to it.
    std::vector<glm::dmat4> result;
    if (attributes.Has("TRANSLATION")) {
        for (const glm::vec3& translation : read_vectors<3>(elements("TRANSLATION")))
            result.push_back(glm::translate(glm::dmat4(1), glm::dvec3(translation)));
    }
    if (attributes.Has("ROTATION")) {
        const std::vector<glm::vec4> rotations = read_vectors<4>(elements("ROTATION"));
        result.resize(rotations.size(), glm::dmat4(1));
        for (std::size_t i = 0; i < rotations.size(); ++i) {
            const glm::dvec4 q(rotations[i]);
            if (glm::length(q) < 1e-6) throw Error(fmt::format("rotation {} is zero", i), where);
            result[i] *= glm::mat4_cast(glm::normalize(glm::dquat(q.w, q.x, q.y, q.z)));
        }
    }
    if (attributes.Has("SCALE")) {
        const std::vector<glm::vec3> scales = read_vectors<3>(elements("SCALE"));
        result.resize(scales.size(), glm::dmat4(1));
        for (std::size_t i = 0; i < scales.size(); ++i) result[i] = glm::scale(result[i], glm::dvec3(scales[i]));
    }
    for (glm::dmat4& transform : result) {
        transform = placed.transform * transform;
        if (!is_finite(transform)) throw Error("an instance's transform is not finite", where);
    }
    return result;
}

}  // namespace lightgrid::gltf
