#include "probes/refine.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lightgrid {
namespace {

constexpr int block_cells = 2;  // along each axis
static_assert(2 * block_cells == brick_size);

/// New probes for each block: its brick, and as much again for those beside it, which blocks that lie together share.
constexpr double probes_per_block = 2 * probes_per_brick;
constexpr int bisections = 60;

/// What becomes of a block where every division has to promise `least` of squared error for each probe.
struct Outlook {
    int divisions = 0;
    double rest = 0;
    double probes = 0;
};

Outlook outlook(double square, int levels, double gain, double least) {
    Outlook result{0, square, 0};
    double blocks = 1;
    while (result.divisions < levels) {
        const double cost = blocks * probes_per_block;
        if (!(result.rest * (1 - 1 / gain) > least * cost)) break;
        ++result.divisions;
        result.rest /= gain;
        result.probes += cost;
        blocks *= 8;
    }
    return result;
}

}  // namespace

std::vector<glm::ivec3> cells_of(const Grid& grid, const Block& block) {
    std::vector<glm::ivec3> cells;
    for (int i = 0; i < block_cells * block_cells * block_cells; ++i) {
        const glm::ivec3 cell = block_cells * block.at + glm::ivec3(i & 1, i >> 1 & 1, i >> 2);
        if (glm::all(glm::lessThan(cell, grid.counts - 1))) cells.push_back(cell);
    }
    return cells;
}

std::vector<Block> blocks_of(const Volume& volume, int grid) {
    std::vector<Block> blocks;
    const glm::ivec3 count = (volume.grids[grid].counts - 1 + block_cells - 1) / block_cells;
    for (int z = 0; z < count.z; ++z) {
        for (int y = 0; y < count.y; ++y) {
            for (int x = 0; x < count.x; ++x) blocks.push_back({grid, {x, y, z}});
        }
    }
    return blocks;
}

std::vector<Block> divide(const Volume& volume, const Block& block, int finer) {
    std::vector<Block> parts;
    for (int i = 0; i < 8; ++i) {
        const Block part{finer, 2 * block.at + glm::ivec3(i & 1, i >> 1 & 1, i >> 2)};
        if (!cells_of(volume.grids[finer], part).empty()) parts.push_back(part);
    }
    return parts;
}

Grid at_half_spacing(const Grid& grid) {
    return {grid.origin, 0.5 * grid.spacing, 2 * (grid.counts - 1) + 1};
}

std::vector<Brick> bricks_over(const Volume& volume, const Block& block, int finer) {
    std::vector<Brick> bricks;
    for (int i = 0; i < 8; ++i) {
        const Brick brick{finer, brick_size * (block.at + glm::ivec3(i & 1, i >> 1 & 1, i >> 2))};
        if (glm::all(glm::lessThan(brick.origin, volume.grids[finer].counts))) bricks.push_back(brick);
    }
    return bricks;
}

Division choose_blocks(std::span<const Block> blocks, std::span<const int> levels_left, double gain, double goal,
                       double most_probes) {
    double total = 0;
    double largest = 0;
    for (const Block& block : blocks) {
        if (block.divided) continue;
        total += block.square;
        largest = std::max(largest, block.square);
    }
    const auto with = [&](double least) {
        Division division;
        division.rest = total;
        for (std::size_t i = 0; i < blocks.size(); ++i) {
            if (blocks[i].divided) continue;
            const Outlook result = outlook(blocks[i].square, levels_left[blocks[i].grid], gain, least);
            if (result.divisions == 0) continue;
            division.blocks.push_back(i);
            division.rest -= blocks[i].square - result.rest;
            division.probes += result.probes;
        }
        return division;
    };
    if (!(total > goal)) return {{}, total, 0};

    // Between asking the most of each probe, which divides nothing, and next to nothing: where the goal is met, or the
    // probes are spent.
    double most = std::log(largest);
    double least = most + std::log(std::numeric_limits<double>::epsilon());
    for (int i = 0; i < bisections; ++i) {
        const double middle = 0.5 * (least + most);
        const Division tried = with(std::exp(middle));
        (tried.rest <= goal || tried.probes > most_probes ? least : most) = middle;
    }
    Division division = with(std::exp(least));
    if (division.probes > most_probes) division = with(std::exp(most));
    std::stable_sort(division.blocks.begin(), division.blocks.end(),
                     [&](std::size_t a, std::size_t b) { return blocks[a].square > blocks[b].square; });
    return division;
}

}  // namespace lightgrid
