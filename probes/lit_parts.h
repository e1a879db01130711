#pragma once

#include "core/scene.h"

#include <glm/glm.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace lightgrid {

/// Where on its triangles a material with textures emits: triangles are halved, across the side that is longest on the
/// texture, until a part is dark for certain, about as bright all over, or smaller than a texel. The parts that emit
/// are what there is to sample: a lit sign in the texture of a wall is found as if it were a quad of its own.
///
/// No light is lost: a part counts as dark only where no texel that a look-up there may read is lit, and MASK and BLEND
/// leave something of it (TexelBounds). How bright a part is on the mean comes from points on it, and decides nothing but
/// how often it is sampled.
///
/// How many parts are tried is limited over all triangles together; where that does not suffice, a few of the parts are
/// larger than what is lit on them, and cost noise.
class LitParts {
  public:
    static constexpr std::uint32_t none = 0xffffffffU;
    /// Parts that are tried, all triangles together; those of a mesh count as often as it stands in the level.
    static constexpr std::size_t most_tried = std::size_t{1} << 18;

    struct Part {
        std::array<glm::vec2, 3> corners;  // barycentric coordinates (b1, b2) on the triangle
        float area = 0;                    // of the triangle's
        float emission = 0;                // mean luminance of what leaves it, alpha counted; > 0
    };

    /// What emits of a triangle.
    struct Division {
        float emission = 0;            // its mean luminance: 0 where all is dark
        std::uint32_t root = none;     // of the halvings; none: the triangle is one part, or dark
        std::uint32_t first_part = 0;  // where it is divided
        std::uint32_t parts = 0;
    };

    /// Of meshes whose material emits.
    ///
    /// uses  how often each stands in the level, by mesh; 0: it is not asked for
    LitParts(const Scene& scene, std::span<const std::uint32_t> uses);

    [[nodiscard]] const Division& division(int mesh, std::uint32_t triangle) const noexcept {
        return divisions_[first_[static_cast<std::size_t>(mesh)] + triangle];
    }
    [[nodiscard]] const Part& part(std::uint32_t index) const noexcept { return parts_[index]; }
    /// Which of a divided triangle's parts a place on it belongs to, from 0 on; none where it is dark.
    ///
    /// root  of its division
    [[nodiscard]] std::uint32_t find(std::uint32_t root, glm::vec2 barycentric) const noexcept;

  private:
    class Divider;

    /// A part that was halved: across the side from corner `side` to the next. Its first half keeps that corner.
    struct Node {
        static constexpr std::uint32_t whole = 3;

        std::uint32_t side : 2 = whole;  // whole: it was not halved
        std::uint32_t next : 30 = dark;  // the first half, the second follows it; of a whole: which part it is
        static constexpr std::uint32_t dark = 0x3fffffffU;
    };

    std::vector<std::uint32_t> first_;  // by mesh: in divisions_, by triangle
    std::vector<Division> divisions_;
    std::vector<Node> nodes_;
    std::vector<Part> parts_;
};

}  // namespace lightgrid
