#pragma once

#include <glm/glm.hpp>

#include <cmath>
#include <vector>

/// Closed forms of the light of a uniform polygon, for tests.
namespace lightgrid {

/// Irradiance at `point` on a surface facing `normal` from a polygon of radiance 1 that is wholly above the surface:
/// 1/2 sum of the angles that the edges subtend times the cosines between `normal` and the planes through them
/// (Lambert, "Photometria", 1760). Either winding.
[[nodiscard]] inline double polygon_irradiance(const std::vector<glm::dvec3>& corners, glm::dvec3 point,
                                               glm::dvec3 normal) {
    double sum = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const glm::dvec3 a = glm::normalize(corners[i] - point);
        const glm::dvec3 b = glm::normalize(corners[(i + 1) % corners.size()] - point);
        const glm::dvec3 cross = glm::cross(a, b);
        const double sine = glm::length(cross);
        sum += std::atan2(sine, glm::dot(a, b)) * glm::dot(cross, glm::normalize(normal)) / sine;
    }
    return std::abs(sum) / 2;
}

/// Solid angle of a convex polygon, as a fan of triangles (van Oosterom and Strackee, "The Solid Angle of a Plane
/// Triangle", 1983).
[[nodiscard]] inline double polygon_solid_angle(const std::vector<glm::dvec3>& corners, glm::dvec3 point) {
    double sum = 0;
    const glm::dvec3 a = glm::normalize(corners[0] - point);
    for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
        const glm::dvec3 b = glm::normalize(corners[i] - point);
        const glm::dvec3 c = glm::normalize(corners[i + 1] - point);
        sum += 2 * std::atan2(glm::dot(a, glm::cross(b, c)), 1 + glm::dot(a, b) + glm::dot(b, c) + glm::dot(c, a));
    }
    return std::abs(sum);
}

}  // namespace lightgrid
