// Parts of the light that are stored apart: they add up to the light they are parts of, and weights change it as a bake
// in the changed light would.

#include "probes/layers.h"

#include "core/environment_sh.h"
#include "core/error.h"
#include "core/parallel.h"
#include "probes/bake.h"
#include "tests/unit/lit_room.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace lightgrid {
namespace {

/// The room with a lamp and a point light in groups; a tube and the sky are in none.
Room grouped_room() {
    Room level = room();
    level.scene.groups = {"lamps", "spots"};
    level.scene.materials[lamp].group = 0;
    level.scene.lights[0].group = 1;
    level.scene.materials[neon].emission = {2, 8, 8};
    return level;
}

BakeOptions options() {
    BakeOptions options;
    options.placement.spacing = 0.6;
    options.target.samples = 512;
    options.measure_error = false;
    return options;
}

/// planned_sky  that probes are placed under
BakeResult bake(const Room& room, const std::string& layers, BakeOptions options, const Environment& planned_sky) {
    const LayersPlan plan = plan_layers(parse_layers(layers), room.scene, room.sky);
    options.layers = plan.layers;
    const Tracer tracer(room.scene);
    const PathTracer paths(tracer, room.sky, plan.sources);
    const PathTracer planned(tracer, planned_sky);
    return run_bake(paths, plan_bake(planned, options), options);
}
BakeResult bake(const Room& room, const std::string& layers, const BakeOptions& more = options()) {
    return bake(room, layers, more, room.sky);
}

/// The volume with its layers mixed.
Volume mixed(const Volume& volume, std::span<const glm::vec3> weights) {
    Volume result = volume;
    result.coefficients = mix_layers(volume, weights);
    return result;
}

std::vector<std::string> names_of(const Volume& volume) {
    std::vector<std::string> names;
    for (const Layer& layer : volume.layers) names.push_back(layer.name);
    return names;
}

/// What is solved for, before anything is filled or rounded.
Volume solved(const Room& room, const std::string& layers) {
    const LayersPlan plan = plan_layers(parse_layers(layers), room.scene, room.sky);
    const Tracer tracer(room.scene);
    const PathTracer paths(tracer, room.sky, plan.sources);
    const BakePlan bake = plan_bake(paths, options());
    PathCounts counts;
    const KeptTransport kept =
        trace_transport(paths, bake, find_surfaces(paths, bake.points, bake.cache), bake.cache, 0, counts);
    Volume volume = bake.volume;
    light_layers(kept, tracer, room.sky, plan.layers, volume);
    return volume;
}

/// All layers add up to the combined light: to some roundings of a probe's largest coefficient, to float or to half.
void expect_sum(const Volume& volume) {
    const float tolerance = volume.half ? 4 * 0x1p-11F : 1e-6F;
    const std::vector<glm::vec3> ones(volume.layers.size(), glm::vec3(1));
    const std::vector<glm::vec3> sum = mix_layers(volume, ones);
    const std::size_t n = volume.sh_size();
    std::size_t lit = 0;
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        float largest = 0;
        for (const glm::vec3& c : volume.sh(slot)) {
            largest = std::max({largest, std::abs(c.r), std::abs(c.g), std::abs(c.b)});
        }
        for (std::size_t i = slot * n; i < (slot + 1) * n; ++i) {
            const glm::vec3 d = glm::abs(sum[i] - volume.coefficients[i]);
            EXPECT_LE(std::max({d.r, d.g, d.b}), tolerance * largest) << "slot " << slot << " coefficient " << i % n;
        }
        if (largest > 0) ++lit;
    }
    EXPECT_GT(lit, 30U);
}

TEST(Layers, GroupsAndWhatIsInNoneAddUpToAllLight) {
    const Volume volume = bake(grouped_room(), "groups").volume;
    EXPECT_EQ(names_of(volume), (std::vector<std::string>{"lamps", "spots", "other"}));
    expect_sum(volume);
    expect_sum(solved(grouped_room(), "groups"));
    EXPECT_GT(std::count(volume.states.begin(), volume.states.end(), ProbeState::filled), 0) << "none was filled";
    check_volume(volume);
}

TEST(Layers, ALampTwiceAsBrightIsItsLayerTwice) {
    const Volume volume = bake(grouped_room(), "lamps").volume;
    EXPECT_EQ(names_of(volume), (std::vector<std::string>{"lamps", "other"}));
    for (const glm::vec3 factor : {glm::vec3(2), glm::vec3(0.5F, 1, 4), glm::vec3(0)}) {
        Room changed = grouped_room();
        changed.scene.materials[lamp].emission *= factor;
        BakeOptions other_noise = options();
        other_noise.seed = 1;
        const BakeResult fresh = bake(changed, "lamps", other_noise);
        other_noise.seed = 2;
        const double usual = difference(bake(changed, "lamps", other_noise).volume, fresh.volume);
        const std::array<glm::vec3, 2> weights{factor, glm::vec3(1)};
        EXPECT_LT(difference(mixed(volume, weights), fresh.volume), 1.5 * usual);
        // It matters.
        EXPECT_GT(difference(volume, fresh.volume), 3 * usual);
    }
}

