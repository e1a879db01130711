// The path tracer's light all over a level, and by how much a volume differs from it.

#include "viewer/reference_map.h"

#include "core/error.h"
#include "core/sampling.h"
#include "core/sh.h"
#include "tests/scene_builder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

namespace lightgrid {
namespace {

constexpr float sky = 2;  // cd/m^2, from everywhere
constexpr float irradiance = sky * std::numbers::pi_v<float>;

/// A black plate under an even sky: its light is the same all over, on both sides.
class Plate : public testing::Test {
  protected:
    Plate() {
        add_quad(scene_, add_grey(scene_, 0), {-4, 0, -4}, {8, 0, 0}, {0, 0, 8});
        tracer_.emplace(scene_);
        paths_.emplace(*tracer_, environment_);
    }
    /// Probes a metre apart that know that light; those at x >= 3, z >= 3 tell of twice as much.
    [[nodiscard]] static Volume wrong_in_a_corner() {
        Volume volume = make_volume({{{-4, -2, -4}, {1, 1, 1}, {9, 5, 9}}}, 1);
        for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
            if (volume.states[slot] == ProbeState::absent) continue;
            const glm::dvec3 at = lattice_position(volume, slot);
            const bool wrong = at.x > 2.5 && at.z > 2.5;
            volume.coefficients[slot] = glm::vec3((wrong ? 2 : 1) * sky * 2 * std::sqrt(std::numbers::pi_v<float>));
        }
        return volume;
    }

