#pragma once

#include "probes/volume.h"

#include <glm/glm.hpp>

#include <cstddef>
#include <span>
#include <vector>

/// Where a volume needs more probes: which blocks of cells are divided, and the bricks that this takes.
///
/// A block is 2^3 cells of a grid. Divided, its cells become 4^3 of a grid over the same box at half the spacing: one
/// brick, and those beside it towards +x, +y, +z, which hold the far corners of its last cells.
namespace lightgrid {

struct Block {
    int grid = 0;
    glm::ivec3 at{0};   // its first cell is 2 at
    double square = 0;  // its part of the squared error of interpolation; an unbiased estimate: negative at times
    int points = 0;     // that it is from
    int open = 0;       // of these, in free space
    bool divided = false;
};

/// Cells of a block, by their lower corners: 8 but at the far faces of the grid's box.
[[nodiscard]] std::vector<glm::ivec3> cells_of(const Grid& grid, const Block& block);
/// All blocks of a grid.
[[nodiscard]] std::vector<Block> blocks_of(const Volume& volume, int grid);
/// What a block becomes in `finer`, the grid at half the spacing.
[[nodiscard]] std::vector<Block> divide(const Volume& volume, const Block& block, int finer);

/// Over the same box at half the spacing.
[[nodiscard]] Grid at_half_spacing(const Grid& grid);

/// Bricks of `finer` without which its cells in the block are not its own.
[[nodiscard]] std::vector<Brick> bricks_over(const Volume& volume, const Block& block, int finer);

struct Division {
    std::vector<std::size_t> blocks;  // to divide now, those that promise most first
    double rest = 0;                  // squared error that is expected in the end
    double probes = 0;                // that this takes, expected
};

/// The blocks whose division promises most for each new probe, as many as take the squared error to `goal`, or as
/// `most_probes` pay for.
///
/// That which is left of the square of a divided block is expected to be `gain` times less, evenly spread, and divided
/// again where that still promises as much: what one block needs in the end decides whether it is worth the start.
///
/// levels_left  by grid: how often its blocks can be divided, one in another
[[nodiscard]] Division choose_blocks(std::span<const Block> blocks, std::span<const int> levels_left, double gain,
                                     double goal, double most_probes);

}  // namespace lightgrid
