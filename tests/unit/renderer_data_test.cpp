// Light pixel by pixel, what an object hides, and the data of a volume, as they are drawn.

#include "core/error.h"
#include "core/sampling.h"
#include "core/sh.h"
#include "tests/scene_builder.h"
#include "tests/unit/random_volume.h"
#include "tools/false_color.h"
#include "viewer/controls.h"
#include "viewer/crowd.h"
#include "viewer/headless.h"
#include "viewer/object_shadow.h"
#include "viewer/probes_shown.h"
#include "viewer/renderer.h"
#include "viewer/transfer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

namespace lightgrid {
namespace {

constexpr glm::ivec2 size(64, 32);
constexpr float wall_z = -2;
/// Light is kept as half; the shader's own look-up is equal to 1e-3 of the light around.
constexpr float tolerance = 1.5e-3F;

/// A wall across the view, at the origin of whose axes the eye stands and looks along -Z.
class Lit : public testing::Test {
  protected:
    Lit() : renderer_(surface_.gl(), built_in_shaders()) {
        add_quad(scene_, add_grey(scene_, 0.5F), {-8, -8, wall_z}, {16, 0, 0}, {0, 16, 0});
        settings_.automatic_exposure = false;
        settings_.tone = Tone::linear;
    }

    void set_volume(Volume volume) {
        lit_ = std::make_shared<const LitVolume>(std::move(volume));
        renderer_.set_level(scene_, 1, {false});
        renderer_.set_volume(lit_);
    }
    void set_shadowed_object(const ObjectMesh& object) {
        renderer_.set_object(object);
        renderer_.set_object_transfer(self_shadowed_transfer(object));
    }
    RadianceImage draw() {
        const Pane pane{{glm::ivec2(0), size}, settings_};
        renderer_.draw(frame_, std::span(&pane, 1), size, 1);
        return renderer_.read_light();
    }
    /// What a pixel shows of the plane at this depth.
    [[nodiscard]] glm::dvec3 seen_at(int x, int y, double z) const {
        const glm::dvec3 ray = ray_through(frame_.pose, frame_.lens, glm::dvec2(x, y), size);
        return ray * (z / ray.z);
    }
    [[nodiscard]] LookUp looked_up() const { return look_up(*lit_, settings_); }

    /// The share of pixels that differ from `wanted` by more than the tolerance of the light around.
    [[nodiscard]] double differing(const RadianceImage& image, const std::function<glm::vec3(int, int)>& wanted) const {
        int count = 0;
        for (int y = 0; y < size.y; ++y) {
            for (int x = 0; x < size.x; ++x) {
                const glm::vec3 want = wanted(x, y);
                const glm::vec3 around = mean_irradiance_at(looked_up(), seen_at(x, y, wall_z));
                const float off = glm::length(image.at(x, y) - want);
                count += off > tolerance * (glm::length(want) + glm::length(around)) ? 1 : 0;
            }
        }
        return count / static_cast<double>(size.x * size.y);
    }

