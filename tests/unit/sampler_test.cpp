#include "probes/sampler.h"

#include "core/error.h"
#include "core/sh.h"
#include "tests/unit/random_volume.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace lightgrid {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

// One band that is a function of the lattice position.
template <typename Function>
Volume volume_of(std::vector<Grid> grids, Function light, int bands = 1) {
    Volume volume = make_volume(std::move(grids), bands);
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        if (volume.states[slot] == ProbeState::absent) continue;
        for (std::size_t i = 0; i < volume.sh_size(); ++i) {
            volume.coefficients[slot * volume.sh_size() + i] = light(lattice_position(volume, slot), i);
        }
    }
    return volume;
}

glm::vec3 linear(glm::dvec3 p, std::size_t i) {
    return {1 + p.x + 2 * p.y - 3 * p.z + i, 4 - 0.5 * p.x, 0.25 * p.y * (1.0 + i)};
}

glm::vec3 light_at(const Sampler& sampler, glm::dvec3 position, const SampleOptions& options = {}) {
    return sampler.sample(position, options).sh[0];
}

void set(Volume& volume, glm::ivec3 probe, ProbeState state, glm::vec3 light) {
    const std::ptrdiff_t slot = SlotTable(volume).slot(0, probe);
    volume.states[slot] = state;
    volume.coefficients[slot * volume.sh_size()] = light;
}

TEST(Sampler, ReturnsProbesAtTheirPositionsToTheBit) {
    // Origins and spacings that no double holds exactly, near and far from zero, and light of all magnitudes.
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (const double far : {0.0, 0.1, 1234.567, 1e5, -1e7}) {
        const Grid grid{{far + 0.1, -far / 3, 0.7}, {0.1, 1.0 / 3, 0.07}, {9, 7, 5}};
        Volume volume = make_volume({grid}, 2);
        for (glm::vec3& v : volume.coefficients) {
            v = glm::vec3(std::pow(10.0, 8 * uniform(random)), uniform(random), -std::pow(10.0, 8 * uniform(random)));
        }
        const Sampler sampler(volume);
        for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
            if (volume.states[slot] == ProbeState::absent) continue;
            const Sample sample = sampler.sample(lattice_position(volume, slot));
            EXPECT_EQ(sample.weight, 1);
            for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(sample.sh[i], volume.sh(slot)[i]) << far << " slot " << slot;
        }
    }
}

TEST(Sampler, ReproducesLinearLight) {
    const Volume volume = volume_of({{{-2, 1, 3}, {0.5, 0.25, 1}, {9, 13, 6}}}, linear, 2);
    const Sampler sampler(volume);
    std::mt19937 random(2);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (int i = 0; i < 1000; ++i) {
        const glm::dvec3 p =
            glm::dvec3(-2, 1, 3) + glm::dvec3(uniform(random), uniform(random), uniform(random)) * glm::dvec3(4, 3, 5);
        const Sample sample = sampler.sample(p);
        EXPECT_FLOAT_EQ(sample.weight, 1);
        for (std::size_t k = 0; k < 4; ++k) {
            // Eight products and sums of floats up to 32.
            EXPECT_NEAR(glm::distance(sample.sh[k], linear(p, k)), 0, 32 * 8 * 0x1p-24)
                << p.x << " " << p.y << " " << p.z;
        }
    }
}

TEST(Sampler, KeepsUniformLightUniform) {
    const Volume volume =
        volume_of({{{0, 0, 0}, {1, 1, 1}, {4, 4, 4}}}, [](glm::dvec3, std::size_t) { return glm::vec3(3); });
    const Sampler sampler(volume);
    EXPECT_FLOAT_EQ(light_at(sampler, {0.3, 1.7, 2.2}).r, 3);
    EXPECT_FLOAT_EQ(sampler.irradiance({0.3, 1.7, 2.2}, {0, 1, 0}).r, 3 * std::sqrt(std::acos(-1.0F)) / 2);
}

