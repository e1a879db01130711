#include "core/texel_bounds.h"

#include "core/parallel.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace lightgrid {
namespace {

/// Texels along a block of the first level that is kept; what is smaller is read from the texture itself.
constexpr int first_block_shift = 2;
/// A triangle is looked at by single texels up to this many along an axis, else by blocks, four or five along it.
constexpr double most_single_texels = 6;
constexpr double most_blocks = 4;
/// Of the texture side by side that are told apart; over more, all of it counts.
constexpr double most_repeats = 4;
/// Texels from the origin from where float, and the look-up with it, has no fractions left.
constexpr double largest_coordinate = 0x1p22;
/// Beyond the edge of a clamped texture, its outermost texels go on without end.
constexpr double endless = 0x1p24;

glm::u8vec4 larger(glm::u8vec4 a, glm::u8vec4 b) {
    return glm::max(a, b);
}

/// A block of texels along one axis, and the coordinates at which it counts.
struct Stretch {
    int block = 0;
    double begin = 0;
    double end = 0;
};

/// All blocks along an axis that count between two coordinates.
struct Stretches {
    std::array<Stretch, 32> found;
    std::size_t count = 0;
    bool all = false;  // they are too many: the whole texture counts

    /// reach  of a texel, beyond its own edges
    Stretches(double low, double high, int size, Wrap wrap, int shift, double reach) {
        const auto add = [&](int first, int last, double origin, bool mirrored) {
            for (int block = first >> shift; block <= last >> shift; ++block) {
                if (count == found.size()) {
                    all = true;
                    return;
                }
                const double begin = static_cast<double>(block) * (1 << shift);
                const double end = std::min(begin + (1 << shift), static_cast<double>(size));
                found[count++] = mirrored ? Stretch{block, origin + size - end - reach, origin + size - begin + reach}
                                          : Stretch{block, origin + begin - reach, origin + end + reach};
            }
        };
        const auto texel = [&](double coordinate) {
            return static_cast<int>(std::clamp(std::floor(coordinate), 0.0, size - 1.0));
        };
        if (wrap == Wrap::clamp) {
            add(texel(low - reach), texel(high + reach), 0, false);
            for (std::size_t i = 0; i < count; ++i) {
                if (found[i].block == 0) found[i].begin = -endless;
                if (found[i].block == (size - 1) >> shift) found[i].end = endless;
            }
            return;
        }
        const double first = std::floor((low - reach) / size);
        const double last = std::floor((high + reach) / size);
        if (!(last - first < most_repeats)) {
            all = true;
            return;
        }
        for (double repeat = first; repeat <= last && !all; ++repeat) {
            const double origin = repeat * size;
            const int begin = texel(low - reach - origin);
            const int end = texel(high + reach - origin);
            const bool mirrored = wrap == Wrap::mirror && std::fmod(std::abs(repeat), 2) == 1;
            if (mirrored) {
                add(size - 1 - end, size - 1 - begin, origin, true);
            } else {
                add(begin, end, origin, false);
            }
        }
    }
};

/// Whether a side of the triangle has all of a rectangle beyond it. (That its bounds meet the rectangle is known.)
bool is_beside(const std::array<glm::dvec2, 3>& corners, const Stretch& x, const Stretch& y) {
    const glm::dvec2 center(0.5 * (x.begin + x.end), 0.5 * (y.begin + y.end));
    const glm::dvec2 half(0.5 * (x.end - x.begin), 0.5 * (y.end - y.begin));
    for (int i = 0; i < 3; ++i) {
        const glm::dvec2 side = corners[(i + 1) % 3] - corners[i];
        const glm::dvec2 across(-side.y, side.x);
        const double on_side = glm::dot(across, corners[i]);
        const double inside = glm::dot(across, corners[(i + 2) % 3]);
        const double middle = glm::dot(across, center);
        const double extent = glm::dot(glm::abs(across), half);
        if (middle + extent < std::min(on_side, inside) || middle - extent > std::max(on_side, inside)) return true;
    }
    return false;
}

}  // namespace

