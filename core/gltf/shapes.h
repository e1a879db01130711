#pragma once

#include "core/gltf/document.h"
#include "core/gltf/nodes.h"

#include <glm/glm.hpp>

#include <compare>
#include <vector>

namespace lightgrid::gltf {

/// A mesh in one shape, morphed or posed, and everywhere that it stands in the level.
struct Shape {
    struct Key {
        int mesh = 0;
        std::vector<double> weights;  // of its morph targets; empty: as it is
        int group = -1;               // of lights, where it emits
        auto operator<=>(const Key&) const = default;
    };
    Key key;
    int skin = -1;                       // then it stands once, where its joints are, and `transforms` says nothing
    std::vector<glm::dmat4> transforms;  // to level coordinates; at least one
    std::vector<int> nodes;              // as many: where each stands

    /// It stands several times, and is traced as instances of one model.
    [[nodiscard]] bool is_instanced() const { return transforms.size() > 1; }
};

/// The shapes that nodes of the scene have, but for marked ones. A mesh that several nodes use, or
/// EXT_mesh_gpu_instancing repeats, is one shape; what cannot be an instance, because its transform is flat or its
/// joints pose it, is a shape of its own. One that emits is a shape for each group of lights.
[[nodiscard]] std::vector<Shape> find_shapes(const Document& document, const std::vector<PlacedNode>& nodes);

}  // namespace lightgrid::gltf
