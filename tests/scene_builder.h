#pragma once

#include "core/scene.h"

#include <glm/glm.hpp>
#include <glm/gtc/constants.hpp>

#include <array>
#include <cmath>
#include <utility>
#include <vector>

/// Levels made in memory, for tests. Positions are relative to Scene::origin, which stays zero.
namespace lightgrid {

inline int add_material(Scene& scene, const Material& material) {
    scene.materials.push_back(material);
    return static_cast<int>(scene.materials.size()) - 1;
}

/// A surface that reflects this share of light of all colours, and emits.
inline int add_grey(Scene& scene, float albedo, float emission = 0) {
    Material material;
    material.base_color = glm::vec3(albedo);
    material.emission = glm::vec3(emission);
    return add_material(scene, material);
}

/// A mesh for models; add_mesh places one in the level.
inline int store_mesh(Scene& scene, int material, std::vector<glm::vec3> positions, std::vector<glm::uvec3> triangles) {
    Mesh mesh;
    mesh.material = material;
    positions.reserve(positions.size() + 1);
    mesh.positions = std::move(positions);
    mesh.triangles = std::move(triangles);
    scene.meshes.push_back(std::move(mesh));
    return static_cast<int>(scene.meshes.size()) - 1;
}

inline int add_mesh(Scene& scene, int material, std::vector<glm::vec3> positions, std::vector<glm::uvec3> triangles) {
    for (const glm::vec3& position : positions) scene.bounds.extend(glm::dvec3(position));
    const int mesh = store_mesh(scene, material, std::move(positions), std::move(triangles));
    scene.placed.push_back(mesh);
    return mesh;
}

inline int add_triangle(Scene& scene, int material, glm::vec3 a, glm::vec3 b, glm::vec3 c) {
    return add_mesh(scene, material, {a, b, c}, {{0, 1, 2}});
}

/// The parallelogram corner + [0, 1] u + [0, 1] v; its front faces cross(u, v).
inline int add_quad(Scene& scene, int material, glm::vec3 corner, glm::vec3 u, glm::vec3 v) {
    return add_mesh(scene, material, {corner, corner + u, corner + u + v, corner + v}, {{0, 1, 2}, {0, 2, 3}});
}

/// Corner i of a box is at min or max along axis k by bit k of i.
struct BoxShape {
    std::vector<glm::vec3> positions;
    std::vector<glm::uvec3> triangles;
};

enum class Facing { outward, inward };

inline BoxShape box_shape(glm::vec3 min, glm::vec3 max, Facing facing) {
    BoxShape box;
    for (int i = 0; i < 8; ++i) {
        box.positions.emplace_back((i & 1) != 0 ? max.x : min.x, (i & 2) != 0 ? max.y : min.y,
                                   (i & 4) != 0 ? max.z : min.z);
    }
    constexpr std::array<glm::uvec4, 6> sides = {
        {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
    for (const glm::uvec4& s : sides) {
        if (facing == Facing::outward) {
            box.triangles.emplace_back(s.x, s.y, s.z);
            box.triangles.emplace_back(s.x, s.z, s.w);
        } else {
            box.triangles.emplace_back(s.x, s.z, s.y);
            box.triangles.emplace_back(s.x, s.w, s.z);
        }
    }
    return box;
}

/// Twelve triangles in the order -x +x -y +y -z +z, two each.
inline int add_box(Scene& scene, int material, glm::vec3 min, glm::vec3 max, Facing facing) {
    BoxShape box = box_shape(min, max, facing);
    return add_mesh(scene, material, std::move(box.positions), std::move(box.triangles));
}

/// A closed sphere of latitude rings, poles along y.
inline int add_sphere(Scene& scene, int material, glm::vec3 center, float radius, Facing facing, unsigned rings = 16,
                      unsigned segments = 32) {
    std::vector<glm::vec3> positions = {center + glm::vec3(0, radius, 0)};
    for (unsigned ring = 1; ring < rings; ++ring) {
        for (unsigned i = 0; i < segments; ++i) {
            const double polar = glm::pi<double>() * ring / rings;
            const double azimuth = glm::two_pi<double>() * i / segments;
            positions.push_back(center + radius * glm::vec3(std::sin(polar) * std::cos(azimuth), std::cos(polar),
                                                            std::sin(polar) * std::sin(azimuth)));
        }
    }
    positions.push_back(center - glm::vec3(0, radius, 0));
    const auto last = static_cast<unsigned>(positions.size()) - 1;
    const auto at = [&](unsigned ring, unsigned i) { return 1 + (ring - 1) * segments + i % segments; };
    std::vector<glm::uvec3> triangles;
    for (unsigned i = 0; i < segments; ++i) {
        triangles.emplace_back(0, at(1, i + 1), at(1, i));
        for (unsigned ring = 1; ring + 1 < rings; ++ring) {
            triangles.emplace_back(at(ring, i), at(ring, i + 1), at(ring + 1, i));
            triangles.emplace_back(at(ring, i + 1), at(ring + 1, i + 1), at(ring + 1, i));
        }
        triangles.emplace_back(at(rings - 1, i), at(rings - 1, i + 1), last);
    }
    if (facing == Facing::inward) {
        for (glm::uvec3& t : triangles) std::swap(t.y, t.z);
    }
    return add_mesh(scene, material, std::move(positions), std::move(triangles));
}

/// Places a model of one mesh.
inline void add_instance(Scene& scene, int mesh, const glm::mat4x3& to_level) {
    scene.models.push_back({{mesh}});
    Instance instance;
    instance.model = static_cast<int>(scene.models.size()) - 1;
    instance.to_level = to_level;
    instance.mirrored = glm::determinant(glm::mat3(to_level)) < 0;
    scene.instances.push_back(instance);
    for (const glm::vec3& position : scene.meshes[mesh].positions) {
        scene.bounds.extend(glm::dvec3(to_level * glm::vec4(position, 1)));
    }
}

inline Light directional_light(glm::vec3 direction, float lux) {
    Light light;
    light.kind = LightKind::directional;
    light.direction = glm::normalize(direction);
    light.intensity = glm::vec3(lux);
    return light;
}

inline Light point_light(glm::vec3 position, float candela) {
    Light light;
    light.kind = LightKind::point;
    light.position = position;
    light.intensity = glm::vec3(candela);
    return light;
}

}  // namespace lightgrid
