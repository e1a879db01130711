#include "viewer/level_mesh.h"

#include "core/sh.h"
#include "tests/scene_builder.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>

namespace lightgrid {
namespace {

double area_of(const LevelMesh& mesh) {
    double area = 0;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        const glm::dvec3 a = mesh.vertices[mesh.indices[i]].position;
        const glm::dvec3 b = mesh.vertices[mesh.indices[i + 1]].position;
        const glm::dvec3 c = mesh.vertices[mesh.indices[i + 2]].position;
        area += 0.5 * glm::length(glm::cross(b - a, c - a));
    }
    return area;
}

double longest_edge_of(const LevelMesh& mesh) {
    double longest = 0;
    for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
        const std::size_t next = i % 3 == 2 ? i - 2 : i + 1;
        longest = std::max<double>(longest, glm::distance(mesh.vertices[mesh.indices[i]].position,
                                                          mesh.vertices[mesh.indices[next]].position));
    }
    return longest;
}

TEST(LevelMesh, DividesUntilNoEdgeIsLongerAndKeepsTheArea) {
    Scene scene;
    add_box(scene, add_grey(scene, 0.5F), {0, 0, 0}, {10, 3, 7}, Facing::inward);
    const LevelMesh mesh = build_level_mesh(scene, 0.6);
    EXPECT_LE(longest_edge_of(mesh), 0.6);
    EXPECT_NEAR(area_of(mesh), 2 * (10 * 3 + 10 * 7 + 3 * 7), 1e-4);
    EXPECT_EQ(mesh.longest_edge, 0.6);
}

TEST(LevelMesh, NeighboursStayJoined) {
    // Every edge of a closed surface belongs to two triangles, also after edges of many lengths were divided.
    Scene scene;
    add_box(scene, add_grey(scene, 0.5F), {0, 0, 0}, {10, 0.3F, 1.7F}, Facing::outward);
    const LevelMesh mesh = build_level_mesh(scene, 0.5);
    using Point = std::array<float, 3>;
    std::map<std::pair<Point, Point>, int> edges;
    const auto point = [&](std::size_t i) {
        const glm::vec3 p = mesh.vertices[mesh.indices[i]].position;
        return Point{p.x, p.y, p.z};
    };
    for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
        const Point a = point(i);
        const Point b = point(i % 3 == 2 ? i - 2 : i + 1);
        ++edges[{a, b}];
        --edges[{b, a}];
    }
    EXPECT_GT(edges.size(), 100U);
    for (const auto& [edge, balance] : edges) EXPECT_EQ(balance, 0);
}

TEST(LevelMesh, RowsOfLightAreLimited) {
    Scene scene;
    add_box(scene, add_grey(scene, 0.5F), {0, 0, 0}, {10, 10, 10}, Facing::inward);
    const LevelMesh mesh = build_level_mesh(scene, 0.01, 5000);
    EXPECT_LE(mesh.light_rows, 5000U);
    EXPECT_GT(mesh.light_rows, 1000U);
    EXPECT_GT(mesh.longest_edge, 0.01);
}

TEST(LevelMesh, ALevelThatIsLargeByItselfStaysWhole) {
    Scene scene;
    add_sphere(scene, add_grey(scene, 0.5F), {0, 0, 0}, 1, Facing::outward, 32, 64);
    const LevelMesh mesh = build_level_mesh(scene, 0.01, 100);
    EXPECT_EQ(mesh.indices.size(), 3 * scene.meshes[0].triangles.size());
}

TEST(LevelMesh, InstancesShareTheirVerticesAndNotTheirLight) {
    Scene scene;
    const int grey = add_grey(scene, 0.5F);
    const BoxShape box = box_shape({0, 0, 0}, {1, 1, 1}, Facing::outward);
    const int mesh = store_mesh(scene, grey, box.positions, box.triangles);
    scene.models.push_back({{mesh}});
    for (int i = 0; i < 5; ++i) {
        scene.instances.push_back({0, glm::mat4x3(1, 0, 0, 0, 1, 0, 0, 0, 1, 3 * i, 0, 0), false});
    }
    scene.instances.push_back({0, glm::mat4x3(-1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 5, 0), true});
    const LevelMesh level = build_level_mesh(scene, 10);
    EXPECT_EQ(level.vertices.size(), 24U);  // 8 corners, three sides each
    ASSERT_EQ(level.draws.size(), 2U);
    EXPECT_EQ(level.draws[0].instance_count, 5);
    EXPECT_FALSE(level.draws[0].mirrored);
    EXPECT_EQ(level.draws[1].instance_count, 1);
    EXPECT_TRUE(level.draws[1].mirrored);
    EXPECT_EQ(level.light_rows, 6 * 24U);
    EXPECT_EQ(level.draws[1].first_light, 5 * 24U);
    EXPECT_EQ(level.draws[0].bounds.max.x, 13);
    EXPECT_EQ(level.draws[1].bounds.min.x, -1);
}

TEST(LevelMesh, LongEdgesOfLargeInstancesAreDividedInTheLevelsMeasure) {
    Scene scene;
    const BoxShape box = box_shape({0, 0, 0}, {1, 1, 1}, Facing::outward);
    const int mesh = store_mesh(scene, add_grey(scene, 0.5F), box.positions, box.triangles);
    add_instance(scene, mesh, glm::mat4x3(4, 0, 0, 0, 4, 0, 0, 0, 4, 0, 0, 0));
    EXPECT_LE(longest_edge_of(build_level_mesh(scene, 1)), 0.25);
}