TEST(Sampler, GivesInvalidCornersWeightToTheValidOnes) {
    Volume volume = volume_of({{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}}, linear);
    set(volume, {0, 0, 0}, ProbeState::missing, {nan, nan, nan});
    set(volume, {1, 0, 0}, ProbeState::filled, {1e6, 1e6, 1e6});
    const Sampler sampler(volume);
    const Sample sample = sampler.sample({0.5, 0.5, 0.5});
    EXPECT_FLOAT_EQ(sample.weight, 0.75F);
    glm::dvec3 mean(0);
    for (const glm::dvec3 p : {glm::dvec3(0, 1, 0), {1, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}}) {
        mean += glm::dvec3(linear(p, 0)) / 6.0;
    }
    EXPECT_NEAR(glm::distance(glm::dvec3(sample.sh[0]), mean), 0, 1e-6);
    // Moved probes are as good as any.
    set(volume, {0, 0, 0}, ProbeState::moved, {7, 7, 7});
    EXPECT_EQ(sampler.sample({0, 0, 0}).sh[0], glm::vec3(7));
}

TEST(Sampler, TakesFilledLightOnlyWhereNothingElseIs) {
    Volume volume = volume_of({{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}}, linear);
    for (int i = 0; i < 8; ++i) set(volume, {i & 1, i >> 1 & 1, i >> 2}, ProbeState::filled, glm::vec3(2));
    const Sampler sampler(volume);
    Sample sample = sampler.sample({0.25, 0.5, 0.75});
    EXPECT_FLOAT_EQ(sample.sh[0].r, 2);
    EXPECT_EQ(sample.weight, 0) << "filled is not known";
    set(volume, {1, 1, 1}, ProbeState::valid, glm::vec3(5));
    sample = sampler.sample({0.25, 0.5, 0.75});
    EXPECT_FLOAT_EQ(sample.sh[0].r, 5);
    EXPECT_FLOAT_EQ(sample.weight, 0.25F * 0.5F * 0.75F);
}

TEST(Sampler, SaysUnknownWhereNothingIsKnown) {
    Volume volume = volume_of({{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}}, linear);
    for (ProbeState& state : volume.states) {
        if (state != ProbeState::absent) state = ProbeState::missing;
    }
    const Sample sample = Sampler(volume).sample({0.5, 0.5, 0.5});
    EXPECT_EQ(sample.weight, 0);
    EXPECT_EQ(sample.sh[0], glm::vec3(0));
}

TEST(Sampler, AsksTheFinestGridWhereTheyOverlap) {
    const Grid coarse{{0, 0, 0}, {2, 2, 2}, {6, 6, 6}};
    const Grid fine{{2, 2, 2}, {0.5, 0.5, 0.5}, {9, 9, 9}};
    for (const bool fine_first : {false, true}) {
        Volume volume = make_volume(fine_first ? std::vector{fine, coarse} : std::vector{coarse, fine}, 1);
        for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
            const bool is_fine = volume.grids[volume.bricks[slot / probes_per_brick].grid].spacing.x == 0.5;
            volume.coefficients[slot] = glm::vec3(is_fine ? 1 : 2);
        }
        const Sampler sampler(volume);
        EXPECT_FLOAT_EQ(light_at(sampler, {3, 3, 3}).r, 1);
        EXPECT_FLOAT_EQ(light_at(sampler, {6, 6, 6}).r, 1) << "its far corner";
        EXPECT_FLOAT_EQ(light_at(sampler, {6.01, 6, 6}).r, 2);
        EXPECT_FLOAT_EQ(light_at(sampler, {-1, 3, 3}).r, 2) << "the nearest grid";
        // Where the fine one knows nothing, the coarse one does.
        for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
            if (volume.states[slot] != ProbeState::absent && volume.coefficients[slot].r == 1) {
                volume.states[slot] = ProbeState::filled;
            }
        }
        EXPECT_FLOAT_EQ(light_at(sampler, {3, 3, 3}).r, 2);
    }
}

