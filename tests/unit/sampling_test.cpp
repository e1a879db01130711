#include "core/sampling.h"

#include "tests/polygon_light.h"
#include "tests/sphere.h"

#include <glm/gtc/constants.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <numeric>
#include <set>

namespace lightgrid {
namespace {

constexpr double pi = glm::pi<double>();

/// The most that `count` counts may exceed their expectation by chance: 5 standard deviations of a binomial.
double five_sigma(double expected) {
    return 5 * std::sqrt(expected) + 1e-9;
}

TEST(Sampling, MixedBitsAreAllDifferentAndHalfOfThemChange) {
    std::set<std::uint64_t> seen;
    double flipped = 0;
    for (std::uint64_t value = 0; value < 4096; ++value) {
        seen.insert(mix_bits(7, value));
        flipped += std::popcount(mix_bits(7, value) ^ mix_bits(7, value + 1));
    }
    EXPECT_EQ(seen.size(), 4096U);
    EXPECT_NEAR(flipped / 4096, 32, 5 * 4 / std::sqrt(4096.0));
}

TEST(Sampling, UnitNumbersReachZeroButNeverOne) {
    EXPECT_EQ(to_unit(0), 0);
    EXPECT_EQ(to_unit(0xffffffffU), 1 - 0x1p-24F);
    EXPECT_EQ(to_unit_double(0), 0);
    EXPECT_EQ(to_unit_double(~std::uint64_t{0}), 1 - 0x1p-53);
}

TEST(Sampling, EveryAlignedBlockOfSobolPointsIsANet) {
    // A (0, m, 2)-net has exactly one of its 2^m points in every elementary box of area 2^-m, whatever its shape.
    for (const std::uint64_t seed : {std::uint64_t{0}, mix_bits(1, 2), mix_bits(3, 4)}) {
        for (std::uint32_t m = 0; m <= 10; ++m) {
            const std::uint32_t size = 1U << m;
            for (const std::uint32_t block : {0U, 1U, 5U, 1000U}) {
                for (std::uint32_t columns_log = 0; columns_log <= m; ++columns_log) {
                    const std::uint32_t columns = 1U << columns_log;
                    const std::uint32_t rows = size / columns;
                    std::vector<bool> taken(size);
                    for (std::uint32_t i = 0; i < size; ++i) {
                        const glm::vec2 u = sobol_point(block * size + i, seed);
                        const auto x = static_cast<std::uint32_t>(u.x * static_cast<float>(columns));
                        const auto y = static_cast<std::uint32_t>(u.y * static_cast<float>(rows));
                        ASSERT_LT(x, columns);
                        ASSERT_LT(y, rows);
                        ASSERT_FALSE(taken[y * columns + x]) << "seed " << seed << " block " << block << " of " << size
                                                             << ", boxes " << columns << " x " << rows;
                        taken[y * columns + x] = true;
                    }
                }
            }
        }
    }
}

TEST(Sampling, ShufflingKeepsAlignedBlocksTogether) {
    for (std::uint32_t size = 2; size <= 1024; size *= 2) {
        std::vector<bool> taken(size);
        const std::uint32_t block = shuffled_index(3 * size, 99) / size;
        for (std::uint32_t i = 0; i < size; ++i) {
            const std::uint32_t index = shuffled_index(3 * size + i, 99);
            ASSERT_EQ(index / size, block);
            ASSERT_FALSE(taken[index % size]);
            taken[index % size] = true;
        }
    }
}

TEST(Sampling, OneSobolPointIsUniformOverSeeds) {
    // 64 x 64 boxes, 64 expected in each: the sum of squares follows chi-square with 4095 degrees of freedom.
    constexpr int boxes = 64;
    for (const std::uint32_t index : {0U, 1U, 37U}) {
        std::vector<int> counts(boxes * boxes);
        constexpr int draws = 64 * boxes * boxes;
        for (std::uint64_t draw = 0; draw < draws; ++draw) {
            const glm::vec2 u = sobol_point(index, mix_bits(11, draw));
            ++counts[static_cast<int>(u.y * boxes) * boxes + static_cast<int>(u.x * boxes)];
        }
        double chi_square = 0;
        for (const int count : counts) chi_square += (count - 64.0) * (count - 64.0) / 64;
        EXPECT_NEAR(chi_square, 4095, 5 * std::sqrt(2 * 4095.0)) << "index " << index;
    }
}

TEST(Sampling, AliasTableDrawsInProportion) {
    const std::vector<double> weights = {0, 1e-3, 5, 0.25, 0, 2, 2, 1e-6};
    const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
    const AliasTable table(weights);
    constexpr int draws = 1 << 20;
    std::vector<double> counts(weights.size());
    RandomStream random(5);
    for (int i = 0; i < draws; ++i) ++counts[table.sample(random.next_double())];
    for (std::uint32_t i = 0; i < weights.size(); ++i) {
        const double expected = draws * weights[i] / sum;
        EXPECT_NEAR(counts[i], expected, five_sigma(expected)) << i;
        EXPECT_NEAR(table.probability(i), weights[i] / sum, 1e-7) << i;
        if (weights[i] == 0) {
            EXPECT_EQ(counts[i], 0);
        }
    }
}

TEST(Sampling, AliasTableOfAMillionKeepsSmallShares) {
    // Half of the weight is on one entry of 2^20: 24 bits of u would leave four bits for the choice within a bin.
    constexpr std::uint32_t size = 1U << 20;
    std::vector<double> weights(size, 1.0 / size);
    weights[12345] = 1;
    const AliasTable table(weights);
    constexpr int draws = 1 << 20;
    double heavy = 0;
    double lower_half = 0;
    RandomStream random(6);
    for (int i = 0; i < draws; ++i) {
        const std::uint32_t index = table.sample(random.next_double());
        heavy += index == 12345 ? 1 : 0;
        lower_half += index != 12345 && index < size / 2 ? 1 : 0;
    }
    EXPECT_NEAR(heavy, 0.5 * draws, five_sigma(0.5 * draws));
    EXPECT_NEAR(lower_half, 0.25 * draws, five_sigma(0.25 * draws));
}

TEST(Sampling, AliasTableOfNothingIsEmpty) {
    EXPECT_TRUE(AliasTable().empty());
    EXPECT_TRUE(AliasTable(std::vector<double>{}).empty());
    EXPECT_TRUE(AliasTable(std::vector<double>{0, 0, 0}).empty());
    const AliasTable one(std::vector<double>{1e-300});
    EXPECT_EQ(one.sample(0), 0U);
    EXPECT_EQ(one.probability(0), 1);
}

TEST(Sampling, EvenDirectionsIntegrateSmoothFunctionsWell) {
    // Mean of 1, x, x^2, xy and of a step: 0, 1/3, 0 and 1/2.
    for (const std::uint32_t count : {1U, 2U, 64U, 1000U}) {
        const std::vector<glm::vec3> directions = even_directions(count);
        ASSERT_EQ(directions.size(), count);
        glm::dvec3 mean(0);
        glm::dvec3 squares(0);
        double upper = 0;
        for (const glm::vec3& d : directions) {
            EXPECT_NEAR(glm::length(d), 1, 2e-7);
            mean += glm::dvec3(d) / double(count);
            squares += glm::dvec3(d) * glm::dvec3(d) / double(count);
            upper += d.y > 0 ? 1.0 / count : 0;
        }
        if (count < 64) continue;
        for (int axis = 0; axis < 3; ++axis) {
            EXPECT_NEAR(mean[axis], 0, 2.0 / count);
            EXPECT_NEAR(squares[axis], 1.0 / 3, 2.0 / count);
        }
        EXPECT_NEAR(upper, 0.5, 1.0 / count);
    }
}

/// Mean, over many keys, of each of the nine products of two coordinates and the three coordinates themselves must be
/// those of a uniform direction, whatever direction is turned.
TEST(Sampling, ATurnedDirectionIsUniformOnTheSphere) {
    constexpr int turns = 100000;
    for (const glm::vec3& direction : even_directions(5)) {
        glm::dvec3 mean(0);
        glm::dmat3 products(0);
        std::vector<int> bands(32);  // y is uniform in [-1, 1] (Archimedes)
        for (std::uint64_t key = 0; key < turns; ++key) {
            const glm::mat3 rotation = random_rotation(mix_bits(3, key));
            const glm::dvec3 d(rotation * direction);
            mean += d / double(turns);
            products += glm::outerProduct(d, d) / double(turns);
            ++bands[std::min(31, static_cast<int>((d.y + 1) * 16))];
        }
        // Standard deviations: sqrt(1/3) of a coordinate, sqrt(4/45) of its square, sqrt(1/15) of a product.
        for (int i = 0; i < 3; ++i) {
            EXPECT_NEAR(mean[i], 0, 5 * std::sqrt(1.0 / 3 / turns));
            EXPECT_NEAR(products[i][i], 1.0 / 3, 5 * std::sqrt(4.0 / 45 / turns));
            EXPECT_NEAR(products[i][(i + 1) % 3], 0, 5 * std::sqrt(1.0 / 15 / turns));
        }
        for (const int count : bands) EXPECT_NEAR(count, turns / 32.0, five_sigma(turns / 32.0));
    }
}

TEST(Sampling, ARandomRotationIsARotation) {
    for (std::uint64_t key = 0; key < 1000; ++key) {
        const glm::mat3 rotation = random_rotation(key);
        EXPECT_NEAR(glm::determinant(rotation), 1, 1e-5);
        const glm::mat3 product = rotation * glm::transpose(rotation);
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) EXPECT_NEAR(product[i][j], i == j ? 1 : 0, 1e-6);
        }
    }
}