TEST(Layers, DirectAndIndirectAddUpToAllLight) {
    const Volume volume = bake(grouped_room(), "direct,indirect").volume;
    EXPECT_EQ(names_of(volume), (std::vector<std::string>{"direct", "indirect"}));
    expect_sum(volume);
    expect_sum(solved(grouped_room(), "direct,indirect"));
}

TEST(Layers, DirectIsAllThatThereIsAmongBlackSurfaces) {
    const Volume volume = bake(grouped_room(), "direct,indirect").volume;
    Room black = grouped_room();
    for (Material& material : black.scene.materials) material.base_color = glm::vec3(0);
    const Volume direct = bake(black, "direct,indirect").volume;
    const std::array<glm::vec3, 2> direct_alone{glm::vec3(1), glm::vec3(0)};
    // The same rays and samples.
    EXPECT_LT(difference(mixed(volume, direct_alone), direct), 1e-5);
    EXPECT_EQ(std::count(direct.layers[1].coefficients.begin(), direct.layers[1].coefficients.end(), glm::vec3(0)),
              static_cast<std::ptrdiff_t>(direct.coefficients.size()));
    EXPECT_GT(difference(volume, direct), 0.1);
}

TEST(Layers, TellTheirNoise) {
    BakeOptions few = options();
    few.target.samples = 128;
    const Volume a = bake(grouped_room(), "groups", few).volume;
    few.seed = 1;
    const Volume b = bake(grouped_room(), "groups", few).volume;
    for (std::size_t i = 0; i < a.layers.size(); ++i) {
        std::vector<glm::vec3> alone(a.layers.size(), glm::vec3(0));
        alone[i] = glm::vec3(1);
        // Two bakes differ by sqrt(2) standard errors, and by the noise of their caches.
        const double found = difference(mixed(a, alone), mixed(b, alone)) / std::sqrt(2.0);
        EXPECT_GT(found, 0.7 * a.layers[i].noise) << a.layers[i].name;
        EXPECT_LT(found, 2.5 * a.layers[i].noise) << a.layers[i].name;
        EXPECT_GT(a.layers[i].noise, 0) << a.layers[i].name;
    }
}

// ---- A sky that can be changed

/// Brighter above and towards +X, all of it in the first three bands.
Environment smooth_sky() {
    constexpr int width = 256;
    constexpr int height = 128;
    RadianceImage image{width, height, {}};
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const double polar = glm::pi<double>() * (y + 0.5) / height;
            const double azimuth = glm::two_pi<double>() * ((x + 0.5) / width - 0.5);
            const glm::dvec3 d(std::sin(polar) * std::cos(azimuth), std::cos(polar),
                               std::sin(polar) * std::sin(azimuth));
            image.pixels.emplace_back(1 + 0.5 * d.y, 1 + 0.8 * d.x * d.y, 2 + d.x + 0.5 * d.z * d.z);
        }
    }
    return Environment::from_image(std::move(image));
}

/// The room with a pane that lets tinted light through where it is open.
Room glazed_room() {
    Room level = grouped_room();
    Material pane;
    pane.base_color = {0.9F, 0.5F, 0.3F};
    pane.transmission = 0.6F;
    add_quad(level.scene, add_material(level.scene, pane), {-2, 2, -2}, {0, 0, 4}, {1.5F, 0, 0});
    return level;
}

TEST(Layers, ASkyPutInLaterIsThatOfABakeUnderIt) {
    Room level = glazed_room();
    level.sky = Environment();
    const Environment sky = smooth_sky();
    const Volume volume = bake(level, "sky,spots", options(), sky).volume;
    ASSERT_EQ(volume.layers.size(), 11U);  // spots, other, nine of the sky
    EXPECT_TRUE(has_sky_layers(volume));
    std::vector<glm::vec3> weights(volume.layers.size(), glm::vec3(1));
    set_sky(volume, project_environment(sky, sky_layer_bands), weights);
    level.sky = sky;
    BakeOptions other_noise = options();
    other_noise.seed = 1;
    const BakeResult fresh = bake(level, "combined", other_noise);
    other_noise.seed = 2;
    const double usual = difference(bake(level, "combined", other_noise).volume, fresh.volume);
    EXPECT_LT(difference(mixed(volume, weights), fresh.volume), 1.5 * usual);
    EXPECT_GT(difference(volume, fresh.volume), 0.1) << "its combined light has no sky";
}

TEST(Layers, ASkyThatWasThereIsOneOfTheSkiesToPutIn) {
    Room level = glazed_room();
    level.sky = smooth_sky();
    const Volume volume = bake(level, "sky").volume;
    EXPECT_EQ(names_of(volume).front(), "other");
    std::vector<glm::vec3> weights(volume.layers.size(), glm::vec3(1));
    set_sky(volume, project_environment(level.sky, sky_layer_bands), weights);
    const BakeResult plain = bake(level, "combined");
    EXPECT_LT(difference(mixed(volume, weights), volume), 3 * plain.noise.relrmse);
    set_sky(volume, std::vector<glm::vec3>(9, glm::vec3(0)), weights);
    EXPECT_GT(difference(mixed(volume, weights), volume), 0.1);
}

