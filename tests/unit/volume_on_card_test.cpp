// lightgrid.glsl in a real OpenGL against the Sampler: what an engine's pixels get.

#include "probes/bake.h"
#include "tests/scene_builder.h"
#include "tests/unit/card.h"
#include "tests/unit/random_volume.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <vector>

namespace lightgrid {
namespace {

/// A room of 4 m with a lamp, a crate and a thin wall, in probes half a metre apart; a few of them are inside the crate.
Volume baked_room() {
    Scene room;
    const int wall = add_grey(room, 0.5F);
    const int lamp = add_grey(room, 0, 10);
    add_box(room, wall, {0, 0, 0}, {4, 4, 4}, Facing::inward);
    add_box(room, wall, {2.3F, 0, 2.2F}, {3.8F, 1.2F, 3.7F}, Facing::outward);
    add_box(room, wall, {1.2F, 0, 0}, {1.3F, 2.5F, 4}, Facing::outward);
    add_quad(room, lamp, {2, 3.9F, 1.5F}, {1, 0, 0}, {0, 0, 1});
    const Tracer tracer(room);
    const Environment dark;
    const PathTracer paths(tracer, dark);
    BakeOptions options;
    options.placement.spacing = 0.5;
    options.target.samples = 256;
    options.measure_error = false;
    return run_bake(paths, plan_bake(paths, options), options).volume;
}

TEST(VolumeOnCard, AnswersAsTheSamplerDoes) {
    Card card;
    for (int bands = 1; bands <= 3; ++bands) {
        Volume small = random_volume({coarse_grid, fine_grid}, bands, any_state);
        EXPECT_LT(differences(card, small, pack_volume(small)).back(), 1e-3) << bands << " bands, dense";
        thin_out(small);
        EXPECT_LT(differences(card, small, pack_volume(small)).back(), 1e-3) << bands << " bands, sparse";
    }
}

TEST(VolumeOnCard, AnswersOutsideAsTheSamplerDoes) {
    Card card;
    for (unsigned seed = 0; seed < 4; ++seed) {
        const Volume volume = random_sparse_volume(seed, 3);
        const VolumeTextures textures = pack_volume(volume);
        const std::vector<Query> queries = queries_around(volume, textures.origin, card_points);
        const std::vector<double> sorted = differences(card, volume, textures, queries);
        // Light jumps between cells whose common corners are all missing, and float may see a point on the other side.
        EXPECT_LT(sorted[sorted.size() - 2], 1e-3) << "volume " << seed;
    }
}

TEST(VolumeOnCard, AnswersAsTheSamplerDoesInALevel) {
    Card card;
    const Grid wide{{12345.6, -20, 54321.7}, {0.5, 0.7, 0.6}, {130, 9, 110}};
    const Volume level = random_volume({wide}, 3, mostly_valid);
    const std::vector<double> exact = differences(card, level, pack_volume(level));
    fmt::print("128,700 probes: {}\n", spread(exact));
    EXPECT_LT(exact.back(), 1e-3);
    const std::vector<double> half = differences(card, level, pack_volume(level, {.half = true}));
    fmt::print("as half: {}\n", spread(half));
    EXPECT_LT(half.back(), 5 * 0x1p-11);
}

TEST(VolumeOnCard, FilteredByHardwareIsNearWhereAllIsKnown) {
    Card card;
    const Volume volume = random_volume({fine_grid}, 3, all_valid);
    const std::vector<double> filtered = differences(card, volume, pack_filtered(volume));
    fmt::print("filtered by hardware, all valid, noise for light: {}\n", spread(filtered));
    // Weights may be rounded to 8 bits, off by 2^-9 along each axis; neighbours differ by their own size and more.
    EXPECT_LT(filtered[filtered.size() / 2], 3 * 0x1p-8);
    EXPECT_LT(filtered[filtered.size() * 99 / 100], 3 * 0x1p-5);
}

TEST(VolumeOnCard, FilteredByHardwareLeaksThroughWhatIsFilled) {
    Card card;
    const Volume room = baked_room();
    ASSERT_TRUE(is_dense(room));
    const std::vector<double> exact = differences(card, room, pack_volume(room));
    const std::vector<double> filtered = differences(card, room, pack_filtered(room));
    fmt::print("a baked room, exact: {}\n", spread(exact));
    fmt::print("a baked room, filtered by hardware: {}\n", spread(filtered));
    EXPECT_LT(exact.back(), 1e-3);
    EXPECT_LT(filtered[filtered.size() / 2], 0.01) << "most points have valid probes only around them";
    EXPECT_GT(filtered.back(), 0.01) << "else nothing is measured here";
}

}  // namespace
}  // namespace lightgrid