TexelBounds::TexelBounds(const Texture& texture) : texture_(&texture) {
    const ByteImage& image = texture.image;
    Level level;
    level.width = ((image.width - 1) >> first_block_shift) + 1;
    level.height = ((image.height - 1) >> first_block_shift) + 1;
    level.most.resize(static_cast<std::size_t>(level.width) * level.height, glm::u8vec4(0));
    std::vector<glm::dvec4> sums(level.height, glm::dvec4(0));
    std::array<float, 256> linear;
    for (std::size_t i = 0; i < linear.size(); ++i) linear[i] = decode_srgb(static_cast<std::uint8_t>(i));
    for_each_index(level.height, [&](std::size_t row) {
        const int first = static_cast<int>(row) << first_block_shift;
        for (int y = first; y < std::min(first + (1 << first_block_shift), image.height); ++y) {
            glm::vec4 sum(0);
            for (int x = 0; x < image.width; ++x) {
                const glm::u8vec4 texel = image.at(x, y);
                glm::u8vec4& most = level.most[row * level.width + (x >> first_block_shift)];
                most = larger(most, texel);
                sum += glm::vec4(linear[texel.r], linear[texel.g], linear[texel.b], texel.a * (1.0F / 255));
            }
            sums[row] += glm::dvec4(sum);
        }
    });
    glm::dvec4 sum(0);
    for (const glm::dvec4& s : sums) sum += s;
    mean_ = glm::vec4(sum / (static_cast<double>(image.width) * image.height));
    levels_.push_back(std::move(level));
    while (levels_.back().most.size() > 1) {
        const Level& below = levels_.back();
        Level above;
        above.width = (below.width + 1) / 2;
        above.height = (below.height + 1) / 2;
        above.most.resize(static_cast<std::size_t>(above.width) * above.height, glm::u8vec4(0));
        for (int y = 0; y < below.height; ++y) {
            for (int x = 0; x < below.width; ++x) {
                glm::u8vec4& most = above.most[static_cast<std::size_t>(y / 2) * above.width + x / 2];
                most = larger(most, below.most[static_cast<std::size_t>(y) * below.width + x]);
            }
        }
        levels_.push_back(std::move(above));
    }
}

glm::u8vec4 TexelBounds::most_in(int level, int x, int y) const noexcept {
    if (level < 0) return texture_->image.at(x, y);
    const Level& of = levels_[level];
    return of.most[static_cast<std::size_t>(y) * of.width + x];
}

glm::u8vec4 TexelBounds::most_over(const std::array<glm::dvec2, 3>& corners, glm::dvec2 slack) const noexcept {
    const glm::u8vec4 all = levels_.back().most.front();
    const glm::dvec2 low = glm::min(glm::min(corners[0], corners[1]), corners[2]);
    const glm::dvec2 high = glm::max(glm::max(corners[0], corners[1]), corners[2]);
    const glm::dvec2 reach = slack + (texture_->nearest ? 0.0 : 0.5);
    for (int axis = 0; axis < 2; ++axis) {
        if (!(std::max(std::abs(low[axis]), std::abs(high[axis])) + reach[axis] < largest_coordinate)) return all;
    }
    const double extent = std::max(high.x - low.x + 2 * reach.x, high.y - low.y + 2 * reach.y);
    int level = -1;
    if (extent > most_single_texels) {
        const int shift = std::max(first_block_shift, static_cast<int>(std::ceil(std::log2(extent / most_blocks))));
        level = std::min(shift - first_block_shift, static_cast<int>(levels_.size()) - 1);
    }
    const int shift = level < 0 ? 0 : level + first_block_shift;
    const Stretches across(low.x, high.x, texture_->image.width, texture_->wrap_u, shift, reach.x);
    const Stretches down(low.y, high.y, texture_->image.height, texture_->wrap_v, shift, reach.y);
    if (across.all || down.all) return all;
    glm::u8vec4 most(0);
    for (std::size_t j = 0; j < down.count; ++j) {
        for (std::size_t i = 0; i < across.count; ++i) {
            const Stretch& x = across.found[i];
            const Stretch& y = down.found[j];
            if (!is_beside(corners, x, y)) most = larger(most, most_in(level, x.block, y.block));
        }
    }
    return most;
}

}  // namespace lightgrid
