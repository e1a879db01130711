#include "viewer/renderer.h"

#include "core/error.h"
#include "core/sh.h"
#include "tests/scene_builder.h"
#include "viewer/environment_light.h"
#include "viewer/headless.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace lightgrid {
namespace {

constexpr glm::ivec2 size(32, 16);
/// Light is kept as half.
constexpr float half_rounding = 1.0F / 1024;

/// The same radiance from everywhere: irradiance is pi times it.
std::shared_ptr<const LitVolume> uniform_light(glm::vec3 radiance) {
    Volume volume = make_volume({{{-8, -8, -8}, {4, 4, 4}, {5, 5, 5}}}, 3);
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        if (volume.states[slot] == ProbeState::absent) continue;
        volume.coefficients[slot * 9] = static_cast<float>(2 * std::sqrt(std::numbers::pi)) * radiance;
    }
    return std::make_shared<const LitVolume>(std::move(volume));
}

/// Looks along -Z from the origin, at whatever stands at z = -2 before a background of radiance `sky`.
class Picture : public testing::Test {
  protected:
    static constexpr glm::vec3 light{0.5F, 1, 2};
    static constexpr glm::vec3 sky{3, 1, 0.25F};

    Picture() : renderer_(surface_.gl(), built_in_shaders()) {
        scene_.bounds.extend({-2, -2, -3});
        scene_.bounds.extend({2, 2, 1});
    }

    /// A wall that fills the picture; `front` towards the eye.
    int add_wall(int material, bool front = true, float z = -2) {
        const glm::vec3 x(8, 0, 0);
        const glm::vec3 y(0, 8, 0);
        return add_quad(scene_, material, {-4, -4, z}, front ? x : y, front ? y : x);
    }

    RadianceImage draw(const Settings& settings = {}, int samples = 1) {
        renderer_.set_level(scene_, 1, std::vector<bool>(scene_.materials.size(), false));
        renderer_.set_volume(uniform_light(light));
        renderer_.set_environment(Environment::uniform(sky));
        const Pane pane{{glm::ivec2(0), size}, settings};
        renderer_.draw(frame_, std::span(&pane, 1), size, samples);
        return renderer_.read_light();
    }

    static void expect_light(const RadianceImage& image, glm::ivec2 pixel, glm::vec3 wanted,
                             float tolerance = half_rounding) {
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(image.at(pixel.x, pixel.y)[c], wanted[c], tolerance * wanted[c] + 1e-6F) << "channel " << c;
        }
    }
    static void expect_light(const RadianceImage& image, glm::vec3 wanted) { expect_light(image, size / 2, wanted); }

    Headless surface_;
    Renderer renderer_;
    Scene scene_;
    Frame frame_;
};

TEST_F(Picture, AWallShowsItsAlbedoInTheVolumesLight) {
    add_wall(add_grey(scene_, 0.5F));
    expect_light(draw(), 0.5F * light);
    for (const glm::ivec2 corner : {glm::ivec2(0), size - 1}) expect_light(draw(), corner, 0.5F * light);
}

TEST_F(Picture, BothSidesReflectAndOnlyTheFrontEmits) {
    Material lamp;
    lamp.base_color = glm::vec3(0.25F);
    lamp.emission = glm::vec3(7, 5, 3);
    const int material = add_material(scene_, lamp);
    const int wall = add_wall(material);
    expect_light(draw(), 0.25F * light + lamp.emission);
    for (glm::uvec3& t : scene_.meshes[wall].triangles) std::swap(t.y, t.z);
    expect_light(draw(), 0.25F * light);
    scene_.materials[material].double_sided = true;
    expect_light(draw(), 0.25F * light + lamp.emission);
}

