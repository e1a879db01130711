#include "viewer/normals.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace lightgrid {
namespace {

bool before(glm::vec3 a, glm::vec3 b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
}

/// For each position the number of its point: equal positions are one point.
std::vector<std::uint32_t> points_of(std::span<const glm::vec3> positions) {
    std::vector<std::uint32_t> order(positions.size());
    std::iota(order.begin(), order.end(), 0U);
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return before(positions[a], positions[b]); });
    std::vector<std::uint32_t> points(positions.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        const bool same = i > 0 && positions[order[i]] == positions[order[i - 1]];
        points[order[i]] = same ? points[order[i - 1]] : order[i];
    }
    return points;
}

/// A corner of a triangle, and the points at the other ends of its two edges.
struct Corner {
    std::uint32_t point;
    std::uint32_t triangle;
    std::uint32_t at;
    std::array<std::uint32_t, 2> edges;
};

/// Sets that are joined two by two.
class Sets {
  public:
    explicit Sets(std::size_t count) : parents_(count) { std::iota(parents_.begin(), parents_.end(), std::size_t{0}); }
    std::size_t find(std::size_t i) {
        while (parents_[i] != i) i = parents_[i] = parents_[parents_[i]];
        return i;
    }
    void join(std::size_t a, std::size_t b) { parents_[find(a)] = find(b); }

  private:
    std::vector<std::size_t> parents_;
};

struct Face {
    glm::dvec3 normal{0};
    std::array<double, 3> angles{};
};

Face face_of(const std::array<glm::dvec3, 3>& p) {
    Face face;
    const glm::dvec3 cross = glm::cross(p[1] - p[0], p[2] - p[0]);
    const double length = glm::length(cross);
    if (length > 0) face.normal = cross / length;
    for (int k = 0; k < 3; ++k) {
        const glm::dvec3 a = p[(k + 1) % 3] - p[k];
        const glm::dvec3 b = p[(k + 2) % 3] - p[k];
        face.angles[k] = std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
    }
    return face;
}

/// The corners around one point, joined over the edges that are no creases.
Sets smooth_sets(std::span<const Corner> corners, std::span<const Face> faces, double least_cosine) {
    struct Side {
        std::uint32_t other_end;
        std::size_t corner;
    };
    std::vector<Side> sides;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        for (const std::uint32_t end : corners[i].edges) sides.push_back({end, i});
    }
    std::stable_sort(sides.begin(), sides.end(),
                     [](const Side& a, const Side& b) { return a.other_end < b.other_end; });
    Sets sets(corners.size());
    for (std::size_t i = 0; i < sides.size(); ++i) {
        for (std::size_t j = i + 1; j < sides.size() && sides[j].other_end == sides[i].other_end; ++j) {
            const glm::dvec3 a = faces[corners[sides[i].corner].triangle].normal;
            const glm::dvec3 b = faces[corners[sides[j].corner].triangle].normal;
            const bool flat = a == glm::dvec3(0) || b == glm::dvec3(0);
            if (flat || glm::dot(a, b) >= least_cosine) sets.join(sides[i].corner, sides[j].corner);
        }
    }
    return sets;
}

}  // namespace

std::vector<std::array<glm::vec3, 3>> corner_normals(std::span<const glm::vec3> positions,
                                                     std::span<const glm::uvec3> triangles, double crease) {
    const std::vector<std::uint32_t> points = points_of(positions);
    std::vector<Face> faces;
    std::vector<Corner> corners;
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        const glm::uvec3 v = triangles[t];
        faces.push_back(face_of({positions[v.x], positions[v.y], positions[v.z]}));
        for (std::uint32_t k = 0; k < 3; ++k) {
            corners.push_back({points[v[k]], t, k, {points[v[(k + 1) % 3]], points[v[(k + 2) % 3]]}});
        }
    }
    std::stable_sort(corners.begin(), corners.end(),
                     [](const Corner& a, const Corner& b) { return a.point < b.point; });

    const double least_cosine = std::cos(glm::radians(crease));
    std::vector<std::array<glm::vec3, 3>> normals(triangles.size());
    for (auto first = corners.begin(); first != corners.end();) {
        const auto last =
            std::find_if(first, corners.end(), [&](const Corner& corner) { return corner.point != first->point; });
        const std::span<const Corner> around(first, last);
        Sets sets = smooth_sets(around, faces, least_cosine);
        std::vector<glm::dvec3> sums(around.size(), glm::dvec3(0));
        for (std::size_t i = 0; i < around.size(); ++i) {
            const Face& face = faces[around[i].triangle];
            sums[sets.find(i)] += face.angles[around[i].at] * face.normal;
        }
        for (std::size_t i = 0; i < around.size(); ++i) {
            const glm::dvec3 sum = sums[sets.find(i)];
            const double length = glm::length(sum);
            const glm::dvec3 own = faces[around[i].triangle].normal;
            glm::dvec3 normal = length > 1e-9 ? sum / length : own;
            if (normal == glm::dvec3(0)) normal = {0, 1, 0};
            normals[around[i].triangle][around[i].at] = glm::vec3(normal);
        }
        first = last;
    }
    return normals;
}

}  // namespace lightgrid
