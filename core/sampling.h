#pragma once

#include <glm/glm.hpp>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// Random numbers that are functions of what they are for, low-discrepancy points, and mappings of the unit square.
/// Nothing here has state that outlives a sample, so results do not depend on threads or order.
namespace lightgrid {

/// Mixes two words into one; a bijection in `value` for every `key` (the finaliser of SplitMix64, Steele, Lea, Flood,
/// "Fast Splittable Pseudorandom Number Generators", 2014).
[[nodiscard]] constexpr std::uint64_t mix_bits(std::uint64_t key, std::uint64_t value) {
    std::uint64_t z = key * 0x9e3779b97f4a7c15U + value + 0x9e3779b97f4a7c15U;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
    return z ^ (z >> 31);
}

/// The upper 24 bits as a number in [0, 1): exact in float, never 1.
[[nodiscard]] constexpr float to_unit(std::uint32_t bits) {
    return static_cast<float>(bits >> 8) * 0x1p-24F;
}

/// The upper 53 bits, likewise in double.
[[nodiscard]] constexpr double to_unit_double(std::uint64_t bits) {
    return static_cast<double>(bits >> 11) * 0x1p-53;
}

/// Counter-based random numbers: number k of stream `key` is mix_bits(key, k).
class RandomStream {
  public:
    explicit constexpr RandomStream(std::uint64_t key) : key_(key) {}

    [[nodiscard]] constexpr float next() {
        return to_unit(static_cast<std::uint32_t>(mix_bits(key_, counter_++) >> 32));
    }
    [[nodiscard]] constexpr double next_double() { return to_unit_double(mix_bits(key_, counter_++)); }
    [[nodiscard]] constexpr glm::vec2 next2() {
        const std::uint64_t bits = mix_bits(key_, counter_++);
        return {to_unit(static_cast<std::uint32_t>(bits >> 32)), to_unit(static_cast<std::uint32_t>(bits))};
    }

