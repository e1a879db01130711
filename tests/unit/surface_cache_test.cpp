// The surface cache against light that is known exactly, and against paths.

#include "probes/surface_cache.h"

#include "core/parallel.h"
#include "probes/cache_bias.h"
#include "probes/gather.h"
#include "tests/polygon_light.h"
#include "tests/scene_builder.h"
#include "tests/traced_level.h"

#include <fmt/format.h>
#include <glm/gtc/constants.hpp>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>

namespace lightgrid {
namespace {

constexpr double pi = glm::pi<double>();

const Environment white_sky = Environment::uniform(glm::vec3(1));

const std::vector<glm::vec3> some_normals = {{0, 1, 0}, {0, -1, 0}, glm::normalize(glm::vec3(1, 2, -2))};

std::vector<glm::vec3> lattice(glm::vec3 min, glm::vec3 max, glm::ivec3 counts) {
    std::vector<glm::vec3> points;
    for (int z = 0; z < counts.z; ++z) {
        for (int y = 0; y < counts.y; ++y) {
            for (int x = 0; x < counts.x; ++x) {
                points.push_back(min + (glm::vec3(x, y, z) + 0.5F) / glm::vec3(counts) * (max - min));
            }
        }
    }
    return points;
}

GatherOptions options_for(const SurfaceCache& cache, std::uint32_t samples) {
    GatherOptions options;
    options.samples = samples;
    options.normals = some_normals;
    options.rays.cache = &cache;
    return options;
}

/// A box with a block in it, of this albedo and emission 1: radiance 1 / (1 - albedo) everywhere.
Scene furnace(float albedo) {
    Scene scene;
    const int wall = add_grey(scene, albedo, 1);
    add_box(scene, wall, {-1, -2, -3}, {1, 1, 2}, Facing::inward);
    add_box(scene, wall, {-0.5F, -1.5F, -0.5F}, {0.25F, -0.5F, 0.5F}, Facing::outward);
    return scene;
}

TEST(SurfaceCache, WhiteFurnaceUpToTheHighestAlbedo) {
    int sweeps_at_99 = 0;
    for (const float albedo : {0.5F, 0.99F, 0.999F, 0.9999F}) {
        const TracedLevel level(furnace(albedo));
        CacheOptions options;
        options.width = 0.25F;
        const auto points = lattice({-0.9F, -0.4F, -2.9F}, {0.9F, 0.9F, 1.9F}, {4, 4, 8});
        const SurfaceCache cache = build_surface_cache(level.paths, points, options);
        const double exact = pi / (1 - static_cast<double>(albedo));
        const Gather light = gather(level.paths, {{0.3F, 0.5F, -1}, {-0.7F, -1, 0}}, options_for(cache, 16384));
        for (const Estimate& irradiance : light.irradiance) {
            EXPECT_NEAR(irradiance.mean.x, exact, 0.005 * exact) << "albedo " << albedo;
        }
        fmt::print("albedo {}: {} patches, {} sweeps, residual {:.1e}\n", albedo, cache.made().patches,
                   cache.made().sweeps, cache.made().residual);
        if (albedo == 0.99F) sweeps_at_99 = cache.made().sweeps;
        if (albedo > 0.99F) {
            EXPECT_LE(cache.made().sweeps, sweeps_at_99 * std::sqrt(0.01 / (1 - albedo))) << "albedo " << albedo;
        }
    }
}

TEST(SurfaceCache, GroundUnderASunInClosedForm) {
    Scene scene;
    const int mesh = add_quad(scene, add_grey(scene, 0), {-4, 0, -4}, {0, 0, 8}, {8, 0, 0});
    scene.materials[scene.meshes[mesh].material].base_color = {0.5F, 0.4F, 0};
    scene.lights.push_back(directional_light({1, -1, 0}, 3));
    const TracedLevel level(std::move(scene));
    const SurfaceCache cache =
        build_surface_cache(level.paths, lattice({-3, 0.2F, -3}, {3, 3, 3}, {6, 3, 6}), CacheOptions());
    GatherOptions options = options_for(cache, 16384);
    options.normals = {{0, -1, 0}};
    const Gather light = gather(level.paths, {{0.5F, 1, 0.25F}}, options);
    const double solid =
        polygon_irradiance({{-4, 0, -4}, {4, 0, -4}, {4, 0, 4}, {-4, 0, 4}}, {0.5, 1, 0.25}, {0, -1, 0});
    const glm::dvec3 exact = glm::dvec3(0.5F, 0.4F, 0) * (3 * std::sqrt(0.5) / pi * solid);
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(light.irradiance[0].mean[c], exact[c], 3 * light.irradiance[0].error[c] + 1e-5) << c;
        EXPECT_LE(light.irradiance[0].error[c], 0.005 * exact[c]) << c;
    }
}

TEST(SurfaceCache, PanesReflectAndPassOnlyTheirShare) {
    // Inside a closed shell everything has the same radiance L = (1 - alpha) 1 + alpha albedo L.
    for (const float alpha : {0.25F, 0.9F}) {
        Scene scene;
        Material pane;
        pane.base_color = glm::vec3(0.8F);
        pane.alpha_mode = AlphaMode::blend;
        pane.alpha = alpha;
        add_box(scene, add_material(scene, pane), {-1, -1, -2}, {1, 2, 1}, Facing::outward);
        const TracedLevel level(std::move(scene), white_sky);
        const SurfaceCache cache = build_surface_cache(
            level.paths, lattice({-0.9F, -0.9F, -1.9F}, {0.9F, 1.9F, 0.9F}, {4, 5, 5}), CacheOptions());
        const double exact = pi * (1 - double(alpha)) / (1 - double(alpha) * double(0.8F));
        const Gather light = gather(level.paths, {{0, 0.5F, -0.3F}}, options_for(cache, 16384));
        for (const Estimate& irradiance : light.irradiance) {
            EXPECT_NEAR(irradiance.mean.x, exact, 0.002 * exact + 3 * irradiance.error.x) << alpha;
        }
    }
}

TEST(SurfaceCache, TintedGlassPassesItsColour) {
    Scene scene;
    Material glass;
    glass.base_color = {0.9F, 0.5F, 0.1F};
    glass.transmission = 0.6F;
    add_box(scene, add_material(scene, glass), {-1, -1, -2}, {1, 2, 1}, Facing::outward);
    const TracedLevel level(std::move(scene), white_sky);
    const SurfaceCache cache =
        build_surface_cache(level.paths, lattice({-0.9F, -0.9F, -1.9F}, {0.9F, 1.9F, 0.9F}, {4, 5, 5}), CacheOptions());
    const glm::dvec3 color(glm::vec3(0.9F, 0.5F, 0.1F));
    const double t = 0.6F;
    const glm::dvec3 exact = pi * t * color / (1.0 - (1 - t) * color);
    const Gather light = gather(level.paths, {{0, 0.5F, -0.3F}}, options_for(cache, 16384));
    for (int c = 0; c < 3; ++c) {
        const Estimate& irradiance = light.irradiance[2];
        EXPECT_NEAR(irradiance.mean[c], exact[c], 0.002 * exact[c] + 3 * irradiance.error[c]) << c;
    }
}

/// A room with a lamp, a box, glass, a ball, under a sky that comes in through a hole.
Scene furnished_room() {
    Scene scene;
    const int wall = add_grey(scene, 0.7F);
    const int room = add_box(scene, wall, {-3, 0, -2}, {3, 3, 2}, Facing::inward);
    std::vector<glm::uvec3>& sides = scene.meshes[room].triangles;
    sides.pop_back();  // half of +z
    Material red;
    red.base_color = {0.8F, 0.2F, 0.1F};
    add_box(scene, add_material(scene, red), {-2, 0, -1}, {-1, 1.2F, 0.5F}, Facing::outward);
    add_sphere(scene, add_grey(scene, 0.5F), {1.5F, 0.8F, -0.5F}, 0.6F, Facing::outward);
    add_quad(scene, add_grey(scene, 0, 20), {-0.5F, 2.9F, -0.5F}, {1, 0, 0}, {0, 0, 1});  // faces down
    Material glass;
    glass.base_color = {0.6F, 0.9F, 0.9F};
    glass.transmission = 0.8F;
    add_quad(scene, add_material(scene, glass), {0.3F, 0, -1.5F}, {0, 0, 2}, {0, 2, 0});
    const int ball = store_mesh(scene, wall, {{0, 0, 0}, {0.3F, 0, 0}, {0, 0.3F, 0}, {0, 0, 0.3F}},
                                {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}});
    add_instance(scene, ball, glm::mat4x3(-2, 0, 0, 0, 1, 0.5F, 0, 0, 1, 2.2F, 0.2F, 1));
    return scene;
}