/// Mean of f over a mapping of 2^16 points of a net, which for a smooth f is within about 1e-4.
double mapped_mean(const std::function<double(glm::vec2)>& f) {
    constexpr std::uint32_t count = 1U << 16;
    double sum = 0;
    for (std::uint32_t i = 0; i < count; ++i) sum += f(sobol_point(i, mix_bits(8, 8)));
    return sum / count;
}

TEST(Sampling, SphereDirectionsHaveTheirDensity) {
    // Against exact quadrature of exp(x + 2y - z), which tells every direction from every other.
    const auto f = [](glm::dvec3 d) { return std::exp(d.x + 2 * d.y - d.z); };
    double exact = 0;
    for (const auto& [direction, weight] : sphere_quadrature(30)) exact += weight * f(direction);
    EXPECT_NEAR(4 * pi * mapped_mean([&](glm::vec2 u) { return f(glm::dvec3(sphere_direction(u))); }), exact,
                1e-4 * exact);
    const float last = 1 - 0x1p-24F;
    for (const glm::vec2 corner : {glm::vec2(0, 0), glm::vec2(last, 0), glm::vec2(0, last), glm::vec2(last, last)}) {
        EXPECT_NEAR(glm::length(sphere_direction(corner)), 1, 3e-7);
    }
}