  private:
    std::uint64_t key_;
    std::uint64_t counter_ = 0;
};

[[nodiscard]] constexpr std::uint32_t reverse_bits(std::uint32_t x) {
    x = ((x & 0x55555555U) << 1) | ((x >> 1) & 0x55555555U);
    x = ((x & 0x33333333U) << 2) | ((x >> 2) & 0x33333333U);
    x = ((x & 0x0f0f0f0fU) << 4) | ((x >> 4) & 0x0f0f0f0fU);
    x = ((x & 0x00ff00ffU) << 8) | ((x >> 8) & 0x00ff00ffU);
    return (x << 16) | (x >> 16);
}

/// A permutation in which every output bit depends on that input bit and the lower ones only: Owen scrambling of a
/// bit-reversed number (Laine and Karras 2011; constants of Burley, "Practical Hash-based Owen Scrambling", 2020).
[[nodiscard]] constexpr std::uint32_t scramble_reversed(std::uint32_t x, std::uint32_t seed) {
    x += seed;
    x ^= x * 0x6c50b47cU;
    x ^= x * 0xb82f1e52U;
    x ^= x * 0xc7afe638U;
    x ^= x * 0x8d22f6e6U;
    return x;
}

/// Point `index` of an Owen-scrambled Sobol' sequence in two dimensions; `seed` picks the scrambling. Every aligned
/// power-of-two block is a (0, m, 2)-net; each point alone is uniform in the unit square.
///
/// In bit-reversed form the first dimension is the index itself and the second is the index times Pascal's triangle mod
/// 2, whose entry (k, j) is 1 where the bits of j are among those of k: five exclusive-or steps.
[[nodiscard]] constexpr glm::vec2 sobol_point(std::uint32_t index, std::uint64_t seed) {
    std::uint32_t second = index;
    second ^= (second >> 1) & 0x55555555U;
    second ^= (second >> 2) & 0x33333333U;
    second ^= (second >> 4) & 0x0f0f0f0fU;
    second ^= (second >> 8) & 0x00ff00ffU;
    second ^= (second >> 16) & 0x0000ffffU;
    return {to_unit(reverse_bits(scramble_reversed(index, static_cast<std::uint32_t>(seed)))),
            to_unit(reverse_bits(scramble_reversed(second, static_cast<std::uint32_t>(seed >> 32))))};
}

/// Owen-shuffled index: gives further dimension pairs their own order, so that padding them together keeps each pair a
/// net without correlating them (Burley 2020).
[[nodiscard]] constexpr std::uint32_t shuffled_index(std::uint32_t index, std::uint32_t seed) {
    return reverse_bits(scramble_reversed(reverse_bits(index), seed));
}

/// At most `most` of some values, taken at even steps.
template <typename T>
[[nodiscard]] std::vector<T> spread_over(std::span<const T> all, std::size_t most) {
    const std::size_t count = std::min(most, all.size());
    std::vector<T> some;
    some.reserve(count);
    for (std::size_t i = 0; i < count; ++i) some.push_back(all[i * all.size() / count]);
    return some;
}

/// `count` directions spread evenly over the sphere, in the order of falling y: a Fibonacci lattice, wrapped by the
/// area-preserving map (Marques et al., "Spherical Fibonacci Point Sets for Illumination Integrals", 2013).
[[nodiscard]] std::vector<glm::vec3> even_directions(std::uint32_t count);

/// A rotation uniform over all rotations (Shoemake, "Uniform Random Rotations", 1992): turns a fixed set of directions
/// into one whose every direction alone is uniform on the sphere.
[[nodiscard]] glm::mat3 random_rotation(std::uint64_t key) noexcept;
[[nodiscard]] std::vector<glm::vec3> turned(std::span<const glm::vec3> directions, const glm::mat3& rotation);

/// Uniform on the sphere, area-preserving; u in [0, 1)^2. Density 1 / (4 pi).
[[nodiscard]] glm::vec3 sphere_direction(glm::vec2 u) noexcept;

/// Cosine-weighted about `normal` (unit); density cos / pi. Never below the surface.
[[nodiscard]] glm::vec3 cosine_direction(glm::vec3 normal, glm::vec2 u) noexcept;

/// Barycentric coordinates (b1, b2) of a uniform point of a triangle.
[[nodiscard]] glm::vec2 triangle_point(glm::vec2 u) noexcept;

/// A triangle as a point sees it, to be sampled evenly by solid angle. In double, since it may be large, thin or close.
///
/// Source: Arvo, "Stratified Sampling of Spherical Triangles", 1995; van Oosterom, Strackee, "The Solid Angle of a Plane
/// Triangle", 1983.
class SphericalTriangle {
  public:
    /// Corners relative to the point, either winding. A point in the triangle's plane sees a solid angle of 0 (or, by
    /// rounding, 2 pi): there is nothing to sample then.
    SphericalTriangle(glm::dvec3 a, glm::dvec3 b, glm::dvec3 c) noexcept;

    [[nodiscard]] double solid_angle() const noexcept { return solid_angle_; }
    /// Unit length; density 1 / solid_angle. The map from the square is continuous: strata stay together.
    [[nodiscard]] glm::dvec3 sample(glm::vec2 u) const noexcept;

  private:
    glm::dvec3 a_, b_;         // directions of corners
    glm::dvec3 towards_c_{0};  // at a, along the side to c; unit length, across a
    double cos_ab_;
    double cos_a_ = 1, sin_a_ = 0;  // of the angle at a
    double solid_angle_;
};

/// Rec.709 luminance, the importance that all sampling decisions use.
[[nodiscard]] constexpr float luminance(glm::vec3 color) {
    return 0.2126F * color.x + 0.7152F * color.y + 0.0722F * color.z;
}

/// Draws an index in proportion to given weights in O(1) (Walker 1977, Vose 1991).
class AliasTable {
  public:
    AliasTable() = default;
    /// weights  non-negative, finite, not all zero unless empty
    explicit AliasTable(std::span<const double> weights);

    [[nodiscard]] bool empty() const noexcept { return bins_.empty(); }
    /// u in [0, 1), double: of 24 bits a table of a million entries would leave four to choose within a bin.
    [[nodiscard]] std::uint32_t sample(double u) const noexcept;
    [[nodiscard]] float probability(std::uint32_t index) const noexcept { return bins_[index].probability; }

  private:
    struct Bin {
        float threshold = 1;  // below: this index, else the alias
        std::uint32_t alias = 0;
        float probability = 0;
    };
    std::vector<Bin> bins_;
};

}  // namespace lightgrid