TEST_F(Picture, WhatAMaterialEmitsIsWeighed) {
    Material lamp;
    lamp.base_color = glm::vec3(0);
    lamp.emission = glm::vec3(7, 5, 3);
    const int off = add_material(scene_, lamp);
    const int dimmed = add_material(scene_, lamp);
    add_wall(dimmed);
    expect_light(draw(), lamp.emission);
    std::vector<glm::vec3> weights(2, glm::vec3(0));
    weights[static_cast<std::size_t>(dimmed)] = {0.5F, 1, 2};
    renderer_.set_emission_weights(weights);
    const Settings settings;
    const Pane pane{{glm::ivec2(0), size}, settings};
    renderer_.draw(frame_, std::span(&pane, 1), size, 1);
    expect_light(renderer_.read_light(), weights[static_cast<std::size_t>(dimmed)] * lamp.emission);
    EXPECT_NE(off, dimmed);
    expect_light(draw(), lamp.emission);  // a level that is set anew
}

TEST_F(Picture, MirroredInstancesKeepTheirFront) {
    Material lamp;
    lamp.emission = glm::vec3(1);
    lamp.base_color = glm::vec3(0);
    const int mesh = store_mesh(scene_, add_material(scene_, lamp),
                                {{-4, -4, -2}, {4, -4, -2}, {4, 4, -2}, {-4, 4, -2}}, {{0, 1, 2}, {0, 2, 3}});
    add_instance(scene_, mesh, glm::mat4x3(-1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0));
    expect_light(draw(), glm::vec3(1));
}

TEST_F(Picture, BlendCoversByItsAlphaAndTransmissionTints) {
    Material glass;
    glass.base_color = {1, 0.5F, 0.25F};
    glass.alpha_mode = AlphaMode::blend;
    glass.alpha = 0.25F;
    glass.emission = glm::vec3(2);
    const int material = add_material(scene_, glass);
    add_wall(material);
    expect_light(draw(), 0.25F * (glass.base_color * light + glass.emission) + 0.75F * sky);

    scene_.materials[material].alpha_mode = AlphaMode::opaque;
    scene_.materials[material].emission = glm::vec3(0);
    scene_.materials[material].transmission = 0.75F;
    expect_light(draw(), 0.25F * glass.base_color * light + 0.75F * glass.base_color * sky);
}

TEST_F(Picture, TheNearerOfTwoPanesIsDrawnOverTheFarther) {
    Material pane;
    pane.alpha_mode = AlphaMode::blend;
    pane.base_color = glm::vec3(0);
    pane.alpha = 0.5F;
    pane.emission = glm::vec3(4, 0, 0);
    const int red = add_material(scene_, pane);
    pane.emission = glm::vec3(0, 4, 0);
    const int green = add_material(scene_, pane);
    add_wall(red, true, -2);
    add_wall(green, true, -3);
    expect_light(draw(), glm::vec3(2, 1, 0) + 0.25F * sky);
}

TEST_F(Picture, TrianglesOfOneMeshThatBlendsAreDrawnFromTheFarthestOn) {
    Material pane;
    pane.alpha_mode = AlphaMode::blend;
    pane.alpha = 0.5F;
    const int material = add_material(scene_, pane);
    // In the order in which they are stored the nearer come first, in the mesh and among its places.
    const int mesh = store_mesh(
        scene_, material,
        {{-4, -4, -2}, {4, -4, -2}, {4, 4, -2}, {-4, 4, -2}, {-4, -4, -3}, {4, -4, -3}, {4, 4, -3}, {-4, 4, -3}},
        {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}});
    for (int i = 0; i < 8; ++i) {
        scene_.meshes[static_cast<std::size_t>(mesh)].colors.push_back(i < 4 ? glm::u16vec4(65535, 0, 0, 65535)
                                                                             : glm::u16vec4(0, 65535, 0, 65535));
    }
    add_instance(scene_, mesh, glm::mat4x3(1));
    add_instance(scene_, mesh, glm::mat4x3(1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -2));
    const glm::vec3 red = light * glm::vec3(1, 0, 0);
    const glm::vec3 green = light * glm::vec3(0, 1, 0);
    expect_light(draw(), 0.5F * red + 0.25F * green + 0.125F * red + 0.0625F * green + 0.0625F * sky);
}

