#include "probes/refine.h"

#include "probes/sampler.h"
#include "probes/target.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace lightgrid {
namespace {

constexpr double no_limit = std::numeric_limits<double>::infinity();

Volume small_volume() {
    return make_volume({{{1, 2, 3}, {1, 1, 1}, {6, 4, 3}}}, 1);  // 5 x 3 x 2 cells
}

TEST(Refine, BlocksHoldEveryCellOnce) {
    const Volume volume = small_volume();
    std::set<std::tuple<int, int, int>> cells;
    std::size_t count = 0;
    for (const Block& block : blocks_of(volume, 0)) {
        for (const glm::ivec3 cell : cells_of(volume.grids[0], block)) {
            EXPECT_TRUE(glm::all(glm::lessThan(cell, volume.grids[0].counts - 1)));
            cells.insert({cell.x, cell.y, cell.z});
            ++count;
        }
    }
    EXPECT_EQ(cells.size(), 5U * 3 * 2);
    EXPECT_EQ(count, cells.size());
}

TEST(Refine, FinerGridHasTheProbesOfTheCoarserAndThoseBetween) {
    const Grid grid = small_volume().grids[0];
    const Grid finer = at_half_spacing(grid);
    EXPECT_EQ(finer.counts, glm::ivec3(11, 7, 5));
    EXPECT_EQ(finer.position({4, 6, 2}), grid.position({2, 3, 1}));
    EXPECT_EQ(finer.position(finer.counts - 1), grid.position(grid.counts - 1));
}

TEST(Refine, ADividedBlockIsAnsweredForByItsBricksAlone) {
    for (const Block& block : blocks_of(small_volume(), 0)) {
        Volume volume = small_volume();
        std::vector<Grid> grids{volume.grids[0], at_half_spacing(volume.grids[0])};
        Volume more = make_volume(grids, {}, 1);
        more = make_volume(grids, bricks_over(more, block, 1), 1);
        for (glm::vec3& value : more.coefficients) value = glm::vec3(1);
        append(volume, more);
        check_volume(volume);
        const Sampler sampler(volume);
        std::size_t cells = 0;
        for (const Block& part : divide(volume, block, 1)) {
            for (const glm::ivec3 cell : cells_of(volume.grids[1], part)) {
                ++cells;
                for (const double u : {0.01, 0.5, 0.99}) {
                    const glm::dvec3 place = volume.grids[1].position(cell) + u * volume.grids[1].spacing;
                    EXPECT_EQ(sampler.sample(place).sh[0], glm::vec3(1)) << "the coarse grid is black";
                }
            }
        }
        EXPECT_EQ(cells, 8 * cells_of(volume.grids[0], block).size());
    }
}

TEST(Refine, AppendedBricksComeBeforeTheListAndKeepWhatWasThere) {
    Volume volume = make_volume({{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}}, 1, {{5, 5, 5}});
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) volume.coefficients[slot] = glm::vec3(float(slot));
    Volume more = make_volume({volume.grids[0], at_half_spacing(volume.grids[0])}, {{1, {0, 0, 0}}}, 1);
    more.offsets.assign(more.slots(), glm::vec3(0.125F));
    append(volume, more);
    check_volume(volume);
    EXPECT_EQ(volume.slots(), 2U * probes_per_brick + 1);
    EXPECT_EQ(volume.coefficients[7], glm::vec3(7));
    EXPECT_EQ(volume.coefficients.back(), glm::vec3(probes_per_brick)) << "the list's row";
    EXPECT_EQ(volume.offsets[0], glm::vec3(0)) << "none were moved before";
    EXPECT_EQ(volume.offsets[probes_per_brick], glm::vec3(0.125F));
    EXPECT_EQ(gather_position(volume, volume.list_start()), glm::dvec3(5));
}

std::vector<Block> blocks_with(std::vector<double> squares) {
    std::vector<Block> blocks;
    for (const double square : squares) blocks.push_back({0, {0, 0, 0}, square});
    return blocks;
}

TEST(Refine, NothingIsDividedWhereTheGoalIsMet) {
    const std::vector<int> levels{5};
    EXPECT_TRUE(choose_blocks(blocks_with({0.1, 0.2, -0.1}), levels, 4, 0.21, no_limit).blocks.empty());
}

TEST(Refine, TheWorstBlocksAreDividedFirstAndNoMoreThanTheGoalTakes) {
    const std::vector<int> one_level{1};
    const auto blocks = blocks_with({0.01, 1, 0.02, 0.5, -0.1});
    const Division division = choose_blocks(blocks, one_level, 4, 0.7, no_limit);
    EXPECT_EQ(division.blocks, (std::vector<std::size_t>{1})) << "1.43 - 0.75 is left";
    EXPECT_NEAR(division.rest, 0.68, 1e-12);
    EXPECT_EQ(choose_blocks(blocks, one_level, 4, 0.4, no_limit).blocks, (std::vector<std::size_t>{1, 3}));
}

TEST(Refine, ProbesAreALimit) {
    const std::vector<int> one_level{1};
    const Division division = choose_blocks(blocks_with({1, 2, 3, 4}), one_level, 4, 0, 2.5 * 2 * probes_per_brick);
    EXPECT_EQ(division.blocks, (std::vector<std::size_t>{3, 2}));
    EXPECT_TRUE(choose_blocks(blocks_with({1, 2}), one_level, 4, 0, 0).blocks.empty());
}

TEST(Refine, WhatIsDividedOrMayNotBeIsLeftAlone) {
    std::vector<Block> blocks = blocks_with({1, 1, 1});
    blocks[0].divided = true;
    blocks[1].grid = 1;
    const std::vector<int> levels{1, 0};
    EXPECT_EQ(choose_blocks(blocks, levels, 4, 0, no_limit).blocks, (std::vector<std::size_t>{2}));
}

TEST(Target, NoiseFillsWhatTheTargetLeaves) {
    const Target target{{}, 0.1, {}};
    const double aimed = aimed_error(target);
    EXPECT_LT(aimed, 0.1);
    const double rest = interpolation_goal(target, 0);
    EXPECT_NEAR(std::hypot(rest, noise_goal(target, rest)), aimed, 1e-12);
    const double bands = 0.04;
    EXPECT_LT(std::hypot(bands, interpolation_goal(target, bands)), aimed);
}

TEST(Target, NoiseIsAQuarterOfWhatCannotBeReached) {
    const Target target{{}, 0.02, {}};
    EXPECT_NEAR(noise_goal(target, 0.4), 0.1, 1e-12);
    EXPECT_NEAR(interpolation_goal(target, 0.4), 0.2, 1e-12) << "no finer than bands are worth";
}

TEST(Target, NoiseIsNoMoreThanTheDefaultErrorWhateverTheRestIs) {
    EXPECT_EQ(noise_goal({}, 0.5), default_error);
    EXPECT_EQ(noise_goal({}, 0.02), default_noise);
}

TEST(Target, SamplesFollowFromTheLawOfNoise) {
    const NoiseLaw law{0.01, 1024, 1.25};
    const std::uint32_t samples = samples_for(law, 0.05, 1U << 20);
    EXPECT_EQ(samples % GatherOptions{}.replicates, 0U);
    EXPECT_LE(law.at(samples), 0.05 * 0.05);
    EXPECT_GT(law.at(samples - GatherOptions{}.replicates), 0.05 * 0.05);
    EXPECT_EQ(samples_for(law, 1e-9, 4096), 4096U);
    EXPECT_EQ(samples_for({0, 1024, 1}, 0.01, 4096), 64U) << "no noise: 4 rays for each replicate";
}

}  // namespace
}  // namespace lightgrid
