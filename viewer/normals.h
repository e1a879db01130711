#pragma once

#include <glm/glm.hpp>

#include <array>
#include <span>
#include <vector>

namespace lightgrid {

/// Faces that share an edge and turn by more than this there have an edge that is meant to be seen.
inline constexpr double crease_deg = 60;

/// Unit normals at the three corners of each triangle, of its front (counter-clockwise) side: the mean over the faces
/// around the point, weighted by their angles there, so that it does not depend on how a flat face is cut. Faces count
/// together where edges at the point join them that are not creases. Points are the same where their positions are.
///
/// Source: Thuermer, Wuethrich, "Computing Vertex Normals from Polygonal Facets", 1998.
///
/// triangles  indices into `positions`; those without area get the normals of what they join, or +Y
[[nodiscard]] std::vector<std::array<glm::vec3, 3>> corner_normals(std::span<const glm::vec3> positions,
                                                                   std::span<const glm::uvec3> triangles,
                                                                   double crease = crease_deg);

}  // namespace lightgrid