TEST_F(Picture, MaskCutsAwayWhatIsBelowItsCutoff) {
    Material leaf;
    leaf.base_color = glm::vec3(0.5F);
    leaf.alpha_mode = AlphaMode::mask;
    leaf.alpha = 0.6F;
    leaf.alpha_cutoff = 0.5F;
    const int material = add_material(scene_, leaf);
    add_wall(material);
    expect_light(draw(), 0.5F * light);
    scene_.materials[material].alpha_cutoff = 0.7F;
    expect_light(draw(), sky);
}

TEST_F(Picture, TexturesAreDecodedFromSrgbAndTransformed) {
    Material painted;
    painted.base_color_texture = {0, 0, glm::mat3x2(1, 0, 0, 1, 0.5F, 0)};  // half a turn to the side
    Texture halves;
    halves.image = {2, 1, {glm::u8vec4(255), glm::u8vec4(188, 0, 0, 255)}};
    halves.nearest = true;
    scene_.textures.push_back(halves);
    const int wall = add_wall(add_material(scene_, painted));
    scene_.meshes[wall].uv_sets = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
    const RadianceImage image = draw();
    const glm::vec3 red(decode_srgb(188), 0, 0);
    // OpenGL leaves sRGB decoding half a step of 8 bits: 0.6 % of what 188 stands for.
    expect_light(image, {4, 8}, red * light, 0.006F);
    expect_light(image, {28, 8}, light);
}

TEST_F(Picture, AnObjectIsLitAsAWholeAndHidesWhatIsBehindIt) {
    add_wall(add_grey(scene_, 0.5F));
    ObjectMesh sphere = make_sphere();
    sphere.materials[0].base_color = glm::vec3(0.8F);
    renderer_.set_object(sphere);
    frame_.object = ObjectPlace{.position = {0, 0, -1}, .size = 0.5F};
    Settings settings;
    settings.contact_shadow = false;
    const RadianceImage image = draw(settings);
    expect_light(image, 0.8F * light);
    expect_light(image, {0, 0}, 0.5F * light);
    settings.show_object = false;
    expect_light(draw(settings), 0.5F * light);
}

TEST_F(Picture, GainScalesLightFromTheVolumeAlone) {
    Material lamp;
    lamp.base_color = glm::vec3(0.5F);
    lamp.emission = glm::vec3(1);
    add_wall(add_material(scene_, lamp));
    Settings settings;
    settings.gain = 3;
    expect_light(draw(settings), 3.0F * 0.5F * light + lamp.emission);
}

TEST_F(Picture, PanesHaveSettingsOfTheirOwn) {
    add_wall(add_grey(scene_, 0.5F));
    static_cast<void>(draw());
    std::array<Pane, 2> panes{Pane{{{0, 0}, {16, 16}}, Settings{}}, Pane{{{16, 0}, {16, 16}}, Settings{}}};
    panes[1].settings.level_light = LevelLight::none;
    renderer_.draw(frame_, panes, size, 1);
    const RadianceImage image = renderer_.read_light();
    expect_light(image, {8, 8}, 0.5F * light);
    expect_light(image, {24, 8}, glm::vec3(0));
}

TEST_F(Picture, SeveralSamplesAPixelSmoothEdges) {
    add_quad(scene_, add_grey(scene_, 0.5F), {-4, -4, -2}, {8, 0, 0}, {0, 4.1F, 0});
    const auto differing = [&](int samples) {
        const RadianceImage image = draw({}, samples);
        int between = 0;
        for (int y = 0; y < size.y; ++y) {
            const float red = image.at(4, y).r;
            between += red > 0.26F && red < 2.9F ? 1 : 0;
        }
        return between;
    };
    EXPECT_EQ(differing(1), 0);
    EXPECT_EQ(differing(4), 1);
}

