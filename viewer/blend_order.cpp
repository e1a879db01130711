#include "viewer/blend_order.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace lightgrid {
namespace {

/// Squared distances from the eye to the centres of a draw's triangles in one place.
std::vector<float> distances_to(const LevelMesh& mesh, const LevelDraw& draw, glm::vec3 eye) {
    const glm::mat4x3& to_level = mesh.instances[static_cast<std::size_t>(draw.first_instance)];
    std::vector<float> distances;
    distances.reserve(draw.index_count / 3);
    for (std::size_t i = draw.first_index; i < draw.first_index + draw.index_count; i += 3) {
        glm::vec3 sum(0);
        for (std::size_t k = 0; k < 3; ++k) sum += mesh.vertices[mesh.indices[i + k]].position;
        const glm::vec3 away = to_level * glm::vec4(sum / 3.0F, 1) - eye;
        distances.push_back(glm::dot(away, away));
    }
    return distances;
}

/// Numbers of values, that of the greatest first.
std::vector<std::uint32_t> falling_order(std::span<const float> values) {
    std::vector<std::uint32_t> order(values.size());
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return values[a] > values[b]; });
    return order;
}

}  // namespace

BlendOrder farthest_first(const LevelMesh& mesh, std::span<const std::size_t> draws, const Eye& eye) {
    std::vector<LevelDraw> seen;
    std::size_t triangles = 0;
    for (const std::size_t i : draws) {
        const LevelDraw& draw = mesh.draws[i];
        if (eye.misses(draw.bounds)) continue;
        const std::vector<LevelDraw> places = in_each_place(draw);
        seen.insert(seen.end(), places.begin(), places.end());
        triangles += places.size() * draw.index_count / 3;
    }
    const bool by_triangle = triangles <= most_sorted_triangles;

    BlendOrder result;
    std::vector<float> means;
    for (LevelDraw& draw : seen) {
        const std::vector<float> distances = distances_to(mesh, draw, eye.position);
        means.push_back(std::accumulate(distances.begin(), distances.end(), 0.0F) /
                        static_cast<float>(std::max<std::size_t>(distances.size(), 1)));
        std::vector<std::uint32_t> order(distances.size());
        std::iota(order.begin(), order.end(), 0U);
        if (by_triangle) order = falling_order(distances);
        const std::size_t first = std::exchange(draw.first_index, static_cast<std::uint32_t>(result.indices.size()));
        for (const std::uint32_t t : order) {
            for (std::size_t k = 0; k < 3; ++k) result.indices.push_back(mesh.indices[first + 3 * t + k]);
        }
    }
    for (const std::uint32_t i : falling_order(means)) result.draws.push_back(seen[i]);
    return result;
}

}  // namespace lightgrid
