#include "core/gltf/nodes.h"

#include "core/error.h"
#include "core/gltf/accessors.h"
#include "core/gltf/markers.h"
#include "core/near_names.h"

#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>

#include <algorithm>
#include <cmath>
#include <fnmatch.h>
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

bool is_visible(const tinygltf::Node& node) {
    const tinygltf::Value* visibility = find_extension(node.extensions, "KHR_node_visibility");
    return visibility == nullptr || !visibility->Has("visible") || visibility->Get("visible").Get<bool>();
}

/// Patterns that say which nodes to leave out, and whether each fitted any.
class Patterns {
  public:
    explicit Patterns(const std::vector<std::string>& patterns) : patterns_(patterns), fitted_(patterns.size()) {}

    /// To be called with the names of all nodes of a scene.
    bool fit(const std::string& name) {
        bool any = false;
        for (std::size_t i = 0; i < patterns_.size(); ++i) {
            if (fnmatch(patterns_[i].c_str(), name.c_str(), 0) != 0) continue;
            fitted_[i] = true;
            any = true;
        }
        if (!patterns_.empty() && !name.empty()) names_.push_back(name);
        return any;
    }

    void require_all_fitted() const {
        std::vector<std::string> problems;
        for (std::size_t i = 0; i < patterns_.size(); ++i) {
            if (fitted_[i]) continue;
            const std::vector<std::string> nearest = nearest_names(patterns_[i], names_, 5);
            problems.push_back(fmt::format(
                "no node's name fits \"{}\", which is to be left out{}", patterns_[i],
                nearest.empty() ? "" : fmt::format(" (the nearest names: \"{}\")", fmt::join(nearest, "\", \""))));
        }
        if (!problems.empty())
            throw Error(fmt::format("{}", fmt::join(problems, "; ")), "", "Give names of nodes, * for any letters.");
    }

  private:
    const std::vector<std::string>& patterns_;
    std::vector<bool> fitted_;
    std::vector<std::string> names_;
};

}  // namespace

bool is_scaled_away(const glm::dmat4& transform) noexcept {
    constexpr double nothing = 1e-30;  // squared: rounding leaves up to 1e-16 of products that should be 0
    const glm::dmat3 axes(transform);
    return glm::dot(axes[0], axes[0]) + glm::dot(axes[1], axes[1]) + glm::dot(axes[2], axes[2]) < nothing;
}

const std::string& ignorable_name(const Document& document, const tinygltf::Node& node) {
    if (!node.name.empty() || node.mesh < 0) return node.name;
    return document.model().meshes[static_cast<std::size_t>(node.mesh)].name;
}

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

Placement place_nodes(const Document& document, int scene, const std::vector<std::string>& ignore) {
    struct Waiting {
        int index;
        glm::dmat4 parent{1};
        int group = -1;
        bool hidden = false;
        bool ignored = false;
    };
    std::vector<Waiting> waiting;
    const auto add_backwards = [&](const std::vector<int>& nodes, Waiting with) {
        for (auto node = nodes.rbegin(); node != nodes.rend(); ++node) {
            with.index = *node;
            waiting.push_back(with);
        }
    };
    add_backwards(scene < 0 ? roots_of_file(document.model()) : document.scene(scene).nodes, {});

    // Each node has one parent, and roots have none: check_links has seen to it, so this ends.
    Placement placement;
    Patterns patterns(ignore);
    while (!waiting.empty()) {
        const Waiting next = waiting.back();
        waiting.pop_back();
        const tinygltf::Node& node = document.node(next.index);
        const Local local = local_transform(node);
        const bool fits = patterns.fit(ignorable_name(document, node));
        const bool ignored = next.ignored || fits || marker_of(node) == Marker::ignore;
        const PlacedNode placed{next.index, next.parent * local.transform, next.parent * local.unscaled,
                                ignored ? -1 : group_of(node, next.group, placement.groups),
                                next.hidden || !is_visible(node)};
        if (!is_finite(placed.transform))
            throw Error("its transform is not finite", document.node_name(next.index),
                        "Check its scale and its parents'.");
        (ignored ? placement.ignored : placement.nodes).push_back(placed);
        add_backwards(node.children, {-1, placed.transform, placed.group, placed.hidden, ignored});
    }
    patterns.require_all_fitted();
    return placement;
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