TEST_F(Picture, ExposureIsForTheAlbedoOfALightLevel) {
    static_cast<void>(draw());
    const float grey = renderer_.exposure();
    add_wall(add_grey(scene_, 0.2F));
    static_cast<void>(draw());
    EXPECT_FLOAT_EQ(renderer_.exposure(), grey) << "what is dark is not lightened";
    // As much of it again, in an instance of twice the size: (0.2 + 4 x 0.9) / 5.
    const int model = static_cast<int>(scene_.models.size());
    const int mesh = add_wall(add_grey(scene_, 0.9F));
    std::erase(scene_.placed, mesh);
    scene_.models.push_back({{mesh}});
    scene_.instances.push_back({model, glm::mat4x3(2)});
    static_cast<void>(draw());
    EXPECT_NEAR(renderer_.exposure(), grey * std::sqrt(0.5F / 0.76F), 1e-5F * grey);
}

TEST_F(Picture, ExposureIsForTheLightAround) {
    add_wall(add_grey(scene_, 0.5F));
    static_cast<void>(draw());
    // A grey surface comes out at 0.16 by luminance.
    const float bright = 0.2126F * light.r + 0.7152F * light.g + 0.0722F * light.b;
    EXPECT_NEAR(renderer_.exposure() * 0.5F * bright, 0.16F, 1e-3F);
    Settings settings;
    settings.exposure_stops = 2;
    const float before = renderer_.exposure();
    static_cast<void>(draw(settings));
    EXPECT_NEAR(renderer_.exposure(), 4 * before, 1e-5F);
    settings.automatic_exposure = false;
    static_cast<void>(draw(settings));
    EXPECT_EQ(renderer_.exposure(), 4);
}

TEST_F(Picture, IsDevelopedAsSrgbWithItsTopRowFirst) {
    add_quad(scene_, add_grey(scene_, 0.5F), {-4, 0, -2}, {8, 0, 0}, {0, 4, 0});  // the upper half
    Settings settings;
    settings.automatic_exposure = false;
    settings.tone = Tone::linear;
    static_cast<void>(draw(settings));
    const ByteImage picture = renderer_.target().read_picture();
    ASSERT_EQ(picture.width, size.x);
    ASSERT_EQ(picture.height, size.y);
    const glm::u8vec4 upper = picture.at(16, 2);
    EXPECT_NEAR(decode_srgb(upper.r), 0.25F, 0.005F);
    EXPECT_NEAR(decode_srgb(upper.g), 0.5F, 0.005F);
    EXPECT_EQ(upper.b, 255);
    EXPECT_EQ(picture.at(16, 13).r, 255);
    EXPECT_NEAR(decode_srgb(picture.at(16, 13).b), sky.b, 0.003F);
}

/// Positive everywhere, with something in each of six bands.
Sh36 six_bands() {
    Sh36 sh{};
    sh[0] = glm::vec3(20);
    for (std::size_t i = 1; i < sh.size(); ++i) {
        sh[i] = 0.5F * glm::vec3(std::sin(3.0F * i), std::cos(5.0F * i), std::sin(7.0F * i + 1));
    }
    return sh;
}

TEST_F(Picture, SixBandsOfTheBackgroundAreThoseOfTheLibrary) {
    const Sh36 sh = six_bands();
    Settings settings;
    settings.background = Background::light;
    settings.bands = most_bands;
    renderer_.set_volume(volume_of(sh));
    renderer_.set_environment(Environment::uniform(sky));
    const Pane pane{{glm::ivec2(0), size}, settings};
    for (const double yaw : {0.0, 75.0, 190.0, 300.0}) {
        for (const double pitch : {-60.0, 0.0, 45.0}) {
            frame_.pose = Pose{.yaw_deg = yaw, .pitch_deg = pitch};
            renderer_.draw(frame_, std::span(&pane, 1), size, 1);
            const RadianceImage image = renderer_.read_light();
            for (const glm::ivec2 pixel : {glm::ivec2(0), glm::ivec2(9, 4), size - 1}) {
                const glm::vec3 seen(ray_through(frame_.pose, frame_.lens, glm::dvec2(pixel), size));
                expect_light(image, pixel, evaluate_sh(sh, seen), 2 * half_rounding);
            }
        }
    }
}

