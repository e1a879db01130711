#include "probes/known_cells.h"

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <tuple>
#include <utility>

namespace lightgrid {
namespace {

/// Cells of a grid by their lower corners: low <= cell < high.
struct CellBox {
    glm::ivec3 low{0};
    glm::ivec3 high{0};
};

/// Joins boxes that touch along an axis and are alike along the others.
void join(std::vector<CellBox>& boxes, int axis) {
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    const auto across = [&](const CellBox& box) {
        return std::tuple(box.low[v], box.high[v], box.low[u], box.high[u]);
    };
    std::sort(boxes.begin(), boxes.end(), [&](const CellBox& a, const CellBox& b) {
        return std::pair(across(a), a.low[axis]) < std::pair(across(b), b.low[axis]);
    });
    std::size_t kept = 0;
    for (std::size_t i = 1; i < boxes.size(); ++i) {
        CellBox& last = boxes[kept];
        if (across(last) == across(boxes[i]) && last.high[axis] == boxes[i].low[axis]) {
            last.high[axis] = boxes[i].high[axis];
        } else {
            boxes[++kept] = boxes[i];
        }
    }
    if (!boxes.empty()) boxes.resize(kept + 1);
}

void join(std::vector<CellBox>& boxes) {
    for (int axis = 0; axis < 3; ++axis) join(boxes, axis);
}

/// The probes of a brick and those that follow it along each axis: the corners of the cells whose lower ones it holds.
class BrickCorners {
  public:
    BrickCorners(const Volume& volume, const SlotTable& slots, const Brick& brick) {
        const glm::ivec3 last = volume.grids[brick.grid].counts - 1;
        for (int i = 0; i < side * side * side; ++i) {
            const glm::ivec3 at(i % side, i / side % side, i / (side * side));
            const std::ptrdiff_t slot = slots.slot(brick.grid, glm::min(brick.origin + at, last));
            if (slot == SlotTable::none) continue;
            const ProbeState state = volume.states[static_cast<std::size_t>(slot)];
            corners_[i] = is_valid(state) || state == ProbeState::filled ? Corner::answers : Corner::silent;
        }
    }

    /// cell  by its lower corner, relative to the brick
    [[nodiscard]] bool knows_light(glm::ivec3 cell) const {
        bool answers = false;
        for (int corner = 0; corner < 8; ++corner) {
            const glm::ivec3 at = cell + glm::ivec3(corner & 1, corner >> 1 & 1, corner >> 2);
            const Corner found = corners_[(at.z * side + at.y) * side + at.x];
            if (found == Corner::absent) return false;
            answers = answers || found == Corner::answers;
        }
        return answers;
    }

