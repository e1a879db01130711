#pragma once

#include "probes/volume.h"

#include <glm/glm.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

/// Where a volume knows light, and which such point is nearest to any other.
namespace lightgrid {

/// A cell knows light if all its corners are stored and one of them at least is valid or filled. (A grid with a single
/// probe along an axis has cells without thickness there.) The cells of a grid that do are joined to boxes; boxes within
/// boxes of other grids are left out, so that where a coarse grid is whole, its box stands alone. The rest are the
/// leaves of a binary tree of bounding boxes.
struct KnownCells {
    struct Node {
        glm::dvec3 low{0};  // bounds, metres, in the level's coordinates
        glm::dvec3 high{0};
        std::int32_t link = 0;  // first of two children, which are neighbours; of a leaf: -1 - its grid
    };
    std::vector<Node> nodes;  // the root first; empty: no cell knows light
};

/// How far, in sizes of its cell, look-ups on a face move in from it where no corner of the face answers.
inline constexpr double border_share = 0x1p-10;

/// Cost: about a microsecond for each brick.
[[nodiscard]] KnownCells find_known_cells(const Volume& volume, const SlotTable& slots);

/// Nodes wait in a stack of this many: one for each level of the tree, whose halves differ by one leaf at most.
inline constexpr int most_waiting_nodes = 40;

struct NearestKnown {
    glm::dvec3 point;  // the position itself within a cell that knows light
    double squared_distance;
    std::size_t grid;
    glm::dvec3 low;  // of the box of that grid's cells that the point belongs to
    glm::dvec3 high;
};

/// Nothing where no cell knows light. Near boxes are looked into first: the work grows as the logarithm of their number,
/// and allocates nothing.
///
/// position  any but NaN
[[nodiscard]] std::optional<NearestKnown> nearest_known(const KnownCells& cells, glm::dvec3 position) noexcept;

}  // namespace lightgrid