TEST(Sampler, LeavesCellsWithoutTheirBricksToTheCoarserGrid) {
    const Grid fine{{0, 0, 0}, {1, 1, 1}, {8, 4, 4}};
    const Grid coarse{{0, 0, 0}, {8, 8, 8}, {2, 2, 2}};
    Volume whole = volume_of({fine, coarse}, linear);
    Volume volume = whole;
    volume.bricks.erase(volume.bricks.begin() + 1);  // fine probes with x from 4 to 7
    for (auto* values : {&volume.coefficients, &volume.errors}) {
        values->erase(values->begin() + probes_per_brick, values->begin() + 2 * probes_per_brick);
    }
    volume.axis_errors.resize(volume.coefficients.size() * 6);
    volume.states.erase(volume.states.begin() + probes_per_brick, volume.states.begin() + 2 * probes_per_brick);
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        volume.coefficients[slot] = glm::vec3(slot < probes_per_brick ? 1 : 2);
    }
    check_volume(volume);
    const Sampler sampler(volume);
    EXPECT_FLOAT_EQ(light_at(sampler, {2.5, 1, 1}).r, 1);
    EXPECT_FLOAT_EQ(light_at(sampler, {3, 1, 1}).r, 1) << "the last stored probe still answers for itself";
    EXPECT_FLOAT_EQ(light_at(sampler, {3.5, 1, 1}).r, 2);
}

TEST(Sampler, ClampsOutsideToTheNearestPoint) {
    const Volume volume = volume_of({{{0, 0, 0}, {1, 1, 1}, {5, 5, 5}}}, linear);
    const Sampler sampler(volume);
    for (const glm::dvec3 p : {glm::dvec3(-3, 2.5, 1.5), {2.5, 9, -1}, {1e9, 2, 2}}) {
        const glm::dvec3 inside = glm::clamp(p, glm::dvec3(0), glm::dvec3(4));
        EXPECT_EQ(light_at(sampler, p), light_at(sampler, inside));
    }
}

struct SlowSearch {
    double distance = std::numeric_limits<double>::infinity();
    glm::dvec3 point{0};
};

// Over all cells of all grids, one after the other.
SlowSearch nearest_cell_that_knows(const Volume& volume, const SlotTable& slots, glm::dvec3 position) {
    SlowSearch nearest;
    for (std::size_t g = 0; g < volume.grids.size(); ++g) {
        const Grid& grid = volume.grids[g];
        const glm::ivec3 last = grid.counts - 1;
        const glm::ivec3 cells = glm::max(last, 1);
        for (int i = 0; i < cells.x * cells.y * cells.z; ++i) {
            const glm::ivec3 lower(i % cells.x, i / cells.x % cells.y, i / (cells.x * cells.y));
            const glm::dvec3 point =
                glm::clamp(position, grid.position(lower), grid.position(glm::min(lower + 1, last)));
            const double distance = glm::distance(point, position);
            if (distance >= nearest.distance) continue;
            bool stored = true;
            bool knows = false;
            for (int corner = 0; corner < 8; ++corner) {
                const glm::ivec3 upper(corner & 1, corner >> 1 & 1, corner >> 2);
                const std::ptrdiff_t slot = slots.slot(g, glm::min(lower + upper, last));
                stored = stored && slot != SlotTable::none;
                knows =
                    knows || (stored && (is_valid(volume.states[slot]) || volume.states[slot] == ProbeState::filled));
            }
            if (stored && knows) nearest = {distance, point};
        }
    }
    return nearest;
}

