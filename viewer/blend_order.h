#pragma once

#include "viewer/eye.h"
#include "viewer/level_mesh.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace lightgrid {

/// What lets light through, to be drawn in this order.
struct BlendOrder {
    std::vector<LevelDraw> draws;        // each in one place; first_index counts in `indices`
    std::vector<std::uint32_t> indices;  // three a triangle, into LevelMesh::vertices
};

/// Beyond, a picture would wait for the sorting: triangles stay in the order of the mesh, and draws alone are sorted.
inline constexpr std::size_t most_sorted_triangles = 200'000;

/// Of these draws, what the eye can see of them, the farthest first: draws by the mean distance of their triangles, and
/// in each of them the triangles, all by their centres. Where triangles of two draws lie between one another, or cut
/// one another, no order of draws is right.
[[nodiscard]] BlendOrder farthest_first(const LevelMesh& mesh, std::span<const std::size_t> draws, const Eye& eye);

}  // namespace lightgrid