RadianceImage sunny_image() {
    RadianceImage image{64, 32, std::vector<glm::vec3>(64 * 32, glm::vec3(0.5F, 0.7F, 1))};
    image.at(40, 10) = glm::vec3(2000, 1800, 1500);  // +x and +z, 33 degrees up
    return image;
}

TEST(SurfaceCache, AgreesWithPathsInAFurnishedRoom) {
    const TracedLevel level(furnished_room(), Environment::from_image(sunny_image()));
    const auto points = lattice({-2.9F, 0.1F, -1.9F}, {2.9F, 2.8F, 1.9F}, {8, 4, 6});
    CacheOptions options;
    options.rays_per_probe = 256;  // few probes
    const SurfaceCache cache = build_surface_cache(level.paths, points, options);
    const std::vector<glm::vec3> some = {{-2.5F, 0.3F, 1.5F}, {0, 1.5F, 0}, {2.2F, 2.5F, -1}, {0.8F, 0.4F, 0.8F}};
    GatherOptions gather_options = options_for(cache, 16384);
    const Gather cached = gather(level.paths, some, gather_options);
    gather_options.rays = {};
    gather_options.seed = 1;
    const Gather exact = gather(level.paths, some, gather_options);
    for (std::size_t i = 0; i < exact.irradiance.size(); ++i) {
        for (int c = 0; c < 3; ++c) {
            const Estimate& a = exact.irradiance[i];
            const Estimate& b = cached.irradiance[i];
            // What patches average away, and the noise of one cache: a percent or so.
            EXPECT_NEAR(a.mean[c], b.mean[c], 0.015 * a.mean[c] + 3 * std::hypot(a.error[c], b.error[c]))
                << "point " << i / 3 << ", normal " << i % 3 << ", colour " << c;
        }
    }
    EXPECT_GT(cache.made().generations, 1);
    EXPECT_EQ(cache.made().counts.dropped, 0U);
}