TEST(Sampler, AnswersOutsideWithTheNearestPointThatKnowsLight) {
    int outside = 0;
    int beyond_all_grids = 0;
    for (unsigned seed = 0; seed < 40; ++seed) {
        const Volume volume = random_sparse_volume(seed, 1);
        const Sampler sampler(volume);
        const SlotTable slots(volume);
        const float far = 1000;
        const std::vector<glm::vec3> sky{glm::vec3(7)};
        const SampleOptions fade{.outside = Outside::fade, .fade_distance = far, .environment = sky};
        for (const Query& query : queries_around(volume, glm::dvec3(0), 1000)) {
            const glm::dvec3 position(query.position);
            const SlowSearch nearest = nearest_cell_that_knows(volume, slots, position);
            const Sample got = sampler.sample(position);
            const Sample wanted = sampler.sample(nearest.point);
            const auto where = [&] {
                return testing::Message()
                       << "volume " << seed << ", " << position.x << " " << position.y << " " << position.z;
            };
            EXPECT_NEAR(glm::distance(got.sh[0], wanted.sh[0]), 0, 1e-5) << where();
            EXPECT_NEAR(got.weight, wanted.weight, 1e-5) << where();
            EXPECT_GT(got.sh[0].r, 0) << where();
            const auto share = static_cast<float>(nearest.distance / far);
            EXPECT_NEAR(sampler.corners(position, fade).environment, share, 1e-6) << where();
            EXPECT_NEAR(light_at(sampler, position, fade).r, glm::mix(got.sh[0].r, 7.0F, share), 1e-5) << where();
            if (nearest.distance == 0) continue;
            ++outside;
            beyond_all_grids += std::all_of(volume.grids.begin(), volume.grids.end(), [&](const Grid& grid) {
                return glm::clamp(position, grid.origin, grid.position(grid.counts - 1)) != position;
            });
        }
    }
    EXPECT_GT(outside, 10000);
    EXPECT_GT(beyond_all_grids, 5000);
    EXPECT_GT(outside - beyond_all_grids, 2500) << "in holes of the grids";
}

TEST(Sampler, ChangesNothingOnTheWayOutOfARefinedVolume) {
    // A coarse grid, and a fine one over all of it that has a brick in one corner only: most of its faces are of bricks
    // that are not stored.
    const Grid coarse{{0, 0, 0}, {2, 2, 2}, {9, 9, 9}};
    const Grid fine{{0, 0, 0}, {1, 1, 1}, {17, 17, 17}};
    Volume volume = make_volume({coarse, fine}, {}, 1);
    for (const Brick& brick : make_volume({coarse, fine}, 1).bricks) {
        if (brick.grid == 1 && brick.origin != glm::ivec3(0)) continue;
        volume.bricks.push_back(brick);
    }
    volume = make_volume(volume.grids, volume.bricks, 1);
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        const glm::dvec3 p = lattice_position(volume, slot);
        volume.coefficients[slot] = glm::vec3(1 + p.x * p.y + p.z);
    }
    const Sampler sampler(volume);
    for (const glm::dvec3 face :
         {glm::dvec3(16, 5, 3.5), {0, 5, 3.5}, {0, 1, 1}, {1.5, 1.25, 0}, {7, 16, 9}, {16, 16, 16}}) {
        const glm::dvec3 outwards(face.x == 0    ? -1
                                  : face.x == 16 ? 1
                                                 : 0,
                                  face.y == 16 ? 1 : 0,
                                  face.z == 0    ? -1
                                  : face.z == 16 ? 1
                                                 : 0);
        const glm::vec3 wanted = light_at(sampler, face);
        EXPECT_GT(wanted.r, 0);
        for (const double distance : {1e-9, 0.001, 0.5, 30.0}) {
            const Sample sample = sampler.sample(face + distance * outwards);
            EXPECT_EQ(sample.sh[0], wanted) << face.x << " " << face.y << " " << face.z << " and " << distance << " m";
            EXPECT_EQ(sample.weight, 1);
        }
    }
}

TEST(Sampler, TakesTheCellsLightWhereItsFaceHasNone) {
    Volume volume = volume_of({{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}}, linear);
    for (ProbeState& state : volume.states) {
        if (state != ProbeState::absent) state = ProbeState::missing;
    }
    set(volume, {0, 0, 0}, ProbeState::valid, glm::vec3(3));
    const Sampler sampler(volume);
    for (const glm::dvec3 p : {glm::dvec3(0.9, 0.9, 0.9), {1, 0.5, 0.5}, {4, 0.5, 0.5}, {1, 1, 1}, {5, 6, 7}}) {
        const Sample sample = sampler.sample(p);
        EXPECT_FLOAT_EQ(sample.sh[0].r, 3) << p.x;
        EXPECT_GT(sample.weight, 0) << p.x;
    }
}