TEST(LevelMesh, LargeMeshesAreDrawnInPartsWithTheirOwnBounds) {
    Scene scene;
    add_quad(scene, add_grey(scene, 0.5F), {0, 0, 0}, {0, 0, 100}, {100, 0, 0});
    const LevelMesh mesh = build_level_mesh(scene, 0.7, 1'000'000);
    ASSERT_GT(mesh.draws.size(), 4U);
    std::size_t indices = 0;
    double area = 0;
    for (const LevelDraw& draw : mesh.draws) {
        indices += draw.index_count;
        area += draw.bounds.size().x * draw.bounds.size().z;
        EXPECT_EQ(draw.first_light, 0U);
    }
    EXPECT_EQ(indices, mesh.indices.size());
    EXPECT_LT(area, 1.5 * 100 * 100);  // they hardly overlap
}

// A volume in which light comes from +Y alone and grows with x: E up is 1 + x / 2 at the probes.
Volume light_from_above() {
    Volume volume = make_volume({{{-8, -8, -8}, {1, 1, 1}, {17, 17, 17}}}, 2);
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        if (volume.states[slot] == ProbeState::absent) continue;
        const float bright = 10 + static_cast<float>(lattice_position(volume, slot).x);
        volume.coefficients[slot * 4] = glm::vec3(bright);
        volume.coefficients[slot * 4 + 1] = glm::vec3(0.5F * bright);
    }
    return volume;
}

TEST(LevelLight, IsTheSamplersOnBothSidesOfEveryInstance) {
    Scene scene;
    const int mesh = store_mesh(scene, add_grey(scene, 0.5F), {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}}, {{0, 1, 2}});  // +Y
    scene.models.push_back({{mesh}});
    scene.instances.push_back({0, glm::mat4x3(1, 0, 0, 0, 1, 0, 0, 0, 1, 2, 0, 0), false});
    scene.instances.push_back({0, glm::mat4x3(1, 0, 0, 0, -1, 0, 0, 0, 1, 2, 0, 0), true});  // its front looks down
    const LitVolume lit(light_from_above());
    const LookUp from = look_up(lit, Settings{});
    EXPECT_FLOAT_EQ(from.normal_bias, 0.3F);
    const LevelMesh level = build_level_mesh(scene, 10);
    ASSERT_EQ(level.light_rows, 6U);
    const std::vector<VertexLight> light = light_level(level, {0, 0, 0}, from);
    for (const LevelDraw& draw : level.draws) {
        const glm::vec3 front(0, draw.mirrored ? -1 : 1, 0);
        for (std::uint32_t v = 0; v < 3; ++v) {
            const glm::dvec3 position = level.instances[static_cast<std::size_t>(draw.first_instance)] *
                                        glm::vec4(level.vertices[draw.first_vertex + v].position, 1);
            const SampleOptions options{.normal_bias = 0.3F};
            for (const bool behind : {false, true}) {
                const glm::vec3 normal = behind ? -front : front;
                const glm::vec3 wanted = glm::max(lit.sampler.irradiance(position, normal, options), 0.0F);
                const VertexLight& row = light[draw.first_light + v];
                EXPECT_NEAR((behind ? row.back : row.front).x, wanted.x, 1e-5F * wanted.x);
            }
        }
    }
}

TEST(LookUp, NearestTakesOneProbeWhole) {
    const LitVolume lit(light_from_above());
    Settings settings;
    settings.filter = Filter::nearest;
    EXPECT_FLOAT_EQ(radiance_sh(look_up(lit, settings), {2.4, 0.1, -0.2})[0].x, 12);
    settings.filter = Filter::trilinear;
    EXPECT_NEAR(radiance_sh(look_up(lit, settings), {2.4, 0.1, -0.2})[0].x, 12.4F, 1e-5F);
}

TEST(LookUp, BandsThatAreNotWantedAreZero) {
    const LitVolume lit(light_from_above());
    Settings settings;
    settings.bands = 1;
    const Sh9 sh = radiance_sh(look_up(lit, settings), {0, 0, 0});
    EXPECT_GT(sh[0].x, 0);
    for (std::size_t i = 1; i < sh.size(); ++i) EXPECT_EQ(sh[i], glm::vec3(0));
}

TEST(LookUp, DeringedLightIsNowhereNegative) {
    Volume volume = make_volume({{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}}, 3);
    const std::vector<glm::vec3> sun = delta_light_sh(3, {0, 1, 0}, glm::vec3(1));
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        if (volume.states[slot] == ProbeState::absent) continue;
        for (std::size_t i = 0; i < 9; ++i) volume.coefficients[slot * 9 + i] = sun[i];
    }
    const LitVolume lit(volume);
    const LookUp from = look_up(lit, Settings{});
    const auto least = [&](const Sh36& radiance) {
        float value = 1;
        for (int i = 0; i <= 180; ++i) {
            const double angle = glm::radians(static_cast<double>(i));
            value = std::min(value, irradiance_from_sh(radiance, glm::vec3(std::sin(angle), std::cos(angle), 0)).x);
        }
        return value;
    };
    EXPECT_LT(least(all_radiance_sh(from, {0.5, 0.5, 0.5})), -0.03F);
    EXPECT_GE(least(deringed(all_radiance_sh(from, {0.5, 0.5, 0.5}))), -1e-6F);
}

}  // namespace
}  // namespace lightgrid
