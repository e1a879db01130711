#include "core/gltf/placing.h"

#include "core/error.h"
#include "core/parallel.h"

#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>

#include <numeric>
#include <utility>

namespace lightgrid::gltf {
namespace {

/// From the space of a part that stands once to the level's coordinates.
glm::dmat4 transform_of(const Shape& shape, const Part& part) {
    return shape.skin < 0 ? shape.transforms[0] : glm::translate(glm::dmat4(1), part.loaded.offset);
}

void extend(Box& box, const Mesh& mesh, const glm::dmat4& transform) {
    for (const glm::vec3& position : mesh.positions) box.extend(transform * glm::dvec4(position, 1));
}

/// Whether an instance may reach out of `bounds`: its transformed box does. Few of many instances reach beyond the
/// others; only those are worth a look at each vertex.
bool may_reach_out(const Box& bounds, const Box& own, const glm::dmat4& transform) {
    Box around = bounds;
    for (int corner = 0; corner < 8; ++corner)
        around.extend(transform * glm::dvec4(corner & 1 ? own.max.x : own.min.x, corner & 2 ? own.max.y : own.min.y,
                                             corner & 4 ? own.max.z : own.min.z, 1));
    return around.min != bounds.min || around.max != bounds.max;
}

Box find_bounds(const std::vector<Shape>& shapes, const std::vector<Part>& parts, const std::vector<Mesh>& meshes) {
    std::vector<Box> boxes(parts.size());  // of instanced parts in their own space
    for_each_index(parts.size(), [&](std::size_t i) {
        const Shape& shape = shapes[parts[i].shape];
        extend(boxes[i], meshes[i], shape.is_instanced() ? glm::dmat4(1) : transform_of(shape, parts[i]));
    });
    Box bounds;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        if (shapes[parts[i].shape].is_instanced() || boxes[i].empty()) continue;
        bounds.extend(boxes[i].min);
        bounds.extend(boxes[i].max);
    }
    for (std::size_t i = 0; i < parts.size(); ++i) {
        if (!shapes[parts[i].shape].is_instanced() || boxes[i].empty()) continue;
        for (const glm::dmat4& transform : shapes[parts[i].shape].transforms)
            if (may_reach_out(bounds, boxes[i], transform)) extend(bounds, meshes[i], transform);
    }
    return bounds;
}

void check_bounds(const Box& bounds) {
    constexpr double farthest = 1e15;  // m; Embree's own limit is 1.8e18, and squares of distances must stay finite
    const glm::dvec3 reach = glm::max(glm::abs(bounds.min), glm::abs(bounds.max));
    if (bounds.empty() || (reach.x < farthest && reach.y < farthest && reach.z < farthest)) return;
    throw Error(fmt::format("the level reaches from ({:g}, {:g}, {:g}) to ({:g}, {:g}, {:g}) m", bounds.min.x,
                            bounds.min.y, bounds.min.z, bounds.max.x, bounds.max.y, bounds.max.z),
                "", "Remove what lies that far out.");
}

void transform_mesh(Mesh& mesh, const glm::dmat4& transform, bool turned) {
    for (glm::vec3& position : mesh.positions) position = glm::vec3(transform * glm::dvec4(position, 1));
    if (turned || glm::determinant(glm::dmat3(transform)) < 0)
        for (glm::uvec3& triangle : mesh.triangles) std::swap(triangle.y, triangle.z);
}

}  // namespace

std::size_t place_parts(const std::vector<Shape>& shapes, const std::vector<Part>& parts, Scene& scene) {
    scene.bounds = find_bounds(shapes, parts, scene.meshes);
    check_bounds(scene.bounds);
    if (!scene.bounds.empty()) scene.origin = scene.bounds.center();
    const glm::dmat4 recentre = glm::translate(glm::dmat4(1), -scene.origin);

    std::vector<std::size_t> without_area(parts.size());
    for_each_index(parts.size(), [&](std::size_t i) {
        const Shape& shape = shapes[parts[i].shape];
        if (shape.is_instanced()) return;
        transform_mesh(scene.meshes[i], recentre * transform_of(shape, parts[i]), parts[i].loaded.turned);
        scene.meshes[i].node = shape.nodes[0];
        without_area[i] = drop_triangles_without_area(scene.meshes[i]);
    });

    std::vector<Mesh> kept;
    std::vector<std::vector<int>> meshes_of(shapes.size());
    for (std::size_t i = 0; i < parts.size(); ++i) {
        if (scene.meshes[i].triangles.empty()) continue;
        meshes_of[parts[i].shape].push_back(static_cast<int>(kept.size()));
        kept.push_back(std::move(scene.meshes[i]));
    }
    scene.meshes = std::move(kept);
    for (std::size_t i = 0; i < shapes.size(); ++i) {
        if (meshes_of[i].empty()) continue;
        if (!shapes[i].is_instanced()) {
            scene.placed.insert(scene.placed.end(), meshes_of[i].begin(), meshes_of[i].end());
            continue;
        }
        for (std::size_t k = 0; k < shapes[i].transforms.size(); ++k) {
            const glm::dmat4& transform = shapes[i].transforms[k];
            scene.instances.push_back({static_cast<int>(scene.models.size()), glm::mat4x3(recentre * transform),
                                       glm::determinant(glm::dmat3(transform)) < 0, shapes[i].nodes[k]});
        }
        scene.models.push_back({std::move(meshes_of[i])});
    }
    return std::accumulate(without_area.begin(), without_area.end(), std::size_t{0});
}

}  // namespace lightgrid::gltf