TEST(Sampler, FadesInHolesAndWhereNothingIsKnown) {
    // Two cells of a row of three; the third has no light.
    Volume volume =
        volume_of({{{0, 0, 0}, {1, 1, 1}, {5, 2, 2}}}, [](glm::dvec3, std::size_t) { return glm::vec3(1); });
    for (int i = 0; i < 4; ++i) {
        for (const int x : {3, 4}) set(volume, {x, i & 1, i >> 1}, ProbeState::missing, glm::vec3(nan));
    }
    const std::vector<glm::vec3> sky{glm::vec3(5)};
    const SampleOptions options{.outside = Outside::fade, .fade_distance = 2, .environment = sky};
    EXPECT_FLOAT_EQ(light_at(Sampler(volume), {3, 0.5, 0.5}, options).r, 1) << "of the cell that reaches so far";
    EXPECT_FLOAT_EQ(light_at(Sampler(volume), {3.5, 0.5, 0.5}, options).r, 2);
    for (ProbeState& state : volume.states) {
        if (state != ProbeState::absent) state = ProbeState::missing;
    }
    EXPECT_EQ(light_at(Sampler(volume), {0.5, 0.5, 0.5}, options), sky[0]);
    EXPECT_EQ(Sampler(volume).sample({0.5, 0.5, 0.5}).weight, 0);
    EXPECT_EQ(Sampler(volume).sample({9, 9, 9}).weight, 0);
}

TEST(Sampler, FadesOutsideToTheEnvironment) {
    const Volume volume =
        volume_of({{{0, 0, 0}, {1, 1, 1}, {3, 3, 3}}}, [](glm::dvec3, std::size_t) { return glm::vec3(1); });
    const Sampler sampler(volume);
    const std::vector<glm::vec3> sky{glm::vec3(5, 9, 1)};
    SampleOptions options{.outside = Outside::fade, .fade_distance = 2, .environment = sky};
    EXPECT_EQ(light_at(sampler, {2, 2, 2}, options), glm::vec3(1));
    EXPECT_FLOAT_EQ(light_at(sampler, {2.5, 1, 1}, options).r, 2);  // a quarter of the way from 1 to 5
    EXPECT_FLOAT_EQ(light_at(sampler, {1, -1, 1}, options).g, 5);
    EXPECT_EQ(light_at(sampler, {1, 4, 1}, options), sky[0]);
    EXPECT_EQ(sampler.sample({1, 99, 1}, options).weight, 1);
    options.environment = {};
    EXPECT_FLOAT_EQ(light_at(sampler, {2.5, 1, 1}, options).r, 0.75F);
    options.fade_distance = 0;
    EXPECT_EQ(light_at(sampler, {2, 2, 2}, options), glm::vec3(1));
    EXPECT_EQ(light_at(sampler, {2.001, 2, 2}, options), glm::vec3(0));
}

TEST(Sampler, HandlesGridsOfASingleProbeAlongAnAxis) {
    const Volume plane = volume_of({{{0, 5, 0}, {1, 1, 1}, {4, 1, 4}}}, linear);
    EXPECT_FLOAT_EQ(light_at(Sampler(plane), {1.5, 5, 2.5}).r, linear({1.5, 5, 2.5}, 0).r);
    EXPECT_FLOAT_EQ(light_at(Sampler(plane), {1.5, 7, 2.5}).r, linear({1.5, 5, 2.5}, 0).r);
    const Volume point = volume_of({{{1, 2, 3}, {1, 1, 1}, {1, 1, 1}}}, linear);
    EXPECT_EQ(light_at(Sampler(point), {1, 2, 3}), linear({1, 2, 3}, 0));
    EXPECT_EQ(light_at(Sampler(point), {9, 9, 9}), linear({1, 2, 3}, 0));
}

