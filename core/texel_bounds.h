#pragma once

#include "core/scene.h"

#include <glm/glm.hpp>

#include <array>
#include <vector>

namespace lightgrid {

/// How bright a texture is, at most, over a triangle of it, whatever its wrap modes and filter: the proof that nothing
/// is lit there. The largest values of blocks of texels are kept, of blocks of those, and so on; those that the
/// triangle meets are looked at, a few tens at most.
class TexelBounds {
  public:
    /// Keeps a reference: the texture must outlive it.
    explicit TexelBounds(const Texture& texture);

    /// By channel, as stored: no look-up at a point of the triangle depends on a texel that is larger.
    ///
    /// corners  in texels: texture coordinates, not wrapped, times the texture's size
    /// slack    texels that a look-up may be off by rounding, by axis
    [[nodiscard]] glm::u8vec4 most_over(const std::array<glm::dvec2, 3>& corners, glm::dvec2 slack) const noexcept;

    /// Over all texels: colour decoded from sRGB, alpha in [0, 1].
    [[nodiscard]] glm::vec4 mean() const noexcept { return mean_; }
    [[nodiscard]] glm::dvec2 size() const noexcept { return {texture_->image.width, texture_->image.height}; }

  private:
    struct Level {
        int width = 0;
        int height = 0;
        std::vector<glm::u8vec4> most;  // row by row
    };

    [[nodiscard]] glm::u8vec4 most_in(int level, int x, int y) const noexcept;

    const Texture* texture_;
    std::vector<Level> levels_;  // blocks of 4 texels along each axis, then of 8, to a single one
    glm::vec4 mean_{0};
};

}  // namespace lightgrid
