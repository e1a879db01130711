#pragma once

#include <glm/glm.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

/// Integration over the sphere and random rotations, for tests.
namespace lightgrid {

struct QuadratureNode {
    glm::dvec3 direction{0};
    double weight = 0;  // solid angle, sr
};

/// Nodes that integrate polynomials up to `degree` in x, y, z exactly over the sphere: Gauss-Legendre in z, uniform
/// around it.
[[nodiscard]] inline std::vector<QuadratureNode> sphere_quadrature(int degree) {
    using std::numbers::pi;
    const int rings = degree / 2 + 1;
    const int around = degree + 1;
    std::vector<QuadratureNode> nodes;
    for (int ring = 0; ring < rings; ++ring) {
        // A root of the Legendre polynomial of degree `rings`, by Newton's method.
        double z = std::cos(pi * (ring + 0.75) / (rings + 0.5));
        double slope = 0;
        for (int turn = 0; turn < 8; ++turn) {
            double before = 1;
            double legendre = z;
            for (int l = 2; l <= rings; ++l) {
                const double next = ((2 * l - 1) * z * legendre - (l - 1) * before) / l;
                before = legendre;
                legendre = next;
            }
            slope = rings * (before - z * legendre) / (1 - z * z);
            z -= legendre / slope;
        }
        const double radius = std::sqrt(1 - z * z);
        const double weight = 2 / ((1 - z * z) * slope * slope) * 2 * pi / around;
        for (int i = 0; i < around; ++i) {
            const double angle = 2 * pi * (i + 0.5) / around;
            nodes.push_back({{radius * std::cos(angle), radius * std::sin(angle), z}, weight});
        }
    }
    return nodes;
}

[[nodiscard]] inline glm::dvec3 random_direction(std::mt19937_64& random) {
    std::normal_distribution<double> normal;
    const double x = normal(random);
    const double y = normal(random);
    return glm::normalize(glm::dvec3(x, y, normal(random)));
}

[[nodiscard]] inline glm::dmat3 random_rotation(std::mt19937_64& random) {
    const glm::dvec3 x = random_direction(random);
    const glm::dvec3 y = glm::normalize(glm::cross(x, random_direction(random)));
    return {x, y, glm::cross(x, y)};
}

/// Independent normal numbers.
[[nodiscard]] inline std::vector<double> random_numbers(std::size_t count, std::mt19937_64& random) {
    std::normal_distribution<double> normal;
    std::vector<double> numbers(count);
    for (double& number : numbers) number = normal(random);
    return numbers;
}

[[nodiscard]] inline double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
    double largest = a.size() == b.size() ? 0 : HUGE_VAL;
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) largest = std::fmax(largest, std::abs(a[i] - b[i]));
    return largest;
}

}  // namespace lightgrid