TEST(Sampler, MovesAlongTheNormalByTheBias) {
    const Volume volume = volume_of({{{0, 0, 0}, {1, 1, 1}, {5, 5, 5}}}, linear);
    const Sampler sampler(volume);
    const SampleOptions biased{.normal_bias = 0.5F};
    EXPECT_EQ(sampler.irradiance({2, 2, 2}, {0, 1, 0}, biased), sampler.irradiance({2, 2.5, 2}, {0, 1, 0}));
}

TEST(Sampler, NearestIsTheProbeThatIsNearest) {
    const Volume volume = volume_of({{{-1, 0, 2}, {0.5, 1, 0.25}, {7, 4, 5}}}, linear, 2);
    const Sampler sampler(volume);
    const SampleOptions nearest{.interpolation = Interpolation::nearest};
    for (const glm::dvec3 offset : {glm::dvec3(0), glm::dvec3(0.2, 0.45, -0.1), glm::dvec3(-0.24, -0.49, 0.12)}) {
        for (int i = 0; i < 7 * 4 * 5; ++i) {
            const glm::dvec3 probe = volume.grids[0].position({i % 7, i / 7 % 4, i / 28});
            const Sample sample = sampler.sample(probe + offset, nearest);  // some beyond the grid: clamped
            EXPECT_EQ(sample.sh[3], linear(probe, 3));
            EXPECT_EQ(sample.weight, 1);
        }
    }
}

TEST(Sampler, NearestLeavesOutProbesThatDoNotAnswer) {
    Volume volume = volume_of({{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}}, linear);
    set(volume, {0, 0, 0}, ProbeState::filled, glm::vec3(100));
    set(volume, {1, 0, 0}, ProbeState::missing, glm::vec3(200));
    const Sampler sampler(volume);
    const SampleOptions nearest{.interpolation = Interpolation::nearest};
    const Sample sample = sampler.sample({0.2, 0.4, 0.1}, nearest);
    EXPECT_EQ(sample.sh[0], linear({0, 1, 0}, 0)) << "the heaviest of the valid";
    EXPECT_FLOAT_EQ(sample.weight, 1 - 0.6F * 0.9F);
    EXPECT_EQ(light_at(sampler, {0.2, 0, 0}, nearest), glm::vec3(100)) << "no valid one carries weight";
}

TEST(Sampler, GivesTheSameInBatches) {
    const Volume volume = volume_of({{{-1, 0, 2}, {0.3, 0.4, 0.5}, {7, 6, 5}}}, linear, 3);
    const Sampler sampler(volume);
    std::mt19937 random(4);
    std::normal_distribution<double> normal;
    std::vector<glm::dvec3> positions;
    std::vector<glm::vec3> normals;
    for (int i = 0; i < 100; ++i) {
        positions.emplace_back(normal(random), 1 + normal(random), 3 + normal(random));
        normals.emplace_back(glm::normalize(glm::dvec3(normal(random), normal(random), normal(random))));
    }
    std::vector<glm::vec3> irradiance(positions.size());
    std::vector<glm::vec3> sh(positions.size() * 9);
    std::vector<float> weights(positions.size());
    sampler.irradiance(positions, normals, irradiance);
    sampler.sample(positions, sh, weights);
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const Sample single = sampler.sample(positions[i]);
        EXPECT_EQ(irradiance[i], sampler.irradiance(positions[i], normals[i]));
        EXPECT_EQ(irradiance[i], irradiance_from_sh(single.sh, normals[i]));
        EXPECT_EQ(weights[i], single.weight);
        for (std::size_t k = 0; k < 9; ++k) EXPECT_EQ(sh[i * 9 + k], single.sh[k]);
    }
}

