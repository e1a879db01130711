#include "probes/bake.h"

#include "probes/sampler.h"
#include "tests/scene_builder.h"
#include "tests/traced_level.h"

#include <fmt/format.h>
#include <glm/gtc/constants.hpp>
#include <gtest/gtest.h>

#include <algorithm>

namespace lightgrid {
namespace {

/// A room of 4 m, a lamp in a corner.
struct Room : TracedLevel {
    Room() : TracedLevel(made()) {}
    static Scene made() {
        Scene room;
        const int wall = add_grey(room, 0.7F);
        const int lamp = add_grey(room, 0, 10);
        add_box(room, wall, {0, 0, 0}, {4, 4, 4}, Facing::inward);
        add_quad(room, lamp, {0.1F, 3.9F, 0.1F}, {1, 0, 0}, {0, 0, 1});
        return room;
    }
};

/// With the patches of its cache as wide as this, whatever the plan says.
BakeResult bake_with_patches(const Room& room, float width, const Target& target) {
    BakeOptions options;
    options.placement.spacing = 1;
    options.target = target;
    BakePlan plan = plan_bake(room.paths, options);
    plan.cache.width = width;
    return run_bake(room.paths, plan, options);
}

bool leaves_out_cache(const BakeResult& result) {
    return std::any_of(result.left_out.begin(), result.left_out.end(),
                       [](const LeftOut& item) { return item.what == "the surface cache"; });
}

TEST(Bake, GridsDoNotGoBehindOuterWallsUnlessABoxIsAskedFor) {
    Scene scene = Room::made();
    add_box(scene, 0, {1, 1, 3.9F}, {3, 1.1F, 4.3F}, Facing::outward);  // a sill that stands out
    const TracedLevel room(std::move(scene));
    BakeOptions options;
    options.placement.spacing = 1;
    options.target.samples = 64;
    const auto last_probe_z = [&] {
        const Grid grid = plan_bake(room.paths, options).volume.grids.at(0);
        return grid.position(grid.counts - 1).z;
    };
    EXPECT_LT(last_probe_z(), 4);
    EXPECT_GT(last_probe_z(), 3.9);
    options.placement.boxes = {room.scene.bounds};
    EXPECT_NEAR(last_probe_z(), 4.3, 1e-6);
}

TEST(Bake, DoesNotTakeDarknessForEvidenceWhereALightWasNeverTested) {
    BakeOptions options;
    options.placement.spacing = 1;
    const auto verdict = [&](float range) {
        Scene scene;
        add_box(scene, add_grey(scene, 0.7F), {0, 0, 0}, {4, 4, 4}, Facing::inward);
        scene.lights.push_back(point_light({2, 9, 2}, 100));  // behind the roof
        scene.lights.back().range = range;
        const TracedLevel level(std::move(scene));
        return run_bake(level.paths, plan_bake(level.paths, options), options).verdict;
    };
    EXPECT_EQ(verdict(20).sentence.find("no light reached"), std::string::npos) << "dark, as shadow rays found";
    const Verdict unknown = verdict(3);
    EXPECT_EQ(unknown.sentence.rfind("no light reached any of ", 0), 0U) << unknown.sentence;
    EXPECT_EQ(unknown.target_met, false);
}

TEST(Bake, AnOpenFloorLightsWhatStandsOnIt) {
    Scene scene;
    add_quad(scene, add_grey(scene, 0.5F), {-10, 0, 10}, {20, 0, 0}, {0, 0, -20});
    const TracedLevel level(std::move(scene), Environment::uniform(glm::vec3(1)));
    BakeOptions options;
    options.target.samples = 256;
    options.measure_error = false;
    const BakePlan plan = plan_bake(level.paths, options);
    const Grid grid = plan.volume.grids.at(0);
    EXPECT_NEAR(grid.position(grid.counts - 1).y, 2, 1e-4);
    const Volume volume = run_bake(level.paths, plan, options).volume;
    // Below a point at height h over the centre of a square of half-width 10 its form factor is that of four quarters,
    // each a perpendicular rectangle's (Howell, B-3, twice): 4 / pi * s * atan(s), s = a / sqrt(1 + a^2), a = 10 / h.
    const double a = 10 / 1.8;
    const double s = a / std::sqrt(1 + a * a);
    const double floor = 4 / glm::pi<double>() * s * std::atan(s);
    const double exact = glm::pi<double>() * (0.5 * floor + 1 - floor);
    EXPECT_NEAR(exact, 1.611, 5e-4);
    EXPECT_NEAR(Sampler(volume).irradiance({0, 1.8, 0}, {0, -1, 0}).g, exact, 0.03 * exact);
}

TEST(Bake, HeadroomIsInMetresWhateverTheLevelsUnit) {
    const auto top = [](float size, double metres_per_unit) {
        Scene scene;
        scene.metres_per_unit = metres_per_unit;
        add_quad(scene, add_grey(scene, 0.5F), {-size, 0, size}, {2 * size, 0, 0}, {0, 0, -2 * size});
        const TracedLevel level(std::move(scene), Environment::uniform(glm::vec3(1)));
        BakeOptions options;
        options.target.samples = 64;
        const Grid grid = plan_bake(level.paths, options).volume.grids.at(0);
        return grid.position(grid.counts - 1).y;
    };
    EXPECT_NEAR(top(10, 1), 2, 1e-4);
    EXPECT_NEAR(top(1000, 0.01), 200, 1e-2);
    EXPECT_NEAR(top(1000, 1), 2, 1e-2);
    EXPECT_NEAR(top(100, 0.01), 50, 1e-3) << "a quarter of the width";
}

TEST(Bake, AListMeetsItsErrorWhereFewRaysFindWhatDiffers) {
    // A far box under a sky: pilots with few rays hardly meet it.
    Scene scene;
    add_box(scene, add_grey(scene, 0.5F), {50, 50, 50}, {51, 51, 51}, Facing::outward);
    const TracedLevel level(std::move(scene), Environment::uniform({0.2F, 0.5F, 1.7F}));
    for (const double error : {0.05, 0.02, 0.005, 0.001}) {
        for (const std::uint64_t seed : {0, 1, 2, 3}) {
            BakeOptions options;
            options.probes = {{0, 0, 0}, {1, 2, 3}, {-4, 0, 2}};
            options.target.error = error;
            options.seed = seed;
            const BakeResult result = run_bake(level.paths, plan_bake(level.paths, options), options);
            EXPECT_EQ(result.verdict.target_met, true) << error << ", seed " << seed << ": " << result.verdict.sentence;
        }
    }
}

TEST(Bake, SaysWhyItIsSlowAndHowToGetAFirstLook) {
    BakePlan plan;
    plan.seconds_estimate = 599;
    EXPECT_TRUE(why_slow(plan, {}).empty());
    plan.seconds_estimate = 2000;
    plan.reference_estimate = 1900;
    plan.rays_per_path = 4000;
    const auto joined = [&] { return fmt::format("{}", fmt::join(why_slow(plan, {}), "; ")); };
    EXPECT_NE(joined().find("most of it is the reference"), std::string::npos) << joined();
    EXPECT_NE(joined().find("a path takes 4000 rays"), std::string::npos) << joined();
    EXPECT_NE(joined().find("--time-budget 60s"), std::string::npos) << joined();
    plan.reference_estimate = 100;
    plan.rays_per_path = 3;
    plan.points.resize(50000);
    EXPECT_NE(joined().find("most of it is gathering: 50000 probes"), std::string::npos) << joined();
    Target in_time;
    in_time.seconds = 3600;
    EXPECT_TRUE(why_slow(plan, in_time).empty());
}

TEST(Bake, MakesPatchesFinerWhoseBiasIsTooLarge) {
    const Room room;
    const BakeResult result = bake_with_patches(room, 8, {{}, 0.1, {}});
    ASSERT_TRUE(result.cache);
    EXPECT_LT(result.cache->width, 8.0F);
    // Against what the coarse grid leaves, 40 to 60 %: bias below a quarter of that is not what is in the way.
    EXPECT_LT(result.error->bias->interval.low, bias_goal({{}, 0.1, {}}, result.error->interpolation.relrmse));
    EXPECT_FALSE(leaves_out_cache(result));
}

TEST(Bake, FollowsPathsWhereNoPatchesAreFineEnoughForTheErrorThatIsAskedFor) {
    const Room room;
    const BakeResult result = bake_with_patches(room, 32, {{}, 0.1, {}});
    EXPECT_EQ(result.method, Method::path);
    EXPECT_FALSE(result.cache);
    EXPECT_FALSE(result.error->bias);
    EXPECT_TRUE(leaves_out_cache(result));
    EXPECT_TRUE(std::any_of(result.volume.settings.begin(), result.volume.settings.end(),
                            [](const auto& setting) { return setting.second == "path"; }));
}

TEST(Bake, KeepsToTheSamplesThatAreAskedForWhateverTheBias) {
    const Room room;
    const BakeResult result = bake_with_patches(room, 32, {256, {}, {}});
    EXPECT_EQ(result.method, Method::cache);
    EXPECT_EQ(result.cache->width, 32.0F);
    EXPECT_GT(result.error->bias->interval.low, 0.1) << "but it is measured";
}

TEST(Bake, StartsFromFewerProbesWhereTimeIsTooShortToPlaceThem) {
    const Room room;
    BakeOptions options;
    options.placement.max_probes = 512;  // and no finer grids, which ample time would look for
    const auto plan_within = [&](double seconds) {
        options.target.seconds = seconds;
        options.clock = Stopwatch();
        return plan_bake(room.paths, options);
    };
    const auto says_so = [](const BakePlan& plan) { return plan.why_spacing.find("time") != std::string::npos; };
    const auto probes = [](const BakePlan& plan) { return plan.placement.valid + plan.placement.moved; };
    const BakePlan ample = plan_within(600);
    EXPECT_FALSE(says_so(ample)) << ample.why_spacing;
    const BakePlan scarce = plan_within(1e-3);
    EXPECT_TRUE(says_so(scarce)) << scarce.why_spacing;
    EXPECT_LT(2 * probes(scarce), probes(ample));
    options.placement.spacing = 0.6;
    EXPECT_FALSE(says_so(plan_within(1e-3))) << "a spacing that is asked for stays";
}

}  // namespace
}  // namespace lightgrid
