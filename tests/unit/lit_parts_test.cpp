#include "probes/lit_parts.h"

#include "core/sampling.h"
#include "core/texel_bounds.h"
#include "tests/scene_builder.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>

namespace lightgrid {
namespace {

constexpr glm::u8vec4 dark(0, 0, 0, 255);
constexpr glm::u8vec4 lit(255, 255, 255, 255);

Texture texture_of(int width, int height, glm::u8vec4 texel) {
    Texture texture;
    texture.image = {width, height, std::vector<glm::u8vec4>(static_cast<std::size_t>(width) * height, texel)};
    return texture;
}

/// A triangle that emits 1 where its texture is lit, and reads it at `uv`.
Scene emissive_triangle(Texture texture, std::vector<glm::vec2> uv) {
    Scene scene;
    Material material;
    material.emission = glm::vec3(1);
    material.emission_texture.texture = 0;
    scene.textures.push_back(std::move(texture));
    const int mesh = add_triangle(scene, add_material(scene, material), {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    scene.meshes[mesh].uv_sets = {std::move(uv)};
    return scene;
}

LitParts parts_of(const Scene& scene) {
    return LitParts(scene, std::vector<std::uint32_t>(scene.meshes.size(), 1));
}

float emission(const Scene& scene, glm::vec2 barycentric) {
    const SurfacePoint point = surface_at(scene, scene.meshes[0], 0, barycentric);
    return luminance(point.alpha * point.emission);
}

/// Wherever light is, a part is, and that part is where the point is; the parts' light is that of the triangle.
void expect_all_light(const Scene& scene, const std::string& what, double tolerance = 0.1) {
    const LitParts parts = parts_of(scene);
    const LitParts::Division& all = parts.division(0, 0);
    constexpr std::uint32_t points = 1U << 18;
    double sum = 0;
    for (std::uint32_t i = 0; i < points; ++i) {
        const glm::vec2 where = triangle_point(sobol_point(i, 3));
        const float here = emission(scene, where);
        sum += here / points;
        if (all.root == LitParts::none) {
            ASSERT_TRUE(here == 0 || all.emission > 0) << what;
            continue;
        }
        const std::uint32_t found = parts.find(all.root, where);
        if (found == LitParts::none) {
            ASSERT_EQ(here, 0) << what << " at " << where.x << ' ' << where.y;
            continue;
        }
        ASSERT_LT(found, all.parts) << what;
        const auto& [a, b, c] = parts.part(all.first_part + found).corners;
        const auto side = [&](glm::dvec2 p, glm::dvec2 q) {
            return (q.x - p.x) * (where.y - p.y) - (q.y - p.y) * (where.x - p.x);
        };
        const glm::dvec3 sides(side(a, b), side(b, c), side(c, a));
        ASSERT_GE(std::min({sides.x, sides.y, sides.z}), -1e-6) << what << " at " << where.x << ' ' << where.y;
    }
    ASSERT_GT(sum, 0) << what << ": nothing to check";
    EXPECT_NEAR(all.emission, sum, tolerance * sum) << what;
}

TEST(TexelBounds, NoLookUpIsBrighterThanTheBound) {
    RandomStream random(1);
    for (int i = 0; i < 2000; ++i) {
        Texture texture =
            texture_of(1 + static_cast<int>(random.next() * 40), 1 + static_cast<int>(random.next() * 40), dark);
        for (glm::u8vec4& texel : texture.image.pixels) texel = random.next() < 0.03F ? lit : dark;
        texture.nearest = random.next() < 0.5F;
        texture.wrap_u = static_cast<Wrap>(random.next() * 3);
        texture.wrap_v = static_cast<Wrap>(random.next() * 3);
        const float spread = std::exp2(random.next() * 8 - 5);
        std::vector<glm::vec2> uv;
        for (int corner = 0; corner < 3; ++corner) uv.push_back(spread * (random.next2() * 4.0F - 2.0F));
        const TexelBounds bounds(texture);
        const glm::dvec2 size = bounds.size();
        const glm::u8vec4 most = bounds.most_over(
            {glm::dvec2(uv[0]) * size, glm::dvec2(uv[1]) * size, glm::dvec2(uv[2]) * size}, glm::dvec2(1e-3));
        const Scene scene = emissive_triangle(texture, uv);
        for (std::uint32_t k = 0; k < 256; ++k)
            ASSERT_LE(emission(scene, triangle_point(sobol_point(k, 5))), decode_srgb(most.r) * 1.0001F) << i;
    }
}

TEST(TexelBounds, DarkIsWhatTheLitTexelIsBeside) {
    Texture texture = texture_of(64, 64, dark);
    texture.image.at(40, 20) = lit;
    texture.nearest = true;
    const TexelBounds bounds(texture);
    const auto most = [&](glm::dvec2 a, glm::dvec2 b, glm::dvec2 c) { return bounds.most_over({a, b, c}, {}).r; };
    EXPECT_EQ(most({0, 0}, {63, 0}, {0, 63}), 255);
    EXPECT_EQ(most({0, 0}, {46, 0}, {0, 46}), 0) << "it lies in the bounds of the triangle, and beyond its long side";
    EXPECT_EQ(most({36, 18}, {39, 18}, {39, 20}), 0);
    EXPECT_EQ(most({104, 84}, {105, 84}, {104, 85}), 255) << "one repeat on";
}

TEST(LitParts, ASurfaceWithoutTexturesIsOnePart) {
    Scene scene;
    add_triangle(scene, add_grey(scene, 0.5F, 3), {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    const LitParts parts = parts_of(scene);
    EXPECT_EQ(parts.division(0, 0).root, LitParts::none);
    EXPECT_EQ(parts.division(0, 0).emission, 3);
}

TEST(LitParts, FindsOneTexelOfAHugeTexture) {
    for (const bool nearest : {true, false}) {
        constexpr int size = 4096;
        Texture texture = texture_of(size, size, dark);
        texture.nearest = nearest;
        texture.image.at(1301, 703) = lit;
        const Scene scene = emissive_triangle(texture, {{0, 0}, {1, 0}, {0, 1}});
        const LitParts parts = parts_of(scene);
        const LitParts::Division& all = parts.division(0, 0);
        const double exact = 2.0 / size / size;
        EXPECT_NEAR(all.emission, exact, 0.05 * exact) << nearest;
        ASSERT_NE(all.root, LitParts::none);
        double area = 0;
        for (std::uint32_t i = 0; i < all.parts; ++i) area += parts.part(all.first_part + i).area;
        EXPECT_LT(area, exact * (nearest ? 1.5 : 6)) << "what is sampled is little more than what is lit";
    }
}

TEST(LitParts, WhatNoCoordinateReadsIsDark) {
    Texture texture = texture_of(64, 64, dark);
    texture.image.at(60, 60) = lit;
    EXPECT_EQ(parts_of(emissive_triangle(texture, {{0.1F, 0.1F}, {0.8F, 0.1F}, {0.1F, 0.8F}})).division(0, 0).emission,
              0);
}

TEST(LitParts, NoLightIsLostWhateverTheTexturesAre) {
    Texture spots = texture_of(32, 16, dark);
    spots.image.at(3, 5) = spots.image.at(31, 0) = spots.image.at(17, 15) = lit;
    const std::vector<glm::vec2> uv = {{-0.3F, 0.2F}, {1.4F, -0.9F}, {0.1F, 1.7F}};
    for (const Wrap wrap : {Wrap::repeat, Wrap::mirror, Wrap::clamp}) {
        for (const bool nearest : {true, false}) {
            Texture texture = spots;
            texture.wrap_u = texture.wrap_v = wrap;
            texture.nearest = nearest;
            const std::string what = std::to_string(static_cast<int>(wrap)) + (nearest ? " nearest" : " linear");
            expect_all_light(emissive_triangle(texture, uv), what);
            Scene turned = emissive_triangle(texture, uv);
            turned.materials[0].emission_texture.transform = {0.4F, 1.1F, -2.3F, 0.2F, 5.3F, -7.1F};
            expect_all_light(turned, what + ", transformed");
        }
    }
    expect_all_light(emissive_triangle(spots, {{0.1F, 0.1F}, {0.1F, 0.35F}, {0.1F, 0.6F}}), "on a line");
    Texture white = texture_of(2, 2, lit);
    expect_all_light(emissive_triangle(white, {{0.3F, 0.3F}, {0.3F, 0.3F}, {0.3F, 0.3F}}), "in a point");
    Texture window = texture_of(16, 16, dark);
    for (int i = 0; i < 9; ++i) window.image.at(4 + i % 3, 7 + i / 3) = lit;
    expect_all_light(emissive_triangle(window, {{0, 0}, {300, 0}, {0, 300}}), "tiled hundreds of times",
                     0.25);  // its parts are few for so many windows, and known by points on them alone

    for (const AlphaMode mode : {AlphaMode::mask, AlphaMode::blend}) {
        Scene scene = emissive_triangle(texture_of(1, 1, lit), uv);
        Texture leaf = texture_of(64, 64, {255, 255, 255, 0});
        leaf.image.at(20, 33) = leaf.image.at(21, 33) = lit;
        scene.textures.push_back(leaf);
        scene.materials[0].alpha_mode = mode;
        scene.materials[0].base_color_texture.texture = 1;
        scene.materials[0].base_color_texture.uv_set = 1;
        scene.meshes[0].uv_sets.push_back({{0, 0}, {1, 0}, {0, 1}});
        expect_all_light(scene, mode == AlphaMode::mask ? "cut out" : "blended");
        scene.materials[0].base_color_texture = {};
        scene.meshes[0].colors = {{0, 0, 0, 0}, {0, 0, 0, 0}, {0, 0, 0, 65535}};
        scene.materials[0].alpha_cutoff = 0.97F;
        expect_all_light(scene, "by alpha of vertices");
    }
}

TEST(LitParts, ThousandsOfTrianglesShareWhatIsTried) {
    Texture noise = texture_of(512, 512, dark);
    RandomStream random(7);
    for (glm::u8vec4& texel : noise.image.pixels) texel = random.next() < 0.02F ? lit : dark;
    Scene scene = emissive_triangle(noise, {});
    Mesh& mesh = scene.meshes[0];
    mesh.triangles.assign(500, {0, 1, 2});
    mesh.uv_sets = {{{0, 0}, {40, 0}, {0, 40}}};
    const LitParts parts = parts_of(scene);
    for (std::uint32_t t = 0; t < 500; ++t) ASSERT_NEAR(parts.division(0, t).emission, 0.02, 0.005) << t;
}

}  // namespace
}  // namespace lightgrid