TEST(Sampler, GivesTheSameInBatchesOutside) {
    for (unsigned seed = 0; seed < 4; ++seed) {
        const Volume volume = random_sparse_volume(seed, 2);
        const Sampler sampler(volume);
        const std::vector<glm::vec3> sky(4, glm::vec3(7));
        const SampleOptions options{.outside = Outside::fade, .fade_distance = 3, .environment = sky};
        std::vector<glm::dvec3> positions;
        for (const Query& query : queries_around(volume, glm::dvec3(0), 300)) positions.emplace_back(query.position);
        std::vector<glm::vec3> sh(positions.size() * 4);
        std::vector<float> weights(positions.size());
        sampler.sample(positions, sh, weights, options);
        for (std::size_t i = 0; i < positions.size(); ++i) {
            const Sample single = sampler.sample(positions[i], options);
            EXPECT_EQ(weights[i], single.weight);
            EXPECT_TRUE(
                std::equal(single.sh.begin(), single.sh.end(), sh.begin() + static_cast<std::ptrdiff_t>(4 * i)));
        }
    }
}

TEST(Sampler, MixesLayersAsMixingThemBeforeDoes) {
    Volume volume = volume_of({{{0, 0, 0}, {1, 1, 1}, {5, 4, 3}}}, linear, 3);
    std::mt19937 random(4);
    std::uniform_real_distribution<float> uniform(-1, 1);
    for (const char* name : {"a", "b", "c"}) {
        Layer layer{name, volume.coefficients, 0};
        for (glm::vec3& v : layer.coefficients) v = {uniform(random), uniform(random), uniform(random)};
        volume.layers.push_back(layer);
    }
    set(volume, {1, 1, 1}, ProbeState::filled, glm::vec3(0));
    const std::vector<glm::vec3> weights{{2, 0, 0.5F}, {1, -1, 3}, {0, 4, 0}};
    Volume mixed = volume;
    mixed.coefficients = mix_layers(volume, weights);
    const Sampler sampler(volume);
    const Sampler before(mixed);
    const std::vector<glm::vec3> sky(9, glm::vec3(0.5F));
    for (const Interpolation interpolation : {Interpolation::trilinear, Interpolation::nearest}) {
        SampleOptions options;
        options.outside = Outside::fade;
        options.environment = sky;
        options.interpolation = interpolation;
        SampleOptions with_layers = options;
        with_layers.layers = weights;
        std::uniform_real_distribution<double> place(-0.5, 4);
        for (int i = 0; i < 1000; ++i) {
            const glm::dvec3 p(place(random), place(random), place(random));
            const Sample a = sampler.sample(p, with_layers);
            const Sample b = before.sample(p, options);
            EXPECT_EQ(a.weight, b.weight);
            for (std::size_t k = 0; k < 9; ++k) {
                EXPECT_NEAR(glm::distance(a.sh[k], b.sh[k]), 0, 8 * 3 * 4 * 0x1p-24);  // of sums of 24 numbers up to 4
            }
            const glm::vec3 up(0, 1, 0);
            EXPECT_NEAR(glm::distance(sampler.irradiance(p, up, with_layers), before.irradiance(p, up, options)), 0,
                        1e-4);
        }
    }
    EXPECT_EQ(light_at(sampler, {1, 0, 0}), volume.sh(1)[0]) << "all light where no layers are asked for";
}

TEST(Sampler, KnowsNothingOfPlacesThatAreNoNumbers) {
    const Volume volume = volume_of({{{0, 0, 0}, {1, 1, 1}, {5, 5, 5}}}, linear);
    const Sampler sampler(volume);
    EXPECT_EQ(sampler.sample({nan, 1, 1}).weight, 0);
    const double infinite = std::numeric_limits<double>::infinity();
    EXPECT_EQ(sampler.sample({infinite, 1, -infinite}).weight, 1) << "very far outside";
}

TEST(Sampler, RefusesAProbeList) {
    const Volume list = make_probe_list({{0, 0, 0}}, 3);
    EXPECT_THROW(Sampler{list}, Error);
}

}  // namespace
}  // namespace lightgrid
