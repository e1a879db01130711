#include "core/scene.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lightgrid {
namespace {

constexpr float ulp = 1.2e-7F;

/// A triangle whose UV coordinates are its barycentric coordinates, with one material.
Scene scene_with(const Material& material) {
    Scene scene;
    scene.materials.push_back(material);
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.triangles = {{0, 1, 2}};
    mesh.uv_sets = {{{0, 0}, {1, 0}, {0, 1}}};
    scene.meshes.push_back(mesh);
    return scene;
}

TextureUse first_texture() {
    TextureUse use;
    use.texture = 0;
    return use;
}

/// A scene whose base colour is a texture of grey texels, row by row from the top.
Scene scene_with_texels(int width, int height, const std::vector<int>& greys, Texture texture = {}) {
    Material material;
    material.base_color_texture = first_texture();
    Scene scene = scene_with(material);
    texture.image = {width, height, {}};
    for (const int grey : greys) texture.image.pixels.emplace_back(grey, grey, grey, 255);
    scene.textures.push_back(texture);
    return scene;
}

SurfacePoint at(const Scene& scene, glm::vec2 uv) {
    return surface_at(scene, scene.meshes[0], 0, uv);
}
float alpha(const Scene& scene, glm::vec2 uv) {
    return alpha_at(scene, scene.meshes[0], 0, uv);
}

TEST(Surface, WithoutTexturesIsItsFactors) {
    Material material;
    material.base_color = {0.25F, 0.5F, 0.75F};
    material.emission = {1, 20, 300};
    material.transmission = 0.25F;
    const SurfacePoint point = at(scene_with(material), {0.3F, 0.3F});
    EXPECT_EQ(point.albedo, glm::vec3(0.25F, 0.5F, 0.75F));
    EXPECT_EQ(point.tint, point.albedo);
    EXPECT_EQ(point.emission, glm::vec3(1, 20, 300));
    EXPECT_EQ(point.transmission, 0.25F);
    EXPECT_EQ(point.alpha, 1);
}

TEST(Surface, AlbedoIsClampedBelowOneButTintIsNot) {
    const SurfacePoint point = at(scene_with({}), {0.3F, 0.3F});
    EXPECT_EQ(point.albedo, glm::vec3(max_albedo));
    EXPECT_EQ(point.tint, glm::vec3(1));
}

TEST(Texture, IsDecodedFromSrgbAtTexelCentres) {
    const Scene scene = scene_with_texels(4, 1, {0, 10, 128, 255});
    EXPECT_EQ(at(scene, {0.125F, 0.5F}).tint, glm::vec3(0));
    EXPECT_NEAR(at(scene, {0.375F, 0.5F}).tint.r, 10 / 255.0 / 12.92, ulp);
    EXPECT_NEAR(at(scene, {0.625F, 0.5F}).tint.r, std::pow((128 / 255.0 + 0.055) / 1.055, 2.4), ulp);
    EXPECT_EQ(at(scene, {0.875F, 0.5F}).tint, glm::vec3(1));
}

TEST(Texture, IsBilinearBetweenTexelCentresInLinearLight) {
    const Scene scene = scene_with_texels(2, 2, {0, 255, 255, 0});
    EXPECT_NEAR(at(scene, {0.5F, 0.25F}).tint.r, 0.5, ulp);
    EXPECT_NEAR(at(scene, {0.375F, 0.25F}).tint.r, 0.25, ulp);
    // A quarter of the way along both: 2 x 1/4 x 3/4.
    EXPECT_NEAR(at(scene, {0.375F, 0.375F}).tint.r, 0.375, ulp);
}

TEST(Texture, FirstRowIsAtTheTopWhereVIsZero) {
    const Scene scene = scene_with_texels(1, 2, {0, 255});
    EXPECT_EQ(at(scene, {0.5F, 0.25F}).tint.r, 0);
    EXPECT_EQ(at(scene, {0.5F, 0.75F}).tint.r, 1);
}

TEST(Texture, NearestTakesTheTexelThatItIsIn) {
    const Scene scene = scene_with_texels(2, 1, {0, 255}, {{}, Wrap::repeat, Wrap::repeat, true});
    EXPECT_EQ(at(scene, {0.49F, 0.5F}).tint.r, 0);
    EXPECT_EQ(at(scene, {0.51F, 0.5F}).tint.r, 1);
    EXPECT_EQ(at(scene, {0.0F, 0.0F}).tint.r, 0);
}

/// Reads a row of texels at u, which lies outside [0, 1], through the texture's transform.
float beyond(Wrap wrap, float u, bool nearest = false) {
    Scene scene = scene_with_texels(4, 1, {0, 255, 0, 0}, {{}, wrap, Wrap::repeat, nearest});
    scene.materials[0].base_color_texture.transform = {1, 0, 0, 1, u, 0};
    return at(scene, {0, 0.5F}).tint.r;
}

TEST(Texture, RepeatsMirrorsOrClampsBeyondItsEdges) {
    for (const bool nearest : {false, true}) {
        EXPECT_NEAR(beyond(Wrap::repeat, 1.375F, nearest), 1, ulp);
        EXPECT_NEAR(beyond(Wrap::repeat, -0.625F, nearest), 1, ulp);
        EXPECT_NEAR(beyond(Wrap::mirror, -0.375F, nearest), 1, ulp);
        EXPECT_NEAR(beyond(Wrap::mirror, 1.625F, nearest), 1, ulp);
        EXPECT_NEAR(beyond(Wrap::mirror, 2.375F, nearest), 1, ulp);
        EXPECT_NEAR(beyond(Wrap::clamp, 1.375F, nearest), 0, ulp);
        EXPECT_NEAR(beyond(Wrap::clamp, -3.0F, nearest), 0, ulp);
    }
}

TEST(Texture, BlendsAcrossTheEdgeOnlyWhereItRepeats) {
    const auto edge = [](Wrap wrap) {
        Scene scene = scene_with_texels(2, 1, {0, 255}, {{}, wrap, Wrap::repeat, false});
        return at(scene, {0, 0.5F}).tint.r;
    };
    EXPECT_NEAR(edge(Wrap::repeat), 0.5, ulp);
    EXPECT_EQ(edge(Wrap::mirror), 0);
    EXPECT_EQ(edge(Wrap::clamp), 0);
}

TEST(Texture, AnyCoordinateIsSafe) {
    for (const Wrap wrap : {Wrap::repeat, Wrap::mirror, Wrap::clamp})
        for (const float u : {1e30F, -1e30F, 1e38F, -1e-30F, std::numeric_limits<float>::infinity(),
                              std::numeric_limits<float>::quiet_NaN()})
            for (const bool nearest : {false, true}) {
                const float value = beyond(wrap, u, nearest);
                EXPECT_GE(value, 0) << u;
                EXPECT_LE(value, 1) << u;
            }
}

TEST(Surface, TransformAndUvSetChooseWhereToRead) {
    Scene scene = scene_with_texels(4, 1, {0, 0, 255, 0});
    scene.meshes[0].uv_sets = {{}, {{0, 0}, {1, 0}, {0, 1}}};
    scene.materials[0].base_color_texture.uv_set = 1;
    scene.materials[0].base_color_texture.transform = {0.5F, 0, 0, 1, 0.5F, 0};
    EXPECT_EQ(at(scene, {0.25F, 0.5F}).tint.r, 1);  // 0.5 x 0.25 + 0.5 = 0.625
}

TEST(Surface, VertexColoursAreInterpolatedAndMultiply) {
    Material material;
    material.base_color = {1, 0.5F, 1};
    Scene scene = scene_with(material);
    scene.meshes[0].colors = {{65535, 65535, 0, 65535}, {0, 65535, 0, 65535}, {0, 0, 0, 65535}};
    const glm::vec3 tint = at(scene, {0.25F, 0.25F}).tint;
    EXPECT_NEAR(tint.r, 0.5, ulp);
    EXPECT_NEAR(tint.g, 0.375, ulp);
    EXPECT_EQ(tint.b, 0);
}

TEST(Surface, EmissionTextureIsSrgbAndTransmissionTextureLinear) {
    Material material;
    material.emission = {10, 10, 10};
    material.emission_texture = first_texture();
    material.transmission = 0.5F;
    material.transmission_texture = first_texture();
    Scene scene = scene_with(material);
    scene.textures.push_back({{1, 1, {{51, 255, 0, 255}}}});
    const SurfacePoint point = at(scene, {0.3F, 0.3F});
    EXPECT_NEAR(point.emission.r, 10 * std::pow((0.2 + 0.055) / 1.055, 2.4), 10 * ulp);
    EXPECT_EQ(point.emission.g, 10);
    EXPECT_EQ(point.emission.b, 0);
    EXPECT_NEAR(point.transmission, 0.1, ulp);
}

Scene scene_with_alpha(AlphaMode mode) {
    Material material;
    material.alpha_mode = mode;
    material.alpha = 0.5F;
    material.base_color_texture = first_texture();
    Scene scene = scene_with(material);
    scene.meshes[0].colors.assign(3, {65535, 65535, 65535, 52428});  // 0.8
    scene.textures.push_back({{2, 1, {{255, 255, 255, 0}, {255, 255, 255, 255}}}});
    return scene;
}

TEST(Alpha, IsFactorTimesTextureTimesVertexAlpha) {
    const Scene scene = scene_with_alpha(AlphaMode::blend);
    EXPECT_NEAR(alpha(scene, {0.75F, 0.1F}), 0.4, ulp);
    EXPECT_NEAR(alpha(scene, {0.5F, 0.1F}), 0.2, ulp);
    EXPECT_EQ(alpha(scene, {0.25F, 0.1F}), 0);
}

TEST(Alpha, OfMaskIsAllOrNothingAtTheCutoff) {
    Scene scene = scene_with_alpha(AlphaMode::mask);
    scene.materials[0].alpha_cutoff = 0.2F;
    EXPECT_EQ(alpha(scene, {0.51F, 0.1F}), 1);
    EXPECT_EQ(alpha(scene, {0.49F, 0.1F}), 0);
}

TEST(Alpha, OfOpaqueIsIgnored) {
    EXPECT_EQ(alpha(scene_with_alpha(AlphaMode::opaque), {0.25F, 0.1F}), 1);
}

TEST(Alpha, IsTheSameInSurfaceAndAlone) {
    for (const AlphaMode mode : {AlphaMode::opaque, AlphaMode::mask, AlphaMode::blend}) {
        const Scene scene = scene_with_alpha(mode);
        for (float u = 0; u <= 1; u += 0.01F) EXPECT_EQ(at(scene, {u, 0}).alpha, alpha(scene, {u, 0})) << u;
    }
}

TEST(Box, GrowsFromEmpty) {
    Box box;
    EXPECT_TRUE(box.empty());
    EXPECT_EQ(box.size(), glm::dvec3(0));
    box.extend({1, 2, 3});
    box.extend({3, 2, 1});
    EXPECT_FALSE(box.empty());
    EXPECT_EQ(box.size(), glm::dvec3(2, 0, 2));
    EXPECT_EQ(box.center(), glm::dvec3(2, 2, 2));
}

}  // namespace
}  // namespace lightgrid