TEST(SurfaceCache, BiasIsMeasuredAsItIs) {
    // A cache of too few rays on patches as large as walls, against the difference of two long gathers.
    const TracedLevel level(furnished_room(), Environment::from_image(sunny_image()));
    const auto points = lattice({-2.9F, 0.1F, -1.9F}, {2.9F, 2.8F, 1.9F}, {5, 3, 4});
    CacheOptions options;
    options.width = 2;
    options.light_samples = 1;
    const SurfaceCache cache = build_surface_cache(level.paths, points, options);
    GatherOptions gather_options = options_for(cache, 16384);
    gather_options.normals = some_normals;
    const Gather cached = gather(level.paths, points, gather_options);
    gather_options.rays = {};
    gather_options.seed = 1;
    const Gather exact = gather(level.paths, points, gather_options);
    double actual = 0;
    double noise = 0;
    double power = 0;
    for (std::size_t i = 0; i < exact.irradiance.size(); ++i) {
        const glm::dvec3 difference = cached.irradiance[i].mean - exact.irradiance[i].mean;
        actual += glm::dot(difference, difference);
        for (const Estimate& e : {cached.irradiance[i], exact.irradiance[i]}) noise += glm::dot(e.error, e.error);
        power += glm::dot(exact.irradiance[i].mean, exact.irradiance[i].mean);
    }
    actual -= noise;
    const CacheBias bias = measure_bias(level.paths, cache, points, some_normals, {2048, 5});
    double measured = 0;
    double apart = 0;
    for (std::size_t i = 0; i < bias.a.size(); ++i) {
        measured += glm::dot(bias.a[i], bias.b[i]);
        apart += glm::dot(bias.a[i] - bias.b[i], bias.a[i] - bias.b[i]);
    }
    fmt::print("bias {:.3f} %, measured {:.3f} %, halves apart {:.3f} %\n", 100 * std::sqrt(actual / power),
               100 * std::sqrt(measured / power), 100 * std::sqrt(apart / power));
    EXPECT_GT(actual, 0.02 * 0.02 * power) << "a cache this coarse is off by percents";
    EXPECT_NEAR(std::sqrt(measured), std::sqrt(actual), 0.1 * std::sqrt(actual));
    EXPECT_EQ(bias.counts.dropped, 0U);
}

