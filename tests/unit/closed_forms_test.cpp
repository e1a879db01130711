// Light that is known exactly, through the whole of the estimator: the sky, lights, lamps, furnaces, panes.

#include "core/parallel.h"
#include "core/sh.h"
#include "probes/gather.h"
#include "tests/cached_light.h"
#include "tests/polygon_light.h"
#include "tests/scene_builder.h"
#include "tests/traced_level.h"

#include <fmt/format.h>
#include <glm/gtc/constants.hpp>
#include <gtest/gtest.h>

#include <cmath>

namespace lightgrid {
namespace {

constexpr double pi = glm::pi<double>();

const Environment white_sky = Environment::uniform(glm::vec3(1));

GatherOptions options_for(std::vector<glm::vec3> normals, std::uint32_t samples = 65536) {
    GatherOptions options;
    options.samples = samples;
    options.replicates = 64;  // so many that a standard error is known to 9 %
    options.normals = std::move(normals);
    return options;
}

/// Within three standard errors or 1e-5 of the exact value, with a standard error below some share of it.
void expect_exact(const Estimate& ours, glm::dvec3 exact, const std::string& what, double most_error = 0.005) {
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(ours.mean[c], exact[c], std::max(3 * ours.error[c], 1e-5 * std::abs(exact[c])))
            << what << ", colour " << c << ", standard error " << ours.error[c];
        EXPECT_LE(ours.error[c], most_error * std::abs(exact[c])) << what << ", colour " << c;
    }
}

void expect_irradiance(const TracedLevel& level, glm::vec3 point, glm::vec3 normal, glm::dvec3 exact,
                       const std::string& what) {
    GatherOptions options = options_for({normal});
    expect_exact(gather(level.paths, {point}, options).irradiance[0], exact, what);
    options.seed = 1;
    expect_exact(gather_by_cache(level.paths, {point}, {}, options).irradiance[0], exact, what + ", by cache", 0.01);
}

void expect_irradiance(const TracedLevel& level, glm::vec3 point, glm::vec3 normal, double exact,
                       const std::string& what) {
    expect_irradiance(level, point, normal, glm::dvec3(exact), what);
}

const std::vector<glm::vec3> some_normals = {
    {0, 1, 0}, {0, -1, 0}, {1, 0, 0}, glm::normalize(glm::vec3(1, 2, -2)), glm::normalize(glm::vec3(-3, -1, 1))};

TEST(ClosedForms, UniformSkyGivesPi) {
    const TracedLevel level({}, white_sky);
    const Gather light = gather(level.paths, {{0.3F, -2, 7}}, options_for(some_normals));
    for (const Estimate& irradiance : light.irradiance) expect_exact(irradiance, glm::dvec3(pi), "uniform sky");
    expect_exact(light.sh(0)[0], glm::dvec3(2 * std::sqrt(pi)), "L_0");
    for (std::size_t i = 1; i < 9; ++i) {
        EXPECT_NEAR(light.sh(0)[i].mean.x, 0, 3 * light.sh(0)[i].error.x + 1e-5) << i;
    }
    for (const Estimate& irradiance : light.axis_irradiance) expect_exact(irradiance, glm::dvec3(pi), "through SH");
}

TEST(ClosedForms, UpperHalfOfTheSkyLightsByTheCosineOfTheSlope) {
    // A black tray whose rim is at the height of the point hides exactly the lower half.
    Scene scene;
    const int black = add_grey(scene, 0);
    add_quad(scene, black, {-2, -1, -3}, {0, 0, 6}, {4, 0, 0});
    add_quad(scene, black, {-2, -1, -3}, {4, 0, 0}, {0, 1, 0});
    add_quad(scene, black, {-2, -1, 3}, {0, 1, 0}, {4, 0, 0});
    add_quad(scene, black, {-2, -1, -3}, {0, 1, 0}, {0, 0, 6});
    add_quad(scene, black, {2, -1, -3}, {0, 0, 6}, {0, 1, 0});
    const TracedLevel level(std::move(scene), white_sky);
    for (const double slope_deg : {0.0, 30.0, 77.0, 90.0, 130.0, 145.0}) {
        const double slope = glm::radians(slope_deg);
        const glm::vec3 normal(std::sin(slope) * 0.6, std::cos(slope), std::sin(slope) * 0.8);
        expect_irradiance(level, {0.5F, 0, 1}, normal, pi * (1 + std::cos(slope)) / 2,
                          fmt::format("slope of {} degrees", slope_deg));
    }
    EXPECT_EQ(gather(level.paths, {{0, 0, 0}}, options_for({{0, -1, 0}})).irradiance[0].mean, glm::dvec3(0));
}

TEST(ClosedForms, DirectionalLightWithAndWithoutAnOccluder) {
    Scene scene;
    scene.lights.push_back(directional_light({1, -2, 0.5F}, 1000));
    scene.lights[0].intensity = {1000, 500, 0};
    add_quad(scene, add_grey(scene, 0), {-1, 3, -1}, {0, 0, 2}, {2, 0, 0});
    const TracedLevel level(std::move(scene));
    const glm::vec3 towards = -level.scene.lights[0].direction;
    const glm::vec3 below_occluder = glm::vec3(0.1F, 3, 0.2F) - 3.0F * towards;
    const glm::vec3 beside = below_occluder + glm::vec3(2, 0, 0);
    const Gather light = gather(level.paths, {beside, below_occluder}, options_for(some_normals));
    for (std::size_t i = 0; i < some_normals.size(); ++i) {
        const double cosine = std::max(0.0, glm::dot(glm::dvec3(some_normals[i]), glm::dvec3(towards)));
        expect_exact(light.irradiance[i], cosine * glm::dvec3(1000, 500, 0), "in the light");
        EXPECT_EQ(light.irradiance[some_normals.size() + i].mean, glm::dvec3(0)) << "behind the occluder";
    }
    for (const Estimate& coefficient : light.sh(1)) EXPECT_EQ(coefficient.mean, glm::dvec3(0));
}

TEST(ClosedForms, PointLightFallsWithTheSquareOfTheDistanceUpToItsRange) {
    Scene scene;
    scene.lights.push_back(point_light({1, 2, 3}, 100));
    scene.lights.push_back(point_light({1, 2, 3}, 50));
    scene.lights[1].range = 8;
    const TracedLevel level(std::move(scene));
    for (const double distance : {1e-3, 1.0, 5.0, 7.9, 8.0, 100.0}) {
        const glm::dvec3 towards = glm::normalize(glm::dvec3(1, -2, 2));
        const glm::dvec3 point = glm::dvec3(1, 2, 3) - distance * towards;
        const double window = std::max(0.0, 1 - std::pow(distance / 8, 4));
        // The point itself is rounded to float: half a unit in the last place of 3 is 1e-7 m.
        const double rounding = distance < 0.1 ? 1e-3 : 1e-5;
        const Gather light = gather(level.paths, {glm::vec3(point)}, options_for({glm::vec3(towards)}, 64));
        const double exact = (100 + 50 * window) / (distance * distance);
        EXPECT_NEAR(light.irradiance[0].mean.x, exact, rounding * exact) << distance;
        EXPECT_EQ(light.irradiance[0].error.x, 0) << "exact: no noise";
    }
}

TEST(ClosedForms, SpotLightFadesBetweenItsCones) {
    Scene scene;
    Light spot = point_light({0, 4, 0}, 300);
    spot.kind = LightKind::spot;
    spot.direction = {0, -1, 0};
    spot.cos_inner = std::cos(0.3F);
    spot.cos_outer = std::cos(0.6F);
    spot.range = 20;
    scene.lights.push_back(spot);
    spot.position = {100, 4, 0};  // a cone without a soft rim
    spot.cos_inner = spot.cos_outer;
    scene.lights.push_back(spot);
    const TracedLevel level(std::move(scene));
    for (const double angle : {0.0, 0.2, 0.35, 0.5, 0.59, 0.61, 1.0, 3.0}) {
        const double distance = 4;
        const glm::dvec3 away(std::sin(angle), -std::cos(angle), 0);
        const double t = std::clamp((std::cos(angle) - std::cos(0.6)) / (std::cos(0.3) - std::cos(0.6)), 0.0, 1.0);
        const double full = 300 / (distance * distance) * (1 - std::pow(distance / 20, 4));
        const std::vector<glm::vec3> points = {glm::vec3(glm::dvec3(0, 4, 0) + distance * away)};
        const Gather light = gather(level.paths, points, options_for({glm::vec3(-away)}, 64));
        EXPECT_NEAR(light.irradiance[0].mean.x, full * t * t, 1e-5 * full) << angle;
        const Gather hard =
            gather(level.paths, {points[0] + glm::vec3(100, 0, 0)}, options_for({glm::vec3(-away)}, 64));
        EXPECT_NEAR(hard.irradiance[0].mean.x, angle < 0.6 ? full : 0, 1e-4 * full) << angle;
    }
}

TEST(ClosedForms, ALightInASurfaceLightsBothSidesOfIt) {
    // Where a fixture is exactly on the ceiling, rounding must not decide whether the ceiling is in the way.
    Scene scene;
    const glm::mat3 turned = random_rotation(3);
    add_quad(scene, add_grey(scene, 0), turned * glm::vec3(-1, 0.1F, -1), turned * glm::vec3(0, 0, 2),
             turned * glm::vec3(2, 0, 0));
    scene.lights.push_back(point_light(turned * glm::vec3(0.3F, 0.1F, -0.2F), 1));
    const TracedLevel level(std::move(scene));
    RandomStream random(1);
    for (int i = 0; i < 1000; ++i) {
        const glm::vec3 point = 3.0F * sphere_direction(random.next2());
        if (std::abs(glm::dot(point, turned[1])) < 0.3F) continue;  // along the ceiling it may be in the way
        std::vector<LightSample> light;
        PathCounts counts;
        level.paths.gather_punctual(point, light, counts);
        ASSERT_EQ(light.size(), 1U) << i;
    }
}

TEST(ClosedForms, RectangularLampGivesLambertsFormula) {
    Scene scene;
    Material lamp;
    lamp.base_color = glm::vec3(0);
    lamp.emission = {10, 5, 1};
    add_quad(scene, add_material(scene, lamp), {-0.5F, 2, -1}, {1.5F, 0, 0}, {0, 0, 1});  // faces down
    const TracedLevel level(std::move(scene));
    const std::vector<glm::dvec3> corners = {{-0.5, 2, -1}, {1, 2, -1}, {1, 2, 0}, {-0.5, 2, 0}};
    for (const glm::dvec3 point : {glm::dvec3(0), glm::dvec3(0.2, 1.9, -0.4), glm::dvec3(4, -6, 3)}) {
        for (const glm::dvec3 normal : {glm::dvec3(0, 1, 0), glm::normalize(glm::dvec3(-0.2, 1, -0.1))}) {
            const double form = polygon_irradiance(corners, point, normal);
            expect_irradiance(level, point, normal, form * glm::dvec3(10, 5, 1),
                              fmt::format("{} {} {}", point.x, point.y, point.z));
        }
        const Gather light = gather(level.paths, {glm::vec3(point)}, options_for({}));
        expect_exact(light.sh(0)[0], polygon_solid_angle(corners, point) / (2 * std::sqrt(pi)) * glm::dvec3(10, 5, 1),
                     "L_0");
    }
}

TEST(ClosedForms, EmissionLeavesTheFrontSideOnlyUnlessDoubleSided) {
    const std::vector<glm::dvec3> corners = {{-1, 2, -1}, {1, 2, -1}, {1, 2, 1}, {-1, 2, 1}};
    for (const bool double_sided : {false, true}) {
        Scene scene;
        Material lamp;
        lamp.base_color = glm::vec3(0);
        lamp.emission = glm::vec3(1);
        lamp.double_sided = double_sided;
        add_quad(scene, add_material(scene, lamp), {-1, 2, -1}, {2, 0, 0}, {0, 0, 2});
        const TracedLevel level(std::move(scene));
        const double form = polygon_irradiance(corners, {0, 0, 0}, {0, 1, 0});
        expect_irradiance(level, {0, 0, 0}, {0, 1, 0}, form, "below");
        expect_irradiance(level, {0, 4, 0}, {0, -1, 0}, double_sided ? form : 0, "above");
    }
}

TEST(ClosedForms, MirroredInstanceOfALampShinesTheOtherWay) {
    Scene scene;
    const int lamp = add_grey(scene, 0, 1);
    const int mesh = store_mesh(scene, lamp, {{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}}, {{0, 1, 2}, {0, 2, 3}});
    add_instance(scene, mesh, {{1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {0, 2, 0}});  // faces down but for the mirroring
    const TracedLevel level(std::move(scene));
    const std::vector<glm::dvec3> corners = {{-1, 2, -1}, {1, 2, -1}, {1, 2, 1}, {-1, 2, 1}};
    expect_irradiance(level, {0, 0, 0}, {0, 1, 0}, 0, "below");
    expect_irradiance(level, {0, 4, 0}, {0, -1, 0}, polygon_irradiance(corners, {0, 0, 0}, {0, 1, 0}), "above");
}

TEST(ClosedForms, CoincidentLampsShineOnce) {
    // Exported twice; and a panel that was made two-sided by a second face that is turned over.
    const std::vector<glm::dvec3> corners = {{-1, 1, -1}, {1, 1, -1}, {1, 1, 1}, {-1, 1, 1}};
    const double form = polygon_irradiance(corners, {0, 0, 0}, {0, 1, 0});
    for (const bool turned_over : {false, true}) {
        Scene scene;
        const int lamp = add_grey(scene, 0, 1);
        add_quad(scene, lamp, {-1, 1, -1}, {2, 0, 0}, {0, 0, 2});
        add_quad(scene, lamp, {-1, 1, -1}, {2, 0, 0}, {0, 0, 2});
        if (turned_over) add_mesh(scene, lamp, scene.meshes[0].positions, {{2, 1, 0}, {3, 2, 0}});
        const TracedLevel level(std::move(scene));
        expect_irradiance(level, {0, 0, 0}, {0, 1, 0}, form, "below");
        expect_irradiance(level, {0, 2, 0}, {0, -1, 0}, turned_over ? form : 0, "above");
    }
}

TEST(ClosedForms, EmitterSamplesAndGatherRaysAloneAgree) {
    // The two estimators that the gather combines, each for itself, and their densities at the same points.
    Scene scene;
    const int lamp = add_grey(scene, 0, 3);
    add_quad(scene, lamp, {-0.5F, 2, -1}, {1.5F, 0, 0}, {0, 0, 1});
    add_quad(scene, lamp, {1, 1, 1}, {0, 0, 1}, {0, 1, 0});
    const TracedLevel level(std::move(scene));
    const std::vector<std::vector<glm::dvec3>> lamps = {{{-0.5, 2, -1}, {1, 2, -1}, {1, 2, 0}, {-0.5, 2, 0}},
                                                        {{1, 1, 1}, {1, 1, 2}, {1, 2, 2}, {1, 2, 1}}};
    const glm::vec3 normal = glm::normalize(glm::vec3(0.3F, 1, 0.3F));
    double exact = 0;
    for (const auto& corners : lamps) exact += 3 * polygon_irradiance(corners, {0, 0, 0}, normal);

    constexpr int count = 1 << 18;
    double by_emitters = 0;
    double by_rays = 0;
    int beside = 0;
    RandomStream random(17);
    const Emitters& emitters = level.paths.emitters();
    for (int i = 0; i < count; ++i) {
        const Emitters::Sample sample = emitters.sample({glm::vec3(0), {}}, random.next_double(), random.next2());
        const glm::vec3 to_lamp = glm::normalize(sample.position);
        by_emitters += sample.radiance.x * std::max(0.0F, glm::dot(normal, to_lamp)) / sample.pdf / count;
        const Hit there = level.tracer.closest_hit({0, 0, 0}, to_lamp);
        if (there.found()) {
            ASSERT_NEAR(emitters.pdf({glm::vec3(0), {}}, there, level.tracer.surface(there, to_lamp)), sample.pdf,
                        1e-3 * sample.pdf);
        } else {
            ++beside;  // rounded over the rim
        }

        const glm::vec3 direction = cosine_direction(normal, random.next2());
        const Hit hit = level.tracer.closest_hit({0, 0, 0}, direction);
        by_rays += hit.found() ? 3 * pi / count : 0;
    }
    EXPECT_LT(beside, 1e-4 * count);
    const double share = exact / (3 * pi);
    EXPECT_NEAR(by_rays, exact, 4 * 3 * pi * std::sqrt(share * (1 - share) / count));
    EXPECT_NEAR(by_emitters, exact, 0.01 * exact);
    expect_irradiance(level, {0, 0, 0}, normal, exact, "combined");
}

TEST(ClosedForms, WhiteFurnaceIsAsBrightAsItsSeries) {
    for (const float albedo : {0.0F, 0.3F, 0.5F, 0.8F}) {
        Scene scene;
        add_box(scene, add_grey(scene, albedo, 2), {-1, -2, -3}, {1, 1, 2}, Facing::inward);
        const TracedLevel level(std::move(scene));
        const double radiance = 2 / (1 - static_cast<double>(albedo));
        const Gather light = gather(level.paths, {{0.3F, 0.5F, -1}}, options_for(some_normals));
        for (const Estimate& irradiance : light.irradiance) {
            expect_exact(irradiance, glm::dvec3(pi * radiance), fmt::format("albedo {}", albedo));
        }
        expect_exact(light.sh(0)[0], glm::dvec3(2 * std::sqrt(pi) * radiance), "L_0");
    }
}

TEST(ClosedForms, ColoursDoNotMix) {
    Scene scene;
    Material wall;
    wall.base_color = {0.8F, 0.2F, 0};
    wall.emission = {1, 0, 5};
    add_box(scene, add_material(scene, wall), glm::vec3(-1), glm::vec3(1), Facing::inward);
    const TracedLevel level(std::move(scene));
    const Gather light = gather(level.paths, {{0, 0, 0}}, options_for({{0, 1, 0}}));
    expect_exact(light.irradiance[0], pi * glm::dvec3(5, 0, 5), "coloured furnace");
}

Material pane(float albedo, float alpha) {
    Material material;
    material.base_color = glm::vec3(albedo);
    material.alpha_mode = AlphaMode::blend;
    material.alpha = alpha;
    return material;
}

TEST(ClosedForms, BlendCoverPassesOneMinusAlphaOfTheSky) {
    // The pane closes a black tray, so that it reflects nothing back: what is above the point is dimmed, what is below
    // is black.
    Scene scene;
    const int black = add_grey(scene, 0);
    const int cover = add_material(scene, pane(0.7F, 0.35F));
    const int tray = add_box(scene, black, glm::vec3(-1), glm::vec3(1), Facing::inward);
    std::vector<glm::uvec3>& sides = scene.meshes[tray].triangles;
    sides.erase(sides.begin() + 6, sides.begin() + 8);  // +y
    add_quad(scene, cover, {-1, 1, -1}, {0, 0, 2}, {2, 0, 0});
    scene.lights.push_back(directional_light({0, -1, 0}, 10));
    const TracedLevel level(std::move(scene), white_sky);
    const std::vector<glm::dvec3> corners = {{-1, 1, -1}, {1, 1, -1}, {1, 1, 1}, {-1, 1, 1}};
    const double sky = polygon_irradiance(corners, {0, 0, 0}, {0, 1, 0});
    // Straight down through the middle of the pane, where its two triangles meet.
    expect_irradiance(level, {0, 0, 0}, {0, 1, 0}, 0.65 * (sky + 10), "below the middle");
    expect_irradiance(level, {0.25F, 0, 0.25F}, {0, 1, 0},
                      0.65 * (polygon_irradiance(corners, {0.25, 0, 0.25}, {0, 1, 0}) + 10), "below the diagonal");
}

TEST(ClosedForms, BlendShellReflectsInsideWhatItDoesNotPass) {
    // Inside a closed shell everything has the same radiance L = (1 - alpha) 1 + alpha albedo L.
    for (const float alpha : {0.25F, 0.9F}) {
        Scene scene;
        add_box(scene, add_material(scene, pane(0.8F, alpha)), {-1, -1, -2}, {1, 2, 1}, Facing::outward);
        const TracedLevel level(std::move(scene), white_sky);
        const double radiance = (1 - double(alpha)) / (1 - double(alpha) * double(0.8F));
        expect_irradiance(level, {0, 0.5F, -0.3F}, some_normals[3], pi * radiance, fmt::format("alpha {}", alpha));
    }
}

TEST(ClosedForms, EmittingBlendSurfacesEmitTimesAlpha) {
    Scene scene;
    Material material = pane(0.5F, 0.4F);
    material.emission = glm::vec3(3);
    add_box(scene, add_material(scene, material), {-1, -1, -2}, {1, 2, 1}, Facing::inward);
    const TracedLevel level(std::move(scene), white_sky);
    const double radiance = (0.6 + 0.4 * 3) / (1 - 0.4 * 0.5);
    expect_irradiance(level, {0, 0.5F, -0.3F}, some_normals[3], pi * radiance, "glowing shell");
}

TEST(ClosedForms, TransmissionPassesTintedLightAndReflectsTheRest) {
    // L = t c + (1 - t) c L, colour by colour.
    Scene scene;
    Material glass;
    glass.base_color = {0.9F, 0.5F, 0.1F};
    glass.transmission = 0.6F;
    add_box(scene, add_material(scene, glass), {-1, -1, -2}, {1, 2, 1}, Facing::outward);
    const TracedLevel level(std::move(scene), white_sky);
    const glm::dvec3 color(glass.base_color);
    const double t = glass.transmission;
    expect_irradiance(level, {0, 0.5F, -0.3F}, some_normals[3], pi * t * color / (1.0 - (1 - t) * color), "glass");
}

TEST(ClosedForms, MaskedHolesPassAllLight) {
    Scene scene;
    Texture texture;
    texture.image = {2, 1, {{255, 255, 255, 255}, {255, 255, 255, 0}}};
    texture.nearest = true;
    scene.textures.push_back(texture);
    Material leaf;
    leaf.base_color = glm::vec3(0);
    leaf.alpha_mode = AlphaMode::mask;
    leaf.base_color_texture.texture = 0;
    const int mesh = add_quad(scene, add_material(scene, leaf), {-1, 1, -1}, {0, 0, 2}, {2, 0, 0});
    scene.meshes[mesh].uv_sets = {{{0, 0}, {0, 1}, {1, 1}, {1, 0}}};  // transparent where x > 0
    const TracedLevel level(std::move(scene), white_sky);
    const std::vector<glm::dvec3> solid_half = {{-1, 1, -1}, {0, 1, -1}, {0, 1, 1}, {-1, 1, 1}};
    expect_irradiance(level, {0.2F, 0, 0}, {0, 1, 0},
                      pi - polygon_irradiance(solid_half, {double(0.2F), 0, 0}, {0, 1, 0}), "half a cover");
}

TEST(ClosedForms, BothSidesOfASurfaceReflect) {
    // Lit from its back side, seen from its back side.
    Scene scene;
    add_quad(scene, add_grey(scene, 0.5F), {-1, 2, -1}, {0, 0, 2}, {2, 0, 0});  // faces up
    scene.lights.push_back(directional_light({1, 1, 0}, 100));
    const TracedLevel level(std::move(scene));
    const std::vector<glm::dvec3> corners = {{-1, 2, -1}, {1, 2, -1}, {1, 2, 1}, {-1, 2, 1}};
    const double radiance = 0.5 * 100 * std::sqrt(0.5) / pi;
    expect_irradiance(level, {0.5F, 0, 0}, {0, 1, 0}, radiance * polygon_irradiance(corners, {0.5, 0, 0}, {0, 1, 0}),
                      "lit from below");
    expect_irradiance(level, {1.5F, 4, 0}, {0, -1, 0}, 0, "in its shadow the other side is dark");
}

TEST(ClosedForms, AFloorUnderThreeKindsOfLightsReflectsTheirSum) {
    // Lights are chosen by chance at the floor; the exact value is quadrature over it.
    Scene scene;
    add_quad(scene, add_grey(scene, 0.6F), {-2, 0, -2}, {0, 0, 4}, {4, 0, 0});
    scene.lights.push_back(directional_light({0.3F, -1, 0}, 5));
    scene.lights.push_back(point_light({1, 2, 1}, 40));
    scene.lights.back().range = 4;
    Light spot = point_light({-1, 3, 0}, 100);
    spot.kind = LightKind::spot;
    spot.direction = glm::normalize(glm::vec3(0.2F, -1, 0));
    spot.cos_inner = std::cos(0.2F);
    spot.cos_outer = std::cos(0.5F);
    scene.lights.push_back(spot);
    scene.lights.push_back(point_light({0, -1, 0}, 1e6F));  // below: must not be seen through it
    const TracedLevel level(std::move(scene));
    const glm::dvec3 point(0.3, 1, -0.2);
    constexpr int cells = 400;
    double exact = 0;
    for (int i = 0; i < cells; ++i) {
        for (int k = 0; k < cells; ++k) {
            const glm::dvec3 floor(-2 + 4 * (i + 0.5) / cells, 0, -2 + 4 * (k + 0.5) / cells);
            double irradiance = 0;
            for (std::size_t l = 0; l < 3; ++l) {
                const PunctualLight light = punctual_light_at(level.scene.lights[l], glm::vec3(floor));
                irradiance += light.irradiance.x * light.direction.y;
            }
            const glm::dvec3 to_floor = floor - point;
            const double squared = glm::dot(to_floor, to_floor);
            const double cosine = -to_floor.y / std::sqrt(squared);
            exact += 0.6 * irradiance / pi * cosine * cosine / squared * (4.0 / cells) * (4.0 / cells);
        }
    }
    const Gather light = gather(level.paths, {glm::vec3(point)}, options_for({{0, -1, 0}}));
    EXPECT_NEAR(light.irradiance[0].mean.x, exact, 3 * light.irradiance[0].error.x + 1e-4 * exact);
    EXPECT_LT(light.irradiance[0].error.x, 0.005 * exact);
}

TEST(ClosedForms, ADistantLightInThreeBandsPeaksAndRingsAsKnown) {
    // E(n) of one delta light of 1 lx, truncated at l = 2: 1/4 + c/2 + 5/16 (3 c^2 - 1) / 2 with c the cosine between n
    // and the light; 1.0625 at c = 1, -0.0396 at c = -8/15 (122.2 degrees).
    Scene scene;
    scene.lights.push_back(directional_light(glm::vec3(0, -1, 0), 20));
    const TracedLevel level(std::move(scene));
    const Gather light = gather(level.paths, {{0, 0, 0}}, options_for({}, 64));
    std::vector<glm::vec3> sh;
    for (const Estimate& coefficient : light.sh(0)) sh.emplace_back(coefficient.mean);
    const auto at = [&](double angle) {
        return irradiance_from_sh(sh, glm::vec3(std::sin(angle), std::cos(angle), 0)).x / 20;
    };
    EXPECT_NEAR(at(0), 1.0625, 1e-5);
    EXPECT_NEAR(light.axis_irradiance[2].mean.x, 20 * 1.0625, 1e-5 * 20);
    EXPECT_NEAR(at(glm::radians(122.2)), -0.0396, 5e-5);
    double least = 1;
    double where = 0;
    for (double angle = 0; angle < pi; angle += 1e-3) {
        const double c = std::cos(angle);
        EXPECT_NEAR(at(angle), 0.25 + 0.5 * c + 5.0 / 32 * (3 * c * c - 1), 1e-5);
        if (at(angle) < least) {
            least = at(angle);
            where = glm::degrees(angle);
        }
    }
    EXPECT_NEAR(least, 0.25 - 5.0 / 32 - 2.0 / 15, 1e-5);
    EXPECT_NEAR(where, 122.23, 0.1);
}

/// Lamp, sky and a pane in one, with a known irradiance.
TracedLevel mixed_level() {
    Scene scene;
    Material lamp = pane(0, 0.5F);
    lamp.emission = glm::vec3(40);
    add_quad(scene, add_material(scene, lamp), {-0.2F, 2, -0.3F}, {0.5F, 0, 0}, {0, 0, 0.4F});
    return TracedLevel(std::move(scene), white_sky);
}
double mixed_irradiance() {
    // The pane hides half of the sky behind it and adds half of its emission.
    return pi + (0.5 * 40 - 0.5) * polygon_irradiance({{-0.2, 2, -0.3}, {0.3, 2, -0.3}, {0.3, 2, 0.1}, {-0.2, 2, 0.1}},
                                                      {0, 0, 0}, {0, 1, 0});
}

TEST(ClosedForms, StandardErrorsAreTheSpreadOfResultsOverSeeds) {
    const TracedLevel level = mixed_level();
    const double exact = mixed_irradiance();
    constexpr int seeds = 400;
    double sum = 0;
    double squares = 0;
    double reported = 0;
    int beyond = 0;
    for (int seed = 0; seed < seeds; ++seed) {
        GatherOptions options;
        options.samples = 256;
        options.replicates = 16;
        options.seed = static_cast<std::uint64_t>(seed);
        options.normals = {{0, 1, 0}};
        const Estimate estimate = gather(level.paths, {{0, 0, 0}}, options).irradiance[0];
        const double error = estimate.mean.x - exact;
        sum += error;
        squares += error * error;
        reported += estimate.error.x * estimate.error.x;
        beyond += std::abs(error) > 3 * estimate.error.x ? 1 : 0;
    }
    // The ratio of the two variances has a standard deviation of about sqrt(2 / seeds); Student's t with 15 degrees of
    // freedom is beyond 3 in 0.9 % of all cases.
    EXPECT_NEAR(squares / reported, 1, 4 * std::sqrt(2.0 / seeds));
    EXPECT_NEAR(sum / seeds, 0, 4 * std::sqrt(squares) / seeds);
    EXPECT_LE(beyond, 0.009 * seeds + 4 * std::sqrt(0.009 * seeds));
}

TEST(ClosedForms, SeedsGiveDifferentResultsAndTheSameSeedTheSame) {
    const TracedLevel level = mixed_level();
    GatherOptions options = options_for({{0, 1, 0}}, 256);
    const glm::dvec3 first = gather(level.paths, {{0, 0, 0}}, options).irradiance[0].mean;
    EXPECT_EQ(gather(level.paths, {{0, 0, 0}}, options).irradiance[0].mean, first);
    options.seed = 1;
    EXPECT_NE(gather(level.paths, {{0, 0, 0}}, options).irradiance[0].mean, first);
}

void expect_same_bits(const Gather& a, const Gather& b, const std::string& what) {
    const auto compare = [&](const std::vector<Estimate>& x, const std::vector<Estimate>& y) {
        ASSERT_EQ(x.size(), y.size());
        for (std::size_t i = 0; i < x.size(); ++i) {
            ASSERT_EQ(x[i].mean, y[i].mean) << what << ", value " << i;
            ASSERT_EQ(x[i].error, y[i].error) << what << ", value " << i;
        }
    };
    compare(a.coefficients, b.coefficients);
    compare(a.irradiance, b.irradiance);
    compare(a.axis_irradiance, b.axis_irradiance);
}

/// A level with everything that chance decides in it, and coincident surfaces.
Scene busy_scene() {
    Scene scene;
    add_box(scene, add_grey(scene, 0.8F), {-4, 0, -4}, {4, 3, 4}, Facing::inward);
    add_box(scene, add_grey(scene, 0.2F), {-4, 0, -4}, {4, 3, 4}, Facing::inward);
    add_quad(scene, add_grey(scene, 0.5F, 20), {0, 2.9F, 0}, {1, 0, 0}, {0, 0, 1});
    add_quad(scene, add_material(scene, pane(0.5F, 0.5F)), {-2, 1, -2}, {0, 0, 3}, {3, 0, 0});
    add_quad(scene, add_material(scene, pane(0.9F, 0.3F)), {-2, 1, -2}, {0, 0, 3}, {3, 0, 0});
    add_sphere(scene, add_grey(scene, 0.6F), {1, 1, -1}, 0.5F, Facing::outward);
    scene.lights.push_back(point_light({-1, 2, 1}, 10));
    return scene;
}

TEST(ClosedForms, ResultsDoNotDependOnHowReplicatesAreDividedOrOnThreads) {
    std::vector<glm::vec3> points;
    for (int i = 0; i < 40; ++i) points.emplace_back(-3.5F + 0.17F * i, 0.3F + 0.06F * i, 2.5F - 0.13F * i);
    GatherOptions options = options_for({{0, 1, 0}, {1, 0, 0}}, 16 * 64);
    options.replicates = 16;
    const auto run = [&](int threads, const std::vector<std::uint32_t>& parts) {
        const ThreadLimit limit(threads);
        const TracedLevel level(busy_scene());
        GatherSums sums(level.paths, points, options);
        std::size_t last = 0;
        for (const std::uint32_t part : parts) {
            last = 0;
            sums.add_replicates(part, [&](std::size_t done) { last = std::max(last, done); });
            EXPECT_EQ(last, part * points.size());
        }
        EXPECT_EQ(sums.replicates(), 16U);
        EXPECT_EQ(sums.counts().dropped, 0U);
        return sums.result();
    };
    const Gather all = run(1, {16});
    expect_same_bits(all, run(2, {16}), "two threads");
    expect_same_bits(all, run(2, {1, 10, 5}), "in three parts");
    expect_same_bits(all, run(1, std::vector<std::uint32_t>(16, 1)), "one by one");
}

TEST(ClosedForms, ManyPointsGiveWhatFewGive) {
    // More points than are spread over replicates: another way through the loop, the same numbers.
    const TracedLevel level = mixed_level();
    GatherOptions options = options_for({}, 32);
    options.replicates = 4;
    std::vector<glm::vec3> points;
    for (int i = 0; i < 1500; ++i) points.emplace_back(0.001F * i, 0, 0);
    const Gather many = gather(level.paths, points, options);
    points.resize(7);
    const Gather few = gather(level.paths, points, options);
    for (std::size_t i = 0; i < few.coefficients.size(); ++i) {
        ASSERT_EQ(many.coefficients[i].mean, few.coefficients[i].mean);
        ASSERT_EQ(many.coefficients[i].error, few.coefficients[i].error);
    }
}

TEST(ClosedForms, OneNormalEachGivesEveryPointItsOwn) {
    const TracedLevel level = mixed_level();
    GatherOptions options = options_for({{0, 1, 0}, {0, 0, 1}}, 1024);
    const std::vector<glm::vec3> points = {{0, 0, 0}, {1, 0, 1}};
    const Gather all = gather(level.paths, points, options);
    options.one_normal_each = true;
    const Gather each = gather(level.paths, points, options);
    ASSERT_EQ(each.irradiance.size(), 2U);
    EXPECT_EQ(each.irradiance[0].mean, all.irradiance[0].mean);
    EXPECT_EQ(each.irradiance[1].mean, all.irradiance[3].mean);
}

TEST(ClosedForms, ALimitOnBouncesCutsTheSeries) {
    Scene scene;
    add_box(scene, add_grey(scene, 0.5F, 1), glm::vec3(-1), glm::vec3(1), Facing::inward);
    const TracedLevel level(std::move(scene));
    const std::vector<glm::vec3> even = even_directions(4096);
    for (const std::uint32_t bounces : {0U, 1U, 2U}) {
        std::vector<LightSample> light;
        PathCounts counts;
        level.paths.gather({{0, 0, 0}}, 1, even, light, counts, {.most_bounces = bounces});
        double mean = 0;
        for (const LightSample& sample : light) mean += sample.radiance.x / (4 * pi);
        EXPECT_NEAR(mean, 2 - std::pow(0.5, bounces), 0.03) << bounces;
    }
}

/// A closed room with a sign on its back wall: in the wall's texture, of 2 by 1 texels, or as a quad of its own.
Scene room_with_sign(bool in_texture) {
    constexpr int texels = 2048;
    constexpr float texel = 4.0F / texels;
    Scene scene;
    const int grey = add_grey(scene, 0.5F);
    add_box(scene, grey, {0, 0, -0.1F}, {4, 4, 4}, Facing::inward);
    Material sign;
    sign.base_color = glm::vec3(0.5F);
    sign.emission = glm::vec3(1e6F);
    const int wall = add_quad(scene, grey, {0, 0, 0}, {4, 0, 0}, {0, 4, 0});
    if (in_texture) {
        Texture texture;
        texture.image = {texels, texels,
                         std::vector<glm::u8vec4>(std::size_t{texels} * texels, glm::u8vec4(0, 0, 0, 255))};
        texture.nearest = true;
        texture.image.at(1301, 703) = texture.image.at(1302, 703) = glm::u8vec4(255);
        scene.textures.push_back(std::move(texture));
        sign.emission_texture.texture = 0;
        scene.meshes[wall].material = add_material(scene, sign);
        scene.meshes[wall].uv_sets = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
    } else {
        add_quad(scene, add_material(scene, sign), {1301 * texel, 703 * texel, 1e-4F}, {2 * texel, 0, 0},
                 {0, texel, 0});
    }
    return scene;
}

TEST(ClosedForms, ALitPatchInATextureLightsLikeAQuadOfItsOwn) {
    const TracedLevel textured(room_with_sign(true));
    const TracedLevel quad(room_with_sign(false));
    const std::vector<glm::vec3> points = {{1, 1, 2}, {3, 3.5F, 1}, {2.6F, 1.4F, 0.5F}};
    const GatherOptions options = options_for(some_normals, 16384);
    const Gather of_texture = gather(textured.paths, points, options);
    const Gather of_quad = gather(quad.paths, points, options);
    double texture_noise = 0;
    double quad_noise = 0;
    for (std::size_t i = 0; i < of_quad.irradiance.size(); ++i) {
        const Estimate& ours = of_texture.irradiance[i];
        const Estimate& exact = of_quad.irradiance[i];
        EXPECT_NEAR(ours.mean.x, exact.mean.x, 4 * std::hypot(ours.error.x, exact.error.x)) << i;
        EXPECT_LT(ours.error.x, 0.05 * ours.mean.x) << i;
        texture_noise += ours.error.x * ours.error.x;
        quad_noise += exact.error.x * exact.error.x;
    }
    EXPECT_LT(texture_noise, 2 * quad_noise) << "twice the rays at most";

    // What lit a bare floor straight ahead, in closed form: the same by samples and by the cache.
    Scene alone = room_with_sign(true);
    for (Material& material : alone.materials) material.base_color = glm::vec3(0);
    const double size = 4.0 / 2048;
    const std::vector<glm::dvec3> sign = {{1301 * size, 703 * size, 0},
                                          {1303 * size, 703 * size, 0},
                                          {1303 * size, 704 * size, 0},
                                          {1301 * size, 704 * size, 0}};
    expect_irradiance(TracedLevel(std::move(alone)), {1, 1, 2}, {0, 0, -1},
                      1e6 * polygon_irradiance(sign, {1, 1, 2}, {0, 0, -1}), "a sign alone");
}

TEST(ClosedForms, RaysTellWhichLightsTheyAskedFor) {
    const auto tested = [](const TracedLevel& level) {
        PathCounts counts;
        (void)gather(level.paths, {{0, 0, 0}}, options_for({}, 256), &counts);
        return counts.tested;
    };
    const auto box = [] {
        Scene scene;
        add_box(scene, add_grey(scene, 0.5F), glm::vec3(-1), glm::vec3(1), Facing::inward);
        return scene;
    };
    const auto with_lamp = [&](float candela, float range) {
        Scene scene = box();
        scene.lights.push_back(point_light({5, 0, 0}, candela));
        scene.lights.back().range = range;
        return scene;
    };
    EXPECT_EQ(TracedLevel(with_lamp(0, 10)).paths.lights(), 0U) << "a lamp that is off is no light";
    EXPECT_EQ(TracedLevel(with_lamp(1, 1)).paths.lights(), punctual_light(0));
    EXPECT_EQ(tested(TracedLevel(with_lamp(1, 10))), punctual_light(0)) << "behind a wall: found dark";
    EXPECT_EQ(tested(TracedLevel(with_lamp(1, 1))), 0U) << "out of range of all that is met";
    EXPECT_EQ(tested(TracedLevel(box(), white_sky)), sky_light);
    EXPECT_EQ(tested(TracedLevel(room_with_sign(true))), emissive_light);
}

TEST(ClosedForms, EstimatorsWithoutUseAreLeftOut) {
    EXPECT_FALSE(TracedLevel({}).paths.estimators().sky);
    const TracedLevel sky({}, white_sky);
    EXPECT_TRUE(sky.paths.estimators().sky);
    EXPECT_FALSE(sky.paths.estimators().environment) << "nothing to gain from sampling a uniform sky";
    EXPECT_FALSE(sky.paths.estimators().reflection);
    EXPECT_FALSE(sky.paths.estimators().emitters);
    EXPECT_FALSE(sky.paths.estimators().lights);
    PathCounts counts;
    GatherOptions options = options_for({}, 64);
    (void)gather(sky.paths, {{0, 0, 0}}, options, &counts);
    EXPECT_EQ(counts.rays, 64U);
    EXPECT_EQ(counts.shadow_rays, 0U);
    const TracedLevel busy(busy_scene());
    EXPECT_TRUE(busy.paths.estimators().reflection);
    EXPECT_TRUE(busy.paths.estimators().emitters);
    EXPECT_TRUE(busy.paths.estimators().lights);
    EXPECT_FALSE(busy.paths.estimators().sky);
}

}  // namespace
}  // namespace lightgrid