    Scene scene_;
    Environment environment_ = Environment::uniform(glm::vec3(sky));
    std::optional<Tracer> tracer_;
    std::optional<PathTracer> paths_;
};

TEST_F(Plate, ItsPlacesAreSpreadOverTheSideThatPeopleSee) {
    const Volume volume = wrong_in_a_corner();
    const std::vector<MapPlace> places = choose_map_places(*tracer_, volume, 200);
    ASSERT_EQ(places.size(), 200U);
    // The first few are as far from each other as the plate allows, and so are all of them.
    for (const std::size_t first : {std::size_t{20}, places.size()}) {
        std::set<std::pair<bool, bool>> quarters;
        double nearest = 1e9;
        for (std::size_t i = 0; i < first; ++i) {
            const MapPlace& place = places[i];
            EXPECT_NEAR(place.normal.y, 1, 1e-6F);
            EXPECT_GT(place.position.y, 0) << "off the surface";
            quarters.emplace(place.position.x > 0, place.position.z > 0);
            for (std::size_t k = 0; k < i; ++k) {
                nearest = std::min<double>(nearest, glm::distance(place.position, places[k].position));
            }
        }
        EXPECT_EQ(quarters.size(), 4U);
        EXPECT_GT(nearest, 0.5 * std::sqrt(64.0 / static_cast<double>(first))) << first;
    }
    const std::vector<MapPlace> again = choose_map_places(*tracer_, volume, 200);
    EXPECT_TRUE(std::equal(places.begin(), places.end(), again.begin(), again.end(),
                           [](const MapPlace& a, const MapPlace& b) { return a.position == b.position; }));
    Volume below = volume;
    for (std::size_t slot = 0; slot < below.slots(); ++slot) {
        if (is_valid(below.states[slot]) && lattice_position(below, slot).y > -0.5) below.states[slot] = ProbeState::missing;
    }
    const std::vector<MapPlace> underside = choose_map_places(*tracer_, below, 10);
    ASSERT_EQ(underside.size(), 10U) << "nobody is anywhere, so that any probe will do";
    for (const MapPlace& place : underside) EXPECT_NEAR(place.normal.y, -1, 1e-6F);
    for (ProbeState& state : below.states) {
        if (is_valid(state)) state = ProbeState::missing;
    }
    EXPECT_TRUE(choose_map_places(*tracer_, below, 200).empty());
}

TEST_F(Plate, OnlyTheCornerThatIsWrongDiffers) {
    ReferenceMap map;
    map.places = choose_map_places(*tracer_, wrong_in_a_corner(), 200);
    std::vector<std::size_t> told;
    trace_map(*paths_, map, [&](const ReferenceMap& known) {
        told.push_back(known.traced);
        map = known;
    });
    EXPECT_EQ(told, (std::vector<std::size_t>{64, 128, 200}));
    EXPECT_TRUE(map.last);
    const LitVolume lit(wrong_in_a_corner());
    const LookUp look_up{.volume = &lit};
    const std::vector<float> differences = differences_of(map, {}, look_up);
    int wrong = 0;
    for (std::size_t i = 0; i < map.places.size(); ++i) {
        const MapPlace& place = map.places[i];
        EXPECT_NEAR(place.irradiance.mean.y, irradiance, 5e-3F * irradiance);
        const auto share = [](float x) { return std::clamp(x - 2, 0.0F, 1.0F); };  // of the trilinear weights
        const float want = share(place.position.x) * share(place.position.z);
        EXPECT_NEAR(differences[i], want, 1e-2F);
        wrong += want > 0.5F ? 1 : 0;
    }
    EXPECT_GT(wrong, 0);

    const std::vector<std::size_t> worst = worst_places(map, differences, 0.7, 4);
    ASSERT_EQ(worst.size(), 4U);
    EXPECT_EQ(differences[worst[0]], *std::max_element(differences.begin(), differences.end()));
    for (std::size_t i = 0; i < worst.size(); ++i) {
        for (std::size_t k = 0; k < i; ++k) {
            EXPECT_LE(differences[worst[i]], differences[worst[k]]);
            EXPECT_GE(glm::distance(map.places[worst[i]].position, map.places[worst[k]].position), 0.7F);
        }
    }
    EXPECT_EQ(worst_places(map, differences, 100, 4).size(), 1U);
}

TEST_F(Plate, WhatIsNotKnownIsNotSaidToBeRight) {
    const LitVolume lit(wrong_in_a_corner());
    const LookUp look_up{.volume = &lit};
    MapPlace place{{0, 0.001F, 0}, {0, 1, 0}};
    EXPECT_LT(difference_at(place, {}, look_up), 0) << "not traced";
    place.samples = 16;
    place.irradiance = {glm::dvec3(irradiance), glm::dvec3(0.05 * irradiance)};
    EXPECT_LT(difference_at(place, {}, look_up), 0) << "no difference, within 5 %";
    place.irradiance.mean = glm::dvec3(2 * irradiance);
    EXPECT_NEAR(difference_at(place, {}, look_up), 0.5F, 1e-4F) << "5 % are good enough to tell of 50 %";
    // In the dark a twentieth of the usual light is what counts.
    place.irradiance = {};
    EXPECT_NEAR(difference_at(place, {}, look_up), irradiance / (0.05F * luminance(lit.usual_light)), 0.01F);
}

TEST_F(Plate, TracingEndsWhenItIsAsked) {
    ReferenceMap map;
    map.places = choose_map_places(*tracer_, wrong_in_a_corner(), 200);
    int asked = 0;
    EXPECT_THROW(trace_map(
                     *paths_, map, [](const ReferenceMap&) { FAIL() << "it should have ended"; },
                     [&] {
                         ++asked;
                         throw Error("ended", "the test", "");
                     }),
                 Error);
    EXPECT_GE(asked, 1);
    EXPECT_LE(asked, 16) << "replicates that are traced together";
}

TEST(NearestPlace, FacesTheSameWayAndIsNear) {
    const std::vector<MapPlace> places{{.position = {0, 0, 0.01F}, .normal = {0, 0, 1}},
                                       {.position = {2, 0, -0.01F}, .normal = {0, 0, -1}, .apart = 2}};
    EXPECT_EQ(nearest_place(places, {2, 0, 0.01F}, {0, 0, 1}, 100), 0U) << "the other is on the back of the wall";
    EXPECT_EQ(nearest_place(places, {2, 0, -0.01F}, {0, 0, -1}, 100), 1U);
    EXPECT_EQ(nearest_place(places, {1, 0, 0}, {1, 0, 0}, 1), std::nullopt) << "faces another way";
    EXPECT_EQ(nearest_place(places, {0, 9, 0}, {0, 0, 1}, 1), std::nullopt) << "is far from all";
    EXPECT_EQ(nearest_place({}, {0, 0, 0}, {0, 0, 1}, 1), std::nullopt);
}

}  // namespace
}  // namespace lightgrid