    Headless surface_;
    Renderer renderer_;
    Scene scene_;
    Frame frame_;
    Settings settings_;
    std::shared_ptr<const LitVolume> lit_;
};

const Grid around_wall{{-9, -9, -4}, {0.9, 0.8, 0.7}, {21, 23, 8}};

/// The same light everywhere: one distant light, and an even rest.
Volume even_volume(glm::vec3 towards, float illuminance, float ambient) {
    Volume volume = make_volume({around_wall}, 3);
    std::vector<glm::vec3> light = delta_light_sh(3, towards, glm::vec3(illuminance));
    light[0] += 2 * std::sqrt(std::numbers::pi_v<float>) * ambient;
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        if (volume.states[slot] == ProbeState::absent) continue;
        std::copy(light.begin(), light.end(), volume.coefficients.begin() + static_cast<std::ptrdiff_t>(9 * slot));
    }
    return volume;
}

TEST_F(Lit, ALevelLitPerPixelShowsWhatTheSamplerSays) {
    for (const int bands : {1, 2, 3}) {  // of the volume
        set_volume(random_volume({around_wall}, bands, mostly_valid));
        settings_.level_light = LevelLight::pixel;
        settings_.dering = false;
        for (settings_.bands = 1; settings_.bands <= bands; ++settings_.bands) {
            const auto wanted = [&](int x, int y) {
                return 0.5F * std::numbers::inv_pi_v<float> *
                       surface_irradiance(looked_up(), seen_at(x, y, wall_z), {0, 0, 1});
            };
            settings_.filter = Filter::trilinear;
            EXPECT_EQ(differing(draw(), wanted), 0) << settings_.bands << " bands of " << bands;
            settings_.filter = Filter::nearest;
            // Where two probes are as near, either may answer.
            EXPECT_LT(differing(draw(), wanted), 0.01) << settings_.bands << " bands of " << bands << ", nearest";
        }
    }
}

TEST_F(Lit, DeringedLightOfTheLevelIsNowhereBlack) {
    // One light a little behind the wall's plane: three bands make its front negative.
    set_volume(even_volume({std::sqrt(1 - 0.3F * 0.3F), 0, -0.3F}, 5, 0));
    for (const LevelLight level : {LevelLight::vertex, LevelLight::pixel}) {
        settings_.level_light = level;
        for (const bool dering : {false, true}) {
            settings_.dering = dering;
            const RadianceImage image = draw();
            int black = 0;
            for (int y = 0; y < size.y; ++y) {
                for (int x = 0; x < size.x; ++x) black += image.at(x, y) == glm::vec3(0) ? 1 : 0;
            }
            if (dering) {
                EXPECT_EQ(black, 0);
            } else {
                EXPECT_GT(black, size.x * size.y / 2) << "or this test says nothing";
            }
        }
    }
}

TEST_F(Lit, PerPixelAndPerVertexAreTheSameInEvenLight) {
    set_volume(even_volume(glm::normalize(glm::vec3(1, 2, 3)), 5, 0.5F));
    const RadianceImage by_vertex = draw();
    settings_.level_light = LevelLight::pixel;
    EXPECT_EQ(differing(draw(), [&](int x, int y) { return by_vertex.at(x, y); }), 0);
}

TEST_F(Lit, AnObjectLitPerPixelShowsWhatTheSamplerSays) {
    constexpr float z = -1.5F;
    Scene board;
    add_quad(board, add_grey(board, 0.25F), {-0.5F, -0.5F, 0}, {1, 0, 0}, {0, 1, 0});
    renderer_.set_object(object_from_scene(board));
    set_volume(random_volume({around_wall}, 3, mostly_valid));
    frame_.object = ObjectPlace{.position = {0, 0, z}, .size = 8};
    settings_.object_light = ObjectLight::pixel;
    const auto wanted = [&](int x, int y) {
        LookUp at = looked_up();
        at.normal_bias = 0;
        return 0.25F * std::numbers::inv_pi_v<float> * surface_irradiance(at, seen_at(x, y, z), {0, 0, 1});
    };
    for (settings_.bands = 1; settings_.bands <= 3; ++settings_.bands) {
        settings_.self_shadowing = false;
        EXPECT_EQ(differing(draw(), wanted), 0) << settings_.bands;
    }
}

TEST_F(Lit, SelfShadowingLeavesAloneWhatHidesNothing) {
    set_shadowed_object(make_sphere());
    set_volume(even_volume(glm::normalize(glm::vec3(1, 1, 2)), 5, 2));
    frame_.object = ObjectPlace{.position = {0, 0, -1}, .rotation = glm::mat3(0, 1, 0, 0, 0, 1, 1, 0, 0)};
    for (const ObjectLight light : {ObjectLight::object, ObjectLight::pixel}) {
        settings_.object_light = light;
        settings_.self_shadowing = false;
        const RadianceImage plain = draw();
        settings_.self_shadowing = true;
        // Interpolated between vertices 1/64 of a turn apart: off by up to (pi / 64)^2 / 2 of what varies.
        const RadianceImage shadowed = draw();
        for (const glm::ivec2 pixel : {glm::ivec2(32, 16), glm::ivec2(25, 10), glm::ivec2(38, 20)}) {
            const float got = shadowed.at(pixel.x, pixel.y).g;
            EXPECT_NEAR(got, plain.at(pixel.x, pixel.y).g, 4e-3F * got);
        }
    }
}

TEST_F(Lit, SelfShadowingDarkensAHollow) {
    // A board at the bottom of a black well that is open towards the eye.
    Scene well;
    const int white = add_grey(well, 0.8F);
    const int black = add_grey(well, 0);
    add_quad(well, white, {-0.2F, -0.2F, 0}, {0.4F, 0, 0}, {0, 0.4F, 0});
    add_box(well, black, {-0.2F, -0.2F, -0.01F}, {0.2F, 0.2F, 0.8F}, Facing::inward);
    Mesh& box = well.meshes.back();
    std::erase_if(box.triangles, [&](const glm::uvec3& t) {
        return box.positions[t.x].z > 0.5F && box.positions[t.y].z > 0.5F && box.positions[t.z].z > 0.5F;
    });
    const ObjectMesh object = object_from_scene(well);
    renderer_.set_object(object);
    set_volume(even_volume({0, 0, 1}, 0, 1));
    frame_.object = ObjectPlace{.position = {0, 0, -1.5}, .size = 1};
    ASSERT_TRUE(settings_.self_shadowing);
    EXPECT_NEAR(draw().at(32, 16).g, 0.8F, 0.01F) << "unshadowed while its transfer is not known";
    set_shadowed_object(object);
    for (const ObjectLight light : {ObjectLight::object, ObjectLight::pixel}) {
        settings_.object_light = light;
        settings_.self_shadowing = false;
        EXPECT_NEAR(draw().at(32, 16).g, 0.8F, 0.01F);
        settings_.self_shadowing = true;
        // Form factor of the square mouth from its corners on the floor, and more from its middle, which no vertex is at:
        // between 0.05 and 0.13 of the sky.
        const float seen = draw().at(32, 16).g / 0.8F;
        EXPECT_GT(seen, 0.02F);
        EXPECT_LT(seen, 0.2F);
    }
}

TEST_F(Lit, TheContactShadowFallsAwayFromTheLight) {
    renderer_.set_object(make_sphere());
    constexpr float illuminance = 5;
    constexpr float ambient = 0.25F;
    const glm::vec3 towards = glm::normalize(glm::vec3(1, 0, 1));
    set_volume(even_volume(towards, illuminance, ambient));
    frame_.object = ObjectPlace{.position = {0, 0, -1.5}, .size = 0.5F};
    settings_.contact_shadow = false;
    const RadianceImage without = draw();
    for (const LevelLight light : {LevelLight::vertex, LevelLight::pixel}) {
        settings_.level_light = light;
        settings_.contact_shadow = true;
        const RadianceImage with = draw();
        const auto kept = [&](double x, double y) {
            // The pixel that sees this point of the wall.
            const double pixels = 0.5 * size.y / std::tan(glm::radians(frame_.lens.vertical_angle_deg) / 2) / -wall_z;
            const glm::ivec2 at(static_cast<int>(0.5 * size.x + x * pixels),
                                static_cast<int>(0.5 * size.y - y * pixels));
            return with.at(at.x, at.y).g / without.at(at.x, at.y).g;
        };
        // On the axis of the shadow all of the light is hidden, and of the rest what a sphere hides; 0.85 of both.
        const float cosine = std::sqrt(0.5F);
        const float share = illuminance * cosine / (illuminance * cosine + std::numbers::pi_v<float> * ambient);
        const float hidden = 0.25F * 0.25F / 0.5F * cosine;
        EXPECT_NEAR(kept(-0.5, 0), 1 - 0.85F * (share + (1 - share) * hidden), 0.02);
        EXPECT_GT(kept(0.5, 0), 0.98);
        EXPECT_GT(kept(-0.5, 0.8), 0.98);
        settings_.show_object = false;
        EXPECT_EQ(draw().at(20, 16), light == LevelLight::vertex ? without.at(20, 16) : draw().at(20, 16));
        settings_.show_object = true;
    }
}

TEST(ObjectShadow, TellsTrianglesApartThatItMayDarken) {
    Scene scene;
    add_quad(scene, add_grey(scene, 0.5F), {-3, 0, 3}, {6, 0, 0}, {0, 0, -6});
    LevelMesh mesh = build_level_mesh(scene, 0.3);
    ObjectShadow shadow{.center = {0, 1, 0}, .radius = 0.1F, .light = {}};
    shadow.light.direction = glm::normalize(glm::vec3(0.5F, 1, 0));
    const LevelDraw* draw = mesh.draws.data();
    const ShadowSplit split = split_by_shadow(mesh, std::span(&draw, 1), shadow);
    EXPECT_EQ(split.indices.size(), mesh.indices.size());
    ASSERT_EQ(split.shaded.size(), 1U);
    ASSERT_EQ(split.others.size(), 1U);
    // The shadow's axis meets the floor at (-0.5, 0, 0), 11 radii away, where it is 0.4 m wide to each side; the sky
    // is hidden no farther than 7 radii, which do not reach the floor.
    const auto nearest = [&](const LevelDraw& part) {
        double least = 1e9;
        for (std::uint32_t i = part.first_index; i < part.first_index + part.index_count; ++i) {
            least = std::min(
                least, glm::distance(glm::dvec3(mesh.vertices[split.indices[i]].position), glm::dvec3(-0.5, 0, 0)));
        }
        return least;
    };
    EXPECT_LT(nearest(split.shaded[0]), 0.3);
    EXPECT_GT(nearest(split.others[0]), 0.3);
    EXPECT_LT(split.shaded[0].index_count, split.others[0].index_count / 4);
}

TEST_F(Lit, FalseColorsAreThoseOfTheScaleWhateverTheToneMap) {
    Volume volume = even_volume({0, 0, 1}, 3, 1);
    const float error = 0.5F;
    volume.axis_errors.assign(6 * volume.slots(), glm::vec3(error));
    set_volume(std::move(volume));
    const glm::ivec2 at(5, 20);
    const float irradiance = luminance(surface_irradiance(looked_up(), {0, 0, wall_z}, {0, 0, 1}));
    const float mean = luminance(mean_irradiance_at(looked_up(), {0, 0, wall_z}));
    for (const Tone tone : {Tone::film, Tone::reinhard, Tone::linear}) {
        settings_.tone = tone;
        for (const LevelLight light : {LevelLight::vertex, LevelLight::pixel}) {
            settings_.level_light = light;
            for (const LevelColors colors : {LevelColors::irradiance, LevelColors::standard_error}) {
                settings_.level_colors = colors;
                static_cast<void>(draw());
                const glm::u8vec4 got = renderer_.target().read_picture().at(at.x, at.y);
                std::vector<VertexLight> both{{glm::vec4(irradiance), glm::vec4(0)}};
                glm::vec3 want;
                if (colors == LevelColors::irradiance) {
                    // The back of the wall is darker: the scale reaches from it to the front.
                    const float back = luminance(surface_irradiance(looked_up(), {0, 0, wall_z}, {0, 0, -1}));
                    want = false_color(static_cast<float>(scale_of({irradiance, back}).place(irradiance)));
                } else {
                    // Of eight probes that weigh the same, or one: the scale is of all vertices' errors.
                    EXPECT_LE(surface_error(looked_up(), {0, 0, wall_z}, {0, 0, 1}), error / mean);
                    EXPECT_GE(surface_error(looked_up(), {0, 0, wall_z}, {0, 0, 1}), error / mean / std::sqrt(8.1F));
                    continue;
                }
                for (int c = 0; c < 3; ++c) EXPECT_NEAR(got[c], 255 * want[c], 2.5) << static_cast<int>(tone);
            }
        }
    }
}

TEST_F(Lit, DifferencesAreGreyUntilTheyAreKnown) {
    set_volume(even_volume({0, 0, 1}, 3, 1));
    settings_.tone = Tone::linear;
    settings_.level_colors = LevelColors::difference;
    const auto shown = [&] {
        static_cast<void>(draw());
        return renderer_.target().read_picture().at(5, 20);
    };
    const auto expect_color = [&](glm::vec3 want) {
        const glm::u8vec4 got = shown();
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(got[c], 255 * want[c], 2.5);
    };
    expect_color(glm::vec3(0.35F));
    const float said = luminance(surface_irradiance(looked_up(), {0, 0, wall_z}, {0, 0, 1}));
    auto map = std::make_shared<ReferenceMap>();
    map->places.push_back({.position = {0, 0, wall_z}, .normal = {0, 0, 1}, .apart = 100, .samples = 16});
    map->places.back().irradiance.mean = glm::dvec3(said / 1.2F);
    map->traced = 1;
    renderer_.set_reference(map);
    expect_color(false_color(static_cast<float>(difference_scale().place(0.2F))));
    renderer_.set_reference(nullptr);
    expect_color(glm::vec3(0.35F));
}

TEST_F(Lit, TheLegendIsInTheUpperRightCorner) {
    set_volume(even_volume({0, 0, 1}, 3, 1));
    settings_.level_colors = LevelColors::irradiance;
    constexpr glm::ivec2 large(640, 360);
    const Pane pane{{glm::ivec2(0), large}, settings_};
    renderer_.draw(frame_, std::span(&pane, 1), large, 1);
    const ByteImage picture = renderer_.target().read_picture();
    const glm::u8vec4 paper(0xF4, 0xF2, 0xEE, 255);
    EXPECT_EQ(picture.at(large.x - 1, 0), paper);
    EXPECT_NE(picture.at(0, 0), paper);
    EXPECT_NE(picture.at(large.x - 1, large.y - 1), paper);
}

TEST_F(Lit, ProbesShowTheirOwnLightWithinARimOfTheirState) {
    Volume volume = make_volume({{{0, 0, -0.25}, {1, 1, 1}, {1, 1, 1}}}, 3);
    volume.coefficients[0] = glm::vec3(2 * std::sqrt(std::numbers::pi_v<float>));  // radiance 1
    for (const ProbeState state : {ProbeState::valid, ProbeState::moved, ProbeState::filled, ProbeState::missing}) {
        volume.states[0] = state;
        set_volume(volume);
        settings_.probes = ProbesShown::none;
        const glm::vec3 wall = draw().at(32, 16);
        settings_.probes = ProbesShown::in_sight;
        const RadianceImage image = draw();
        EXPECT_NEAR(image.at(32, 16).g, 0.8F, 0.01F);
        EXPECT_EQ(image.at(2, 16), wall);
        // 0.12 spacings at 0.25 m; the rim is the outer fifth.
        const double radius = 0.12 / 0.25 / std::tan(glm::radians(frame_.lens.vertical_angle_deg) / 2) * size.y / 2;
        const int rim = static_cast<int>(std::floor(0.5 * size.x + 0.95 * radius));
        const glm::u8vec4 got = renderer_.target().read_picture().at(rim, 16);
        const glm::vec3 want = 255.0F * state_color(state);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(got[c], want[c], 2.5) << static_cast<int>(state);
        if (state == ProbeState::valid) {
            frame_.pose.eye.z = -4;  // behind the wall
            frame_.pose.yaw_deg = 180;
            EXPECT_EQ(draw().at(32, 16), draw().at(2, 16));
            settings_.probes = ProbesShown::all;
            EXPECT_NE(draw().at(32, 16), draw().at(2, 16));
            frame_.pose = {};
        }
    }
}

TEST_F(Lit, AllSettingsAreDrawnWithoutAComplaint) {
    set_shadowed_object(make_sphere(8));
    Material cut;
    cut.alpha_mode = AlphaMode::mask;
    add_quad(scene_, add_material(scene_, cut), {-1, -1, -1.9F}, {1, 0, 0}, {0, 1, 0});
    cut.alpha_mode = AlphaMode::blend;
    add_quad(scene_, add_material(scene_, cut), {0, 0, -1.9F}, {1, 0, 0}, {0, 1, 0});
    lit_ = std::make_shared<const LitVolume>(random_volume({around_wall}, 3, any_state));
    renderer_.set_level(scene_, 1, {false, false, false});
    renderer_.set_volume(lit_);
    frame_.object = ObjectPlace{.position = {0, 0, -1.5}, .size = 0.5F};
    for (const LevelLight level : {LevelLight::none, LevelLight::constant, LevelLight::vertex, LevelLight::pixel}) {
        for (const ObjectLight object : {ObjectLight::constant, ObjectLight::object, ObjectLight::pixel}) {
            for (const LevelColors colors : {LevelColors::surface, LevelColors::irradiance, LevelColors::standard_error,
                                             LevelColors::difference}) {
                for (const bool on : {false, true}) {
                    settings_.level_light = level;
                    settings_.object_light = object;
                    settings_.level_colors = colors;
                    settings_.filter = on ? Filter::nearest : Filter::trilinear;
                    settings_.half = on;
                    settings_.contact_shadow = on;
                    settings_.self_shadowing = on;
                    settings_.show_cell = on;
                    settings_.show_crowd = on;
                    settings_.probes = on ? ProbesShown::all : ProbesShown::in_sight;
                    EXPECT_NO_THROW(static_cast<void>(draw()));
                }
            }
        }
    }
}

TEST(CellShown, HasTwelveEdgesAndBallsAsLargeAsTheirWeights) {
    Volume volume = make_volume({{{0, 0, 0}, {1, 1, 1}, {3, 3, 3}}}, 1);
    volume.states[0] = ProbeState::filled;
    const LitVolume lit(volume);
    const LookUp from{.volume = &lit};
    const glm::dvec3 at(0.25, 0.5, 0.5);
    const ShownCell cell = cell_shown(from, at, {10, 0, 0});
    ASSERT_EQ(cell.balls.size(), 7U);  // the eighth is invalid
    EXPECT_EQ(cell.lines.size(), 2U * (12 + 7));
    const Sampler::Corners corners = corners_of(from, at);
    for (std::size_t i = 0; i < cell.balls.size(); ++i) {
        EXPECT_NEAR(std::pow(cell.balls[i].radius / 0.2F, 3), corners.weights[i], 1e-6F);
        EXPECT_EQ(cell.balls[i].center, glm::vec3(lattice_position(volume, corners.slots[i]) - glm::dvec3(10, 0, 0)));
    }
    for (const LineEnd& end : cell.lines) {
        EXPECT_GE(end.position.x, -10);
        EXPECT_LE(end.position.x, -9);
    }
    EXPECT_EQ(cell_shown({.volume = &lit, .filter = Filter::nearest}, at, {}).balls.size(), 1U);
}

TEST(Crowd, MovesAndIsLitWhereItIs) {
    const LitVolume lit(random_volume({around_wall}, 3, any_state));
    const LookUp from{.volume = &lit};
    const glm::dvec3 origin(3, 2, 1);
    std::vector<Ball> crowd = crowd_at(lit, 0, origin);
    ASSERT_EQ(crowd.size(), crowd_size);
    const std::vector<Ball> later = crowd_at(lit, 1, origin);
    light_crowd(from, origin, crowd);
    for (std::size_t i = 0; i < crowd.size(); ++i) {
        EXPECT_NE(crowd[i].center, later[i].center);
        EXPECT_EQ(crowd[i].radiance, radiance_sh(from, origin + glm::dvec3(crowd[i].center)));
    }
    EXPECT_TRUE(
        crowd_at(LitVolume(random_volume({around_wall}, 1, [](auto&) { return ProbeState::missing; })), 0, origin)
            .empty());
}

TEST(SurfaceError, FallsWithTheNumberOfProbesAndFollowsTheAxes) {
    Volume volume = make_volume({{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}}, 1);
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        if (volume.states[slot] == ProbeState::absent) continue;
        volume.coefficients[slot] = glm::vec3(2 / std::sqrt(std::numbers::pi_v<float>));  // mean irradiance 1
        volume.axis_errors[6 * slot] = glm::vec3(0.3F);                                   // of +X
        volume.axis_errors[6 * slot + 2] = glm::vec3(0.4F);                               // of +Y
    }
    const LitVolume lit(volume);
    const LookUp from{.volume = &lit};
    EXPECT_NEAR(surface_error(from, {0, 0, 0}, {1, 0, 0}), 0.3F, 1e-6F);
    EXPECT_NEAR(surface_error(from, {0.5, 0.5, 0.5}, {1, 0, 0}), 0.3F / std::sqrt(8.0F), 1e-6F);
    EXPECT_NEAR(surface_error(from, {0, 0, 0}, {-1, 0, 0}), 0, 1e-6F);
    EXPECT_NEAR(surface_error(from, {0, 0, 0}, {0.6F, 0.8F, 0}), std::hypot(0.6F * 0.3F, 0.8F * 0.4F), 1e-6F);
}

TEST(Controls, KeysOfTheCommandLineSwitchSettings) {
    const Settings settings = settings_after("zZVj");
    EXPECT_EQ(settings.probes, ProbesShown::all);
    EXPECT_EQ(settings.level_colors, LevelColors::irradiance);
    EXPECT_FALSE(settings.contact_shadow);
    EXPECT_EQ(settings_after(""), Settings{});
    for (const char* keys : {"!", "w", "r"}) EXPECT_THROW(static_cast<void>(settings_after(keys)), Error) << keys;
}

}  // namespace
}  // namespace lightgrid