  private:
    enum class Corner : std::uint8_t { absent, silent, answers };
    static constexpr int side = brick_size + 1;
    std::array<Corner, side * side * side> corners_{};
};

std::vector<std::vector<CellBox>> boxes_by_grid(const Volume& volume, const SlotTable& slots) {
    std::vector<std::vector<CellBox>> boxes(volume.grids.size());
    std::vector<CellBox> in_brick;
    for (const Brick& brick : volume.bricks) {
        const BrickCorners corners(volume, slots, brick);
        const glm::ivec3 cells = glm::max(volume.grids[brick.grid].counts - 1, 1);
        const glm::ivec3 size = glm::min(cells - brick.origin, brick_size);
        in_brick.clear();
        for (std::size_t p = 0; p < probes_per_brick; ++p) {
            const glm::ivec3 cell = probe_in_brick(p);
            if (glm::any(glm::greaterThanEqual(cell, size)) || !corners.knows_light(cell)) continue;
            in_brick.push_back({brick.origin + cell, brick.origin + cell + 1});
        }
        if (in_brick.size() == static_cast<std::size_t>(size.x) * size.y * size.z) {
            if (!in_brick.empty()) in_brick = {{brick.origin, brick.origin + size}};
        } else {
            join(in_brick);
        }
        boxes[brick.grid].insert(boxes[brick.grid].end(), in_brick.begin(), in_brick.end());
    }
    for (std::vector<CellBox>& of_grid : boxes) join(of_grid);
    return boxes;
}

using Node = KnownCells::Node;

bool contains(const Node& outer, const Node& inner) {
    return glm::all(glm::lessThanEqual(outer.low, inner.low)) && glm::all(glm::lessThanEqual(inner.high, outer.high));
}

/// Halves the leaves at the middle of their widest extent until each is alone.
void build(std::vector<Node>& nodes, std::size_t root, std::span<Node> leaves) {
    if (leaves.size() == 1) {
        nodes[root] = leaves.front();
        return;
    }
    Node bounds = leaves.front();
    for (const Node& leaf : leaves) {
        bounds.low = glm::min(bounds.low, leaf.low);
        bounds.high = glm::max(bounds.high, leaf.high);
    }
    const glm::dvec3 size = bounds.high - bounds.low;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const std::size_t half = leaves.size() / 2;
    std::nth_element(
        leaves.begin(), leaves.begin() + static_cast<std::ptrdiff_t>(half), leaves.end(),
        [axis](const Node& a, const Node& b) { return a.low[axis] + a.high[axis] < b.low[axis] + b.high[axis]; });
    const std::size_t children = nodes.size();
    bounds.link = static_cast<std::int32_t>(children);
    nodes[root] = bounds;
    nodes.resize(children + 2);
    build(nodes, children, leaves.first(half));
    build(nodes, children + 1, leaves.subspan(half));
}

std::vector<Node> tree_of(std::vector<Node> leaves) {
    if (leaves.empty()) return {};
    std::vector<Node> nodes(1);
    nodes.reserve(2 * leaves.size() - 1);
    build(nodes, 0, leaves);
    return nodes;
}

/// True if a leaf of another grid contains this one; of two that are the same, the first grid's does.
bool is_within_another(const std::vector<Node>& nodes, std::size_t root, const Node& leaf) {
    const Node& node = nodes[root];
    if (!contains(node, leaf)) return false;
    if (node.link < 0) return node.link != leaf.link && (!contains(leaf, node) || node.link > leaf.link);
    const auto child = static_cast<std::size_t>(node.link);
    return is_within_another(nodes, child, leaf) || is_within_another(nodes, child + 1, leaf);
}

/// No distance where it is but the rounding of positions: the position and the face are each off by half a unit in the
/// last place.
double squared_distance(const Node& node, glm::dvec3 position) noexcept {
    constexpr double unit = std::numeric_limits<double>::epsilon();
    const glm::dvec3 nearest = glm::clamp(position, node.low, node.high);
    const glm::dvec3 off = glm::abs(position - nearest);
    const glm::dvec3 slack = unit * (glm::abs(position) + glm::abs(nearest));
    double sum = 0;
    for (int axis = 0; axis < 3; ++axis) sum += off[axis] > slack[axis] ? off[axis] * off[axis] : 0;
    return sum;
}

}  // namespace

KnownCells find_known_cells(const Volume& volume, const SlotTable& slots) {
    const std::vector<std::vector<CellBox>> boxes = boxes_by_grid(volume, slots);
    std::vector<Node> leaves;
    for (std::size_t grid = 0; grid < boxes.size(); ++grid) {
        const glm::ivec3 last = volume.grids[grid].counts - 1;
        for (const CellBox& box : boxes[grid]) {
            leaves.push_back({volume.grids[grid].position(box.low),
                              volume.grids[grid].position(glm::min(box.high, last)),
                              -1 - static_cast<std::int32_t>(grid)});
        }
    }
    std::vector<Node> nodes = tree_of(leaves);
    if (volume.grids.size() > 1) {
        const auto within = [&](const Node& leaf) { return is_within_another(nodes, 0, leaf); };
        leaves.erase(std::remove_if(leaves.begin(), leaves.end(), within), leaves.end());
        nodes = tree_of(std::move(leaves));
    }
    return {std::move(nodes)};
}

std::optional<NearestKnown> nearest_known(const KnownCells& cells, glm::dvec3 position) noexcept {
    if (cells.nodes.empty()) return {};
    std::array<std::int32_t, most_waiting_nodes> waiting;  // NOLINT: written before it is read
    waiting[0] = 0;
    int count = 1;
    const Node* best = nullptr;
    double least = 0;
    while (count > 0) {
        const Node& node = cells.nodes[waiting[--count]];
        const double distance = squared_distance(node, position);
        if (best != nullptr && !(distance < least)) continue;  // the first leaf counts even if its square overflows
        if (node.link < 0) {
            best = &node;
            least = distance;
            continue;
        }
        const bool second_is_nearer =
            squared_distance(cells.nodes[node.link + 1], position) < squared_distance(cells.nodes[node.link], position);
        waiting[count++] = node.link + (second_is_nearer ? 0 : 1);
        waiting[count++] = node.link + (second_is_nearer ? 1 : 0);
    }
    return NearestKnown{glm::clamp(position, best->low, best->high), least, static_cast<std::size_t>(-1 - best->link),
                        best->low, best->high};
}

}  // namespace lightgrid
