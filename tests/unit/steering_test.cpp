#include "probes/steering.h"

#include "core/parallel.h"
#include "tests/scene_builder.h"
#include "tests/traced_level.h"

#include <gtest/gtest.h>

#include <limits>

namespace lightgrid {
namespace {

/// A room of 4 m, a lamp below its ceiling.
struct LitRoom : TracedLevel {
    LitRoom() : TracedLevel(made()) {}
    static Scene made() {
        Scene room;
        add_box(room, add_grey(room, 0.5F), {0, 0, 0}, {4, 4, 4}, Facing::inward);
        add_quad(room, add_grey(room, 0, 10), {1.5F, 3.9F, 1.5F}, {1, 0, 0}, {0, 0, 1});
        return room;
    }
};

constexpr std::int64_t most_probes = 2048;

/// Steered towards an error that no grid of so few probes reaches.
struct Steered {
    Volume volume = make_volume({{glm::dvec3(0.25), glm::dvec3(0.7), glm::ivec3(6)}}, 3);
    Steering steering;

    Steered(const LitRoom& room, double rays) {
        static_cast<void>(place_probes(volume, room.tracer, {}));
        SteeringOptions options;
        options.target.error = 0.001;
        options.may_refine = true;
        options.max_probes = most_probes;
        options.rays = rays;
        steering = steer(room.paths, volume, options);
    }
    [[nodiscard]] double traced() const {
        const PathCounts& counts = steering.counts;
        return static_cast<double>(counts.rays + counts.shadow_rays + steering.placed.rays);
    }
};

TEST(Steering, ProbesAreTheLimitWhereRaysAreNot) {
    const LitRoom room;
    const Steered steered(room, std::numeric_limits<double>::infinity());
    EXPECT_GT(steered.steering.rounds.back().probes, most_probes / 2);
    EXPECT_LE(steered.steering.rounds.back().probes, most_probes);
}

TEST(Steering, LooksNoFurtherThanItsRaysPayFor) {
    const LitRoom room;
    const double all = Steered(room, std::numeric_limits<double>::infinity()).traced();
    for (const double share : {0.6, 0.8}) {
        const Steered steered(room, share * all);
        // What every bake takes at last, a look at its noise, is not cut short.
        EXPECT_LE(steered.traced(), 1.2 * share * all) << share;
        EXPECT_GT(steered.traced(), 0.5 * share * all) << share;
        EXPECT_NE(steered.steering.why_refined.find("share of the rays"), std::string::npos)
            << steered.steering.why_refined;
    }
}

TEST(Steering, OnlyAnErrorThatIsAskedForAddsBands) {
    const LitRoom room;
    const auto bands_for = [&](const Target& target) {
        Volume volume = make_volume({{glm::dvec3(0.25), glm::dvec3(0.7), glm::ivec3(6)}}, 3);
        static_cast<void>(place_probes(volume, room.tracer, {}));
        SteeringOptions options;
        options.target = target;
        options.max_probes = most_probes;
        options.rays = 1e7;
        const Steering steering = steer(room.paths, volume, options);
        EXPECT_FALSE(steering.bands_error.empty()) << "what bands leave decides where refinement ends";
        return steering.bands;
    };
    Target target;
    target.error = 0.001;
    EXPECT_EQ(bands_for(target), 5) << "3 cannot meet it here, or this test says nothing";
    target = {};
    target.seconds = 10;
    EXPECT_EQ(bands_for(target), 3);
}

TEST(Steering, DoesNotDependOnHowManyThreadsThereAre) {
    const LitRoom room;
    const auto with_threads = [&](int threads) {
        const ThreadLimit limit(threads);
        return Steered(room, 1e7);
    };
    const Steered one = with_threads(1);
    const Steered two = with_threads(2);
    EXPECT_EQ(one.volume.bricks.size(), two.volume.bricks.size());
    EXPECT_EQ(one.volume.coefficients, two.volume.coefficients);
    EXPECT_EQ(one.steering.samples, two.steering.samples);
    EXPECT_EQ(one.traced(), two.traced());
    EXPECT_GT(one.steering.rounds.size(), 1U);
}

}  // namespace
}  // namespace lightgrid
