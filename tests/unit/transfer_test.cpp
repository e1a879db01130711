#include "viewer/transfer.h"

#include "core/parallel.h"
#include "core/sh.h"
#include "tests/scene_builder.h"
#include "tests/sphere.h"
#include "viewer/dominant_light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace lightgrid {
namespace {

using std::numbers::pi;

/// Two square plates that meet in the z axis at a right angle, a floor (x >= 0) and a wall (y >= 0), of vertices the
/// closer the nearer they are to zero.
ObjectMesh groove(float albedo) {
    std::vector<float> steps{0};
    for (int k = -6; k <= 6; ++k) steps.push_back(std::ldexp(1.0F, k));
    std::vector<float> both;
    for (auto step = steps.rbegin(); step != steps.rend(); ++step) both.push_back(-*step);
    both.insert(both.end(), steps.begin() + 1, steps.end());
    const auto rows = static_cast<unsigned>(steps.size());
    const auto columns = static_cast<unsigned>(both.size());
    std::vector<glm::vec3> floor;
    std::vector<glm::vec3> wall;
    for (const float out : steps) {
        for (const float along : both) {
            floor.emplace_back(out, 0, along);
            wall.emplace_back(0, out, along);
        }
    }
    std::vector<glm::uvec3> up;
    std::vector<glm::uvec3> aside;
    for (unsigned i = 0; i + 1 < rows; ++i) {
        for (unsigned j = 0; j + 1 < columns; ++j) {
            const unsigned a = i * columns + j;
            const unsigned b = a + columns;
            up.insert(up.end(), {{a, a + 1, b + 1}, {a, b + 1, b}});
            aside.insert(aside.end(), {{a, b + 1, a + 1}, {a, b, b + 1}});
        }
    }
    Scene scene;
    const int grey = add_grey(scene, albedo);
    add_mesh(scene, grey, floor, up);
    add_mesh(scene, grey, wall, aside);
    return object_from_scene(scene);
}

std::size_t vertex_at(const ObjectMesh& object, glm::vec3 position, glm::vec3 normal) {
    for (std::size_t i = 0; i < object.positions.size(); ++i) {
        if (object.positions[i] == position && glm::distance(object.normals[i], normal) < 1e-5F) return i;
    }
    throw std::logic_error("no such vertex");
}

TEST(Transfer, WithoutShadowsIsIrradianceFromSh) {
    const ObjectMesh sphere = make_sphere(16);
    std::mt19937_64 random(3);
    for (int bands = 1; bands <= 4; ++bands) {
        std::vector<glm::vec3> light;
        for (const double value : random_numbers(sh_size(bands), random)) light.emplace_back(value, 2 * value, -value);
        std::vector<glm::vec3> lit(sphere.positions.size());
        light_vertices(unshadowed_transfer(sphere.normals, bands), light, lit);
        for (std::size_t v = 0; v < lit.size(); ++v) {
            EXPECT_NEAR(glm::distance(lit[v], irradiance_from_sh(light, sphere.normals[v])), 0, 1e-4);
        }
    }
}

TEST(Transfer, OfAConvexObjectHasNoShadowsToTheBit) {
    ObjectMesh sphere = make_sphere(24);
    fit(sphere, 0.3);
    EXPECT_EQ(self_shadowed_transfer(sphere), unshadowed_transfer(sphere.normals));
    Scene scene;
    add_grey(scene, 0.5F);
    add_box(scene, 0, {1, 2, 3}, {2, 5, 4}, Facing::outward);
    const ObjectMesh box = object_from_scene(scene);
    EXPECT_EQ(self_shadowed_transfer(box), unshadowed_transfer(box.normals));
}

TEST(Transfer, AtTheFootOfAWallIsThatOfAQuarterOfTheSphere) {
    const ObjectMesh object = groove(0);
    TransferOptions options;
    options.samples = 4096;
    const std::vector<float> transfer = self_shadowed_transfer(object, options);
    // Integrals of y Y_i over x > 0, y > 0, with Y_i = 1, y, z, x, xy, yz, 3z^2 - 1, xz, x^2 - y^2 times a factor.
    const std::array<double, 9> floor{
        0.282095 * pi / 2,                 // 1
        0.488603 * pi / 3,                 // y
        0,                                 // z
        0.488603 * 2 / 3,                  // x
        1.092548 * pi / 8,                 // xy: integral x y^2 = pi / 8
        0,                                 // yz
        0.315392 * (3 * pi / 8 - pi / 2),  // 3z^2 - 1: integral y z^2 = pi / 8, y = pi / 2
        0,                                 // xz
        0.546274 * (pi / 8 - pi / 4),      // x^2 - y^2: integrals y x^2 = pi / 8, y^3 = pi / 4
    };
    const std::size_t v = vertex_at(object, {0, 0, 0}, {0, 1, 0});
    // The plates end at 64 times the distance of the neighbours, and 4096 rays are off by 4096^-0.75.
    for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(transfer[v * 9 + i], floor[i], 0.01) << "coefficient " << i;
    // The wall's vertex there sees the same with x and y exchanged.
    const std::size_t w = vertex_at(object, {0, 0, 0}, {1, 0, 0});
    EXPECT_NEAR(transfer[w * 9 + 0], floor[0], 0.01);
    EXPECT_NEAR(transfer[w * 9 + 3], floor[1], 0.01);
    EXPECT_NEAR(transfer[w * 9 + 1], floor[3], 0.01);
    EXPECT_NEAR(transfer[w * 9 + 8], -floor[8], 0.01);
}

TEST(Transfer, BouncesBetweenFloorAndWall) {
    // In an endless groove every point sees the other plate in half of its rays, and half of the sky: E = 1/2 of the
    // open sky's, and one bounce adds albedo * 1/2 * 1/2.
    const ObjectMesh object = groove(0.8F);
    TransferOptions options;
    options.samples = 1024;
    const std::vector<float> transfer = self_shadowed_transfer(object, options);
    const std::size_t v = vertex_at(object, {0, 0, 0}, {0, 1, 0});
    const double open = 0.282095 * pi;
    EXPECT_NEAR(transfer[v * 9] / open, 0.5 + 0.8 / 4, 0.01);
}

TEST(Transfer, EndsByWhatItsStepThrows) {
    struct Stopped {};
    TransferOptions options;
    options.step = [] { throw Stopped(); };
    EXPECT_THROW((void)self_shadowed_transfer(make_sphere(8), options), Stopped);
}

TEST(Transfer, DoesNotDependOnThreads) {
    const ObjectMesh object = groove(0.5F);
    TransferOptions options;
    options.samples = 64;
    const std::vector<float> all = self_shadowed_transfer(object, options);
    const ThreadLimit one(1);
    EXPECT_EQ(self_shadowed_transfer(object, options), all);
}

TEST(DominantLight, IsFoundAmongEvenLight) {
    std::mt19937_64 random(8);
    for (int bands = 2; bands <= 4; ++bands) {
        for (int i = 0; i < 20; ++i) {
            const glm::dvec3 direction = random_direction(random);
            const glm::vec3 illuminance(3, 2, 1);
            const glm::vec3 ambient(0.25F, 0.5F, 1);
            std::vector<glm::vec3> light = delta_light_sh(bands, direction, illuminance);
            light[0] += 2 * std::sqrt(static_cast<float>(pi)) * ambient;
            const DominantLight found = dominant_light(light);
            EXPECT_NEAR(glm::distance(found.direction, glm::vec3(direction)), 0, 1e-5);
            EXPECT_NEAR(glm::distance(found.illuminance, illuminance), 0, 1e-4);
            EXPECT_NEAR(glm::distance(found.ambient, ambient), 0, 1e-4);
            const double lit = 0.2126 * 3 + 0.7152 * 2 + 0.0722;
            const double rest = 0.2126 * 0.25 + 0.7152 * 0.5 + 0.0722;
            EXPECT_NEAR(found.share, lit / (lit + 4 * pi * rest), 1e-5);
            EXPECT_NEAR(shadow_strength(found, glm::vec3(direction)), lit / (lit + pi * rest), 1e-5);
            EXPECT_EQ(shadow_strength(found, -glm::vec3(direction)), 0);
        }
    }
}

TEST(DominantLight, IsNoneInEvenLightOrDarkness) {
    std::vector<glm::vec3> light(9, glm::vec3(0));
    DominantLight found = dominant_light(light);
    EXPECT_EQ(found.illuminance, glm::vec3(0));
    EXPECT_EQ(found.share, 0);
    EXPECT_EQ(shadow_strength(found, {0, 1, 0}), 0);
    light[0] = glm::vec3(2 * std::sqrt(static_cast<float>(pi)));
    found = dominant_light(light);
    EXPECT_NEAR(found.ambient.r, 1, 1e-6);
    EXPECT_EQ(found.share, 0);
    EXPECT_EQ(dominant_light(std::span(light).first(1)).share, 0) << "one band";
}

TEST(DominantLight, TakesNoMoreThanThereIs) {
    // Noise can make the linear band longer than any light's; nothing becomes negative.
    std::vector<glm::vec3> light = delta_light_sh(3, {0, 1, 0}, glm::vec3(1));
    light[1] *= 2.0F;
    const DominantLight found = dominant_light(light);
    EXPECT_FLOAT_EQ(found.illuminance.g, 1);
    EXPECT_FLOAT_EQ(found.ambient.g, 0);
    EXPECT_FLOAT_EQ(found.share, 1);
}

}  // namespace
}  // namespace lightgrid
