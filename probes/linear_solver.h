#pragma once

#include <glm/glm.hpp>

#include <functional>
#include <span>
#include <vector>

namespace lightgrid {

/// y = A x, for the three colours at once.
using ColorOperator = std::function<void(std::span<const glm::dvec3> x, std::span<glm::dvec3> y)>;

struct Solution {
    std::vector<glm::dvec3> x;
    double residual = 0;  // |b - A x| / |b|, Euclidean, of the colour where it is largest; measured, not estimated
    int sweeps = 0;       // applications of A
};

/// Solves A x = b for each colour by GMRES (Saad, Schultz 1986), restarted, with the colours' Krylov spaces side by
/// side so that all share the sweeps. The residual never grows from one sweep to the next. The same bits for any
/// thread count.
///
/// a            square, of the size of b, not singular
/// tolerance    of the residual, > 0
/// most_sweeps  ends there even so: see the residual
[[nodiscard]] Solution solve_linear(const ColorOperator& a, std::span<const glm::dvec3> b, double tolerance,
                                    int most_sweeps);

}  // namespace lightgrid