TEST(Layers, WithoutALevelTheSkyComesAsItIs) {
    Room nothing{{}, Environment()};
    nothing.scene.materials.emplace_back();
    const Environment sky = Environment::uniform(glm::vec3(1));
    const BakeResult result = bake(nothing, "sky", options(), sky);
    const Volume& volume = result.volume;
    ASSERT_EQ(volume.layers.size(), 9U);
    ASSERT_EQ(volume.slots(), 1U);
    for (std::size_t i = 0; i < 9; ++i) {
        for (std::size_t k = 0; k < 9; ++k) {
            EXPECT_NEAR(volume.layers[i].coefficients[k].g, i == k ? 1 : 0, 0.01) << i << " " << k;
        }
    }
}

// ---- What is asked for

TEST(Layers, AreTheSameBitsForAnyNumberOfThreads) {
    std::vector<Volume> volumes;
    for (const int threads : {1, 2}) {
        const ThreadLimit limit(threads);
        volumes.push_back(bake(grouped_room(), "sky,groups").volume);
    }
    ASSERT_EQ(volumes[0].layers.size(), 12U);
    EXPECT_EQ(volumes[0].coefficients, volumes[1].coefficients);
    for (std::size_t i = 0; i < 12; ++i) {
        EXPECT_EQ(volumes[0].layers[i].coefficients, volumes[1].layers[i].coefficients) << i;
        EXPECT_EQ(volumes[0].layers[i].noise, volumes[1].layers[i].noise) << i;
    }
}

TEST(Layers, FewProbesHaveThemToo) {
    BakeOptions list = options();
    list.probes = {{0.5, 1, 0.5}, {-1, 1, 1}};
    const BakeResult result = bake(grouped_room(), "groups", list);
    EXPECT_EQ(result.method, Method::cache);
    ASSERT_EQ(result.volume.layers.size(), 3U);
    EXPECT_NE(result.volume.layers[0].coefficients[0], glm::vec3(0));
}

TEST(Layers, GroupsThatNobodyAskedForAreLeftOut) {
    const auto leaves_out_layers = [](const std::string& layers) {
        const BakeResult result = bake(grouped_room(), layers);
        return std::count_if(result.left_out.begin(), result.left_out.end(),
                             [](const LeftOut& item) { return item.what.find("layers of") == 0; });
    };
    EXPECT_EQ(leaves_out_layers("combined"), 1);
    EXPECT_EQ(leaves_out_layers("lamps"), 1);
    EXPECT_EQ(leaves_out_layers("groups"), 0);
}

TEST(Layers, OtherIsNoLayerWhereAllLightIsInGroups) {
    Room level = grouped_room();
    level.sky = Environment();
    level.scene.materials[neon].emission = glm::vec3(0);
    EXPECT_EQ(names_of(bake(level, "groups").volume), (std::vector<std::string>{"lamps", "spots"}));
    EXPECT_EQ(names_of(bake(level, "spots").volume), (std::vector<std::string>{"spots", "other"}));
}

std::string complaint(const std::string& layers, const Scene& scene) {
    try {
        static_cast<void>(plan_layers(parse_layers(layers), scene, Environment()));
    } catch (const Error& error) {
        return error.what();
    }
    return "nothing";
}

TEST(Layers, RefuseWhatIsNoChoice) {
    const Scene scene = grouped_room().scene;
    const auto expect = [](const std::string& found, const char* part) {
        EXPECT_NE(found.find(part), std::string::npos) << found;
    };
    EXPECT_EQ(complaint("combined", scene), "nothing");
    EXPECT_EQ(complaint("spots,lamps,sky", scene), "nothing");
    EXPECT_EQ(complaint("groups,lamps", scene), "nothing");
    expect(complaint("lmaps", scene), "there is no group \"lmaps\" of lights. Choose among: lamps, spots.");
    expect(complaint("direct", scene), "direct,indirect are two halves");
    expect(complaint("direct,indirect,sky", scene), "direct,indirect are two halves");
    expect(complaint("sky,,lamps", scene), "has an empty name");
    expect(complaint("", scene), "has an empty name");
    expect(complaint("combined,sky", scene), "combined is always there");
    expect(complaint("other", scene), "it comes by itself");
    expect(complaint("lamps", Scene()), "extras {\"lightgrid\": {\"group\": \"NAME\"}}");
    expect(complaint("groups", Scene()), "has no groups of lights");
    Scene many;
    for (int i = 0; i < 63; ++i) many.groups.push_back(fmt::format("g{}", i));
    expect(complaint("groups", many), "63 groups of lights, but 62 can be layers");
    many.groups.pop_back();
    EXPECT_EQ(complaint("groups", many), "nothing");
}

}  // namespace
}  // namespace lightgrid