TEST(Sampling, CosineDirectionsHaveTheirDensity) {
    std::mt19937_64 random(4);
    std::vector<glm::dvec3> normals = {{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {0, -1, 0}};
    for (int i = 0; i < 8; ++i) normals.push_back(random_direction(random));
    normals.push_back(glm::normalize(glm::dvec3(1e-4, 1e-5, -1)));  // near the seam of the frame
    for (const glm::dvec3& normal : normals) {
        // E[d] = 2/3 n and E[d d^T] = (1 + n n^T) / 4 of a cosine-weighted direction tell it from any other axis.
        glm::dvec3 mean(0);
        glm::dmat3 products(0);
        constexpr std::uint32_t count = 1U << 14;
        for (std::uint32_t i = 0; i < count; ++i) {
            const glm::dvec3 d(cosine_direction(glm::vec3(normal), sobol_point(i, mix_bits(2, 2))));
            ASSERT_NEAR(glm::length(d), 1, 1e-6);
            ASSERT_GT(glm::dot(d, normal), 0);
            mean += d / double(count);
            products += glm::outerProduct(d, d) / double(count);
        }
        for (int i = 0; i < 3; ++i) {
            EXPECT_NEAR(mean[i], 2.0 / 3 * normal[i], 1e-3);
            for (int j = 0; j < 3; ++j) {
                EXPECT_NEAR(products[i][j], ((i == j ? 1 : 0) + normal[i] * normal[j]) / 4, 1e-3);
            }
        }
    }
    const float last = 1 - 0x1p-24F;
    EXPECT_GT(glm::dot(cosine_direction(glm::vec3(0, 1, 0), {last, 0.3F}), glm::vec3(0, 1, 0)), 0)
        << "the lowest direction is still above the surface";
}

TEST(Sampling, TrianglePointsAreUniform) {
    // Moments of the uniform distribution over (b1, b2): 1/3, 1/6 and 1/12.
    EXPECT_NEAR(mapped_mean([](glm::vec2 u) { return triangle_point(u).x; }), 1.0 / 3, 1e-4);
    EXPECT_NEAR(mapped_mean([](glm::vec2 u) { return triangle_point(u).y; }), 1.0 / 3, 1e-4);
    EXPECT_NEAR(mapped_mean([](glm::vec2 u) { return triangle_point(u).x * triangle_point(u).x; }), 1.0 / 6, 1e-4);
    EXPECT_NEAR(mapped_mean([](glm::vec2 u) { return triangle_point(u).x * triangle_point(u).y; }), 1.0 / 12, 1e-4);
    EXPECT_NEAR(mapped_mean([](glm::vec2 u) {
                    const glm::vec2 b = triangle_point(u);
                    return b.x >= 0 && b.y >= 0 && b.x + b.y <= 1 ? 1.0 : 0.0;
                }),
                1, 0);
}

TEST(Sampling, SphericalTrianglesAreSampledEvenly) {
    EXPECT_NEAR(SphericalTriangle({3, 0, 0}, {0, 1, 0}, {0, 0, 0.1}).solid_angle(), pi / 2, 1e-12) << "an octant";
    EXPECT_EQ(SphericalTriangle({1, 0, 0}, {0, 1, 0}, {2, 2, 0}).solid_angle(), 0) << "edge-on";

    // Small, wide, thin, nearly a half space; both windings.
    const std::vector<std::vector<glm::dvec3>> triangles = {{{0, 0, 1}, {0.1, 0, 1}, {0, 0.1, 1}},
                                                            {{-1, 2, 0.1}, {4, -3, 0.2}, {-2, -2, 0.5}},
                                                            {{1, 0, 1}, {1, 5, 1}, {1, 5, 1.001}},
                                                            {{-100, -80, 0.01}, {0, 100, 0.01}, {100, -80, 0.01}}};
    for (const auto& t : triangles) {
        const SphericalTriangle triangle(t[0], t[1], t[2]);
        const double solid_angle = polygon_solid_angle(t, glm::dvec3(0));
        EXPECT_NEAR(triangle.solid_angle(), solid_angle, 1e-12);
        // The cosines to an axis that sees all of it add up to the irradiance of a polygon.
        for (const glm::dvec3 normal : {glm::dvec3(0, 0, 1), glm::normalize(t[0] + t[1] + t[2])}) {
            const double exact = polygon_irradiance(t, glm::dvec3(0), normal) / solid_angle;
            EXPECT_NEAR(mapped_mean([&](glm::vec2 u) { return glm::dot(triangle.sample(u), normal); }), exact, 2e-4);
        }
        // Either part of it gets its share.
        const glm::dvec3 middle = (t[1] + t[2]) / 2.0;
        const glm::dvec3 cut = glm::cross(t[0], middle);
        const double side = glm::dot(cut, t[1]);
        const double share = polygon_solid_angle({t[0], t[1], middle}, glm::dvec3(0)) / solid_angle;
        EXPECT_NEAR(mapped_mean([&](glm::vec2 u) { return glm::dot(cut, triangle.sample(u)) * side > 0 ? 1.0 : 0.0; }),
                    share, 2e-3);
        const float last = 1 - 0x1p-24F;
        for (const glm::vec2 corner :
             {glm::vec2(0, 0), glm::vec2(last, 0), glm::vec2(0, last), glm::vec2(last, last)}) {
            EXPECT_NEAR(glm::length(triangle.sample(corner)), 1, 1e-9);
        }
    }
}

TEST(Sampling, LuminanceIsThatOfRec709) {
    EXPECT_NEAR(luminance({1, 1, 1}), 1, 1e-6);
    EXPECT_NEAR(luminance({0, 1, 0}), 0.7152, 1e-6);
}

}  // namespace
}  // namespace lightgrid
