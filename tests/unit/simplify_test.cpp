#include "core/simplify.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace lightgrid {
namespace {

/// A triangle with a material that reads base colour, emission and transmission from one texture each, if any.
Scene scene_with(const Material& material, std::vector<ByteImage> images = {}) {
    Scene scene;
    scene.materials.push_back(material);
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.triangles = {{0, 1, 2}};
    mesh.uv_sets = {{{0, 0}, {1, 0}, {0, 1}}};
    scene.meshes.push_back(mesh);
    for (ByteImage& image : images) scene.textures.push_back({std::move(image)});
    return scene;
}

TextureUse texture(int index) {
    TextureUse use;
    use.texture = index;
    return use;
}

ByteImage image_of(std::vector<glm::u8vec4> pixels) {
    return {static_cast<int>(pixels.size()), 1, std::move(pixels)};
}

bool lists(const Scene& scene, const std::string& what) {
    return std::any_of(scene.left_out.begin(), scene.left_out.end(),
                       [&](const LeftOut& entry) { return entry.what == what; });
}

Material blend(float alpha = 1) {
    Material material;
    material.alpha_mode = AlphaMode::blend;
    material.alpha = alpha;
    return material;
}

Material mask(float cutoff) {
    Material material;
    material.alpha_mode = AlphaMode::mask;
    material.alpha_cutoff = cutoff;
    return material;
}

TEST(Simplify, LeavesWhatLightReads) {
    Material material = blend(0.5F);
    material.base_color_texture = texture(0);
    Scene scene = scene_with(material, {image_of({{1, 2, 3, 255}, {3, 2, 1, 255}})});
    scene.meshes[0].colors = {{1, 2, 3, 4}, {5, 6, 7, 8}, {9, 10, 11, 12}};
    simplify(scene);
    EXPECT_EQ(scene.materials[0].alpha_mode, AlphaMode::blend);
    EXPECT_EQ(scene.textures.size(), 1U);
    EXPECT_EQ(scene.meshes[0].colors.size(), 3U);
    EXPECT_EQ(scene.meshes[0].uv_sets[0].size(), 3U);
    EXPECT_TRUE(scene.left_out.empty());
}

TEST(Simplify, BlendWithFullAlphaIsOpaque) {
    Scene scene = scene_with(blend());
    simplify(scene);
    EXPECT_EQ(scene.materials[0].alpha_mode, AlphaMode::opaque);
    EXPECT_TRUE(lists(scene, "alpha tests"));
}

TEST(Simplify, BlendStaysWhereTextureOrVerticesLetLightPass) {
    Material material = blend();
    material.base_color_texture = texture(0);
    Scene textured = scene_with(material, {image_of({{9, 9, 9, 255}, {9, 9, 9, 254}})});
    simplify(textured);
    EXPECT_EQ(textured.materials[0].alpha_mode, AlphaMode::blend);
    Scene colored = scene_with(blend());
    colored.meshes[0].colors = {{65535, 65535, 65535, 65535}, {65535, 65535, 65535, 65535}, {65535, 65535, 65535, 0}};
    simplify(colored);
    EXPECT_EQ(colored.materials[0].alpha_mode, AlphaMode::blend);
    EXPECT_EQ(colored.meshes[0].colors.size(), 3U);
}

TEST(Simplify, MaskIsOpaqueOrInvisibleWhereNoTexelLiesOnTheOtherSideOfTheCutoff) {
    Material material = mask(0.5F);
    material.base_color_texture = texture(0);
    Scene above = scene_with(material, {image_of({{9, 0, 9, 128}, {9, 9, 9, 255}})});
    simplify(above);
    EXPECT_EQ(above.materials[0].alpha_mode, AlphaMode::opaque);
    Scene below = scene_with(material, {image_of({{9, 0, 9, 127}, {9, 9, 9, 0}})});
    simplify(below);
    EXPECT_TRUE(below.meshes[0].triangles.empty());
    EXPECT_TRUE(lists(below, "invisible surfaces"));
    Scene across = scene_with(material, {image_of({{9, 0, 9, 127}, {9, 9, 9, 128}})});
    simplify(across);
    EXPECT_EQ(across.materials[0].alpha_mode, AlphaMode::mask);
    EXPECT_EQ(across.meshes[0].triangles.size(), 1U);
}

TEST(Simplify, BlendWithoutAlphaIsInvisible) {
    Scene scene = scene_with(blend(0));
    simplify(scene);
    EXPECT_TRUE(scene.meshes[0].triangles.empty());
}

TEST(Simplify, ATextureOfOneColourBecomesAFactor) {
    Material material;
    material.base_color = {0.5F, 1, 1};
    material.base_color_texture = texture(0);
    material.transmission = 0.5F;
    material.transmission_texture = texture(1);
    material.emission = {2, 2, 2};
    material.emission_texture = texture(2);
    // Alpha varies, but nothing reads it.
    Scene scene = scene_with(material, {image_of({{255, 0, 255, 3}, {255, 0, 255, 7}}), image_of({{51, 0, 0, 255}}),
                                        image_of({{255, 255, 0, 255}, {255, 255, 0, 255}})});
    const SurfacePoint before = surface_at(scene, scene.meshes[0], 0, {0.2F, 0.3F});
    simplify(scene);
    EXPECT_TRUE(scene.textures.empty());
    EXPECT_TRUE(scene.meshes[0].uv_sets[0].empty());
    const SurfacePoint after = surface_at(scene, scene.meshes[0], 0, {0.2F, 0.3F});
    EXPECT_EQ(after.tint, before.tint);
    EXPECT_EQ(after.transmission, before.transmission);
    EXPECT_EQ(after.emission, before.emission);
    EXPECT_TRUE(lists(scene, "textures"));
    EXPECT_TRUE(lists(scene, "texture coordinates"));
}

TEST(Simplify, EmissionThatItsTextureMakesBlackIsNone) {
    Material material;
    material.emission = {5, 0, 0};
    material.emission_texture = texture(0);
    Scene scene = scene_with(material, {image_of({{0, 255, 9, 255}, {0, 1, 0, 255}})});
    simplify(scene);
    EXPECT_FALSE(scene.materials[0].emits());
    EXPECT_TRUE(scene.textures.empty());
    EXPECT_TRUE(lists(scene, "emission"));
}

TEST(Simplify, WhiteVertexColoursAreDropped) {
    Scene scene = scene_with({});
    scene.meshes[0].colors.assign(3, {65535, 65535, 65535, 17});  // nothing reads the alpha
    simplify(scene);
    EXPECT_TRUE(scene.meshes[0].colors.empty());
    EXPECT_TRUE(lists(scene, "vertex colours"));
}

TEST(Simplify, RenumbersTexturesThatAreKept) {
    Material material;
    material.base_color_texture = texture(1);
    Scene scene = scene_with(material, {image_of({{1, 1, 1, 1}}), image_of({{1, 1, 1, 255}, {2, 2, 2, 255}})});
    simplify(scene);
    ASSERT_EQ(scene.textures.size(), 1U);
    EXPECT_EQ(scene.materials[0].base_color_texture.texture, 0);
    EXPECT_EQ(scene.textures[0].image.width, 2);
}

}  // namespace
}  // namespace lightgrid