TEST(SurfaceCache, BiasOfAFurnaceIsItsNoise) {
    // With emission and reflection the same everywhere, patches average nothing away.
    const TracedLevel level(furnace(0.5F));
    const auto points = lattice({-0.9F, -0.4F, -2.9F}, {0.9F, 0.9F, 1.9F}, {4, 4, 8});
    const SurfaceCache cache = build_surface_cache(level.paths, points, CacheOptions());
    const CacheBias bias = measure_bias(level.paths, cache, points, some_normals, {256, 5});
    double measured = 0;
    for (std::size_t i = 0; i < bias.a.size(); ++i) measured += glm::dot(bias.a[i], bias.b[i]);
    const double power = 3 * static_cast<double>(bias.a.size()) * 4 * pi * pi;
    EXPECT_LT(std::sqrt(std::abs(measured) / power), 0.01) << "2,048 samples, shared by all";
}

TEST(SurfaceCache, AWallOnAFloorKeepsLightOnItsSide) {
    // One floor, one ceiling and one pair of side walls for both rooms; the wall between them stands amid patches.
    Scene scene;
    const int white = add_grey(scene, 0.8F);
    add_box(scene, white, {-3, 0, -2}, {3, 2.5F, 2}, Facing::inward);
    add_box(scene, white, {0.1F, -0.1F, -2.1F}, {0.11F, 2.6F, 2.1F}, Facing::outward);
    scene.lights.push_back(point_light({-1.5F, 1.2F, 0.3F}, 100));
    const TracedLevel level(std::move(scene));
    auto points = lattice({-2.9F, 0.1F, -1.9F}, {0.05F, 2.4F, 1.9F}, {6, 5, 8});
    const std::size_t lit = points.size();
    for (const glm::vec3& p : lattice({0.15F, 0.1F, -1.9F}, {2.9F, 2.4F, 1.9F}, {6, 5, 8})) points.push_back(p);
    CacheOptions options;
    options.width = 0.25F;
    const SurfaceCache cache = build_surface_cache(level.paths, points, options);
    EXPECT_GT(cache.made().cut_cubes, 10U);
    const Gather light = gather(level.paths, points, options_for(cache, 1024));
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double l0 = light.sh(i)[0].mean.x;
        if (i < lit) {
            EXPECT_GT(l0, 0) << i;
        } else {
            EXPECT_EQ(l0, 0) << points[i].x << ", " << points[i].y << ", " << points[i].z;
        }
    }
}

TEST(SurfaceCache, AnyNumberOfThreadsGivesTheSameBits) {
    const auto points = lattice({-2.9F, 0.1F, -1.9F}, {2.9F, 2.8F, 1.9F}, {6, 4, 5});
    const auto run = [&](int threads) {
        const ThreadLimit limit(threads);
        const TracedLevel level(furnished_room(), Environment::from_image(sunny_image()));
        const SurfaceCache cache = build_surface_cache(level.paths, points, CacheOptions());
        std::vector<double> values;
        for (const Estimate& e : gather(level.paths, points, options_for(cache, 256)).coefficients) {
            for (int c = 0; c < 3; ++c) values.push_back(e.mean[c]);
        }
        return values;
    };
    const std::vector<double> one = run(1);
    EXPECT_EQ(one, run(2));
    EXPECT_EQ(one, run(4));
}

TEST(SurfaceCache, NoPointsNoSurfacesNoLight) {
    const TracedLevel empty({}, white_sky);
    const SurfaceCache nothing = build_surface_cache(empty.paths, std::vector<glm::vec3>{{0, 0, 0}}, CacheOptions());
    EXPECT_EQ(nothing.made().patches, 0U);
    EXPECT_NEAR(gather(empty.paths, {{0, 0, 0}}, options_for(nothing, 256)).irradiance[0].mean.x, pi, 0.02 * pi);

    const TracedLevel dark(furnished_room());
    const SurfaceCache unasked = build_surface_cache(dark.paths, {}, CacheOptions());
    EXPECT_EQ(unasked.made().patches, 0U);
    // Paths then answer for it.
    EXPECT_GT(gather(dark.paths, {{0, 1, 0}}, options_for(unasked, 1024)).irradiance[0].mean.x, 0);
}

}  // namespace
}  // namespace lightgrid
