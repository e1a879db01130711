#pragma once

#include "core/image.h"

#include <glm/glm.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

/// Independent of what is tested: quadrature over the sphere and the first nine spherical harmonics in closed form.
namespace lightgrid {

using Sh9 = std::array<glm::dvec3, 9>;

inline std::array<double, 9> sh9_basis(glm::dvec3 d) {
    return {0.28209479177387814,
            0.4886025119029199 * d.y,
            0.4886025119029199 * d.z,
            0.4886025119029199 * d.x,
            1.0925484305920792 * d.x * d.y,
            1.0925484305920792 * d.y * d.z,
            0.31539156525252005 * (3 * d.z * d.z - 1),
            1.0925484305920792 * d.x * d.z,
            0.5462742152960396 * (d.x * d.x - d.y * d.y)};
}

/// Direction of a point of an equirectangular image: u, v in [0, 1], u = 1/2 is +X, u = 3/4 is +Z, v = 0 is +Y.
inline glm::dvec3 equirectangular_direction(double u, double v) {
    const double azimuth = 2 * std::numbers::pi * (u - 0.5);
    const double polar = std::numbers::pi * v;
    return {std::sin(polar) * std::cos(azimuth), std::cos(polar), std::sin(polar) * std::sin(azimuth)};
}

/// Calls visit(direction, solid angle) over a grid of equal angles, with exact solid angles.
template <typename Visit>
void over_sphere(int columns, int rows, const Visit& visit) {
    for (int j = 0; j < rows; ++j) {
        const double top = std::cos(std::numbers::pi * j / rows);
        const double bottom = std::cos(std::numbers::pi * (j + 1) / rows);
        for (int i = 0; i < columns; ++i)
            visit(equirectangular_direction((i + 0.5) / columns, (j + 0.5) / rows),
                  2 * std::numbers::pi / columns * (top - bottom));
    }
}

template <typename Radiance>
Sh9 project(int columns, int rows, const Radiance& radiance) {
    Sh9 sh{};
    over_sphere(columns, rows, [&](glm::dvec3 direction, double solid_angle) {
        const glm::dvec3 light = radiance(direction);
        const std::array<double, 9> basis = sh9_basis(direction);
        for (int i = 0; i < 9; ++i) sh[i] += light * (basis[i] * solid_angle);
    });
    return sh;
}

/// Largest difference of two projections, relative to the constant term of the first.
inline double difference(const Sh9& a, const Sh9& b) {
    double largest = 0;
    for (int i = 0; i < 9; ++i)
        for (int c = 0; c < 3; ++c) largest = std::max(largest, std::abs(a[i][c] - b[i][c]) / a[0][c]);
    return largest;
}

}  // namespace lightgrid