TEST_F(Picture, AnObjectIsLitByAllBandsAndByTheReferenceWhereThatIsAsked) {
    renderer_.set_object(make_sphere());
    frame_.object = ObjectPlace{.position = {0, 0, -1}, .size = 0.5F};
    const Sh36 sh = six_bands();
    renderer_.set_volume(volume_of(sh));
    Settings settings;
    settings.dering = false;
    settings.self_shadowing = false;
    settings.bands = most_bands;
    Pane pane{{glm::ivec2(0), size}, settings};
    const auto shown = [&] {
        renderer_.draw(frame_, std::span(&pane, 1), size, 1);
        return renderer_.read_light();
    };
    const auto white = [](const Sh36& radiance) {  // the pixel's normal is 2 degrees off the axis at most
        return irradiance_from_sh(std::span<const glm::vec3>(radiance), glm::vec3(0, 0, 1)) / std::numbers::pi_v<float>;
    };
    expect_light(shown(), size / 2, white(sh), 0.01F);
    Sh36 other = sh;
    for (glm::vec3& c : other) c *= 2;
    other[20] += 20.0F;  // of band 4, which surfaces' three bands leave out
    frame_.reference = other;
    expect_light(shown(), size / 2, white(sh), 0.01F);
    pane.settings.object_light = ObjectLight::reference;
    expect_light(shown(), size / 2, white(other), 0.01F);
    frame_.reference.reset();
    expect_light(shown(), size / 2, white(sh), 0.01F);
}

TEST_F(Picture, TheEnvironmentTurnsWithItsLight) {
    RadianceImage halves{64, 32, {}};  // red where x > 0, else blue
    for (int y = 0; y < halves.height; ++y) {
        for (int x = 0; x < halves.width; ++x) {
            halves.pixels.push_back(x >= 16 && x < 48 ? glm::vec3(1, 0, 0) : glm::vec3(0, 0, 1));
        }
    }
    const Environment environment = Environment::from_image(halves);
    renderer_.set_environment(environment);
    frame_.pose = looking_at(glm::dvec3(0), glm::dvec3(0, 0, -1));
    frame_.environment_turn = glm::mat3(turn_about_up(90));  // what was at +X is ahead
    const Pane pane{{glm::ivec2(0), size}, Settings{}};
    renderer_.draw(frame_, std::span(&pane, 1), size, 1);
    expect_light(renderer_.read_light(), size / 2, {1, 0, 0});
    const Sh36 there = turned(reference_environment(environment), 90);
    EXPECT_GT(evaluate_sh(there, glm::vec3(0, 0, -1)).r, 3 * evaluate_sh(there, glm::vec3(0, 0, 1)).r);
}

TEST_F(Picture, CountsLookUpsAndBytesOfLight) {
    add_wall(add_grey(scene_, 0.5F));
    static_cast<void>(draw());
    const std::size_t first = renderer_.look_ups();
    EXPECT_GT(first, 8U) << "the level's vertices, both sides";
    const Pane pane{{glm::ivec2(0), size}, Settings{}};
    renderer_.draw(frame_, std::span(&pane, 1), size, 1);
    EXPECT_LT(renderer_.look_ups(), 4U) << "they are looked up once";
    const std::size_t bytes = renderer_.bytes_of_light();
    EXPECT_GT(bytes, 125 * 9 * sizeof(glm::vec3));
    Settings half;
    half.half = true;
    const Pane other{{glm::ivec2(0), size}, half};
    renderer_.draw(frame_, std::span(&other, 1), size, 1);
    EXPECT_GT(renderer_.bytes_of_light(), 3 * bytes / 2);
}

TEST_F(Picture, ASizeOfNothingIsRefused) {
    const Pane pane{{glm::ivec2(0), glm::ivec2(0)}, Settings{}};
    EXPECT_THROW(renderer_.draw(frame_, std::span(&pane, 1), {0, 5}, 1), Error);
}

}  // namespace
}  // namespace lightgrid
