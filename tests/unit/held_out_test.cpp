#include "probes/held_out.h"

#include "core/parallel.h"
#include "tests/scene_builder.h"
#include "tests/traced_level.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lightgrid {
namespace {

/// A closed room of 4 m with a lamp of 20 cm in the middle of its ceiling and a point light above its floor.
struct Room : TracedLevel {
    explicit Room(float radiance = 200, float candela = 3) : TracedLevel(made(radiance, candela)) {}
    static Scene made(float radiance, float candela) {
        Scene room;
        add_box(room, add_grey(room, 0.5F), {0, 0, 0}, {4, 4, 4}, Facing::inward);
        add_quad(room, add_grey(room, 0, radiance), {1.9F, 3.99F, 1.9F}, {0.2F, 0, 0}, {0, 0, 0.2F});
        if (candela > 0) room.lights.push_back(point_light(light, candela));
        return room;
    }
    static constexpr glm::vec3 light{3, 1, 3};
};

HeldOut draw(const Room& room, std::size_t points, std::uint64_t seed = 0) {
    HeldOutOptions options;
    options.points = points;
    options.samples = 16;
    options.bands = 1;
    options.seed = seed;
    return trace_held_out(make_volume({{{0, 0, 0}, {0.5, 0.5, 0.5}, {9, 9, 9}}}, 1), room.paths, {}, options);
}

/// What is inside of a sphere: share of points, and of space as their weights have it, with its standard error.
struct Inside {
    double points = 0, space = 0, error = 0;

    Inside(const HeldOut& held_out, glm::dvec3 center, double radius) {
        double all = 0;
        for (const double weight : held_out.weights) all += weight;
        const auto is_inside = [&](std::size_t i) { return glm::distance(held_out.points[i], center) < radius; };
        const std::size_t n = held_out.points.size();
        for (std::size_t i = 0; i < n; ++i) {
            points += is_inside(i) ? 1.0 / static_cast<double>(n) : 0.0;
            space += is_inside(i) ? held_out.weights[i] / all : 0.0;
        }
        double squares = 0;
        for (std::size_t i = 0; i < n; ++i) {
            const double off = held_out.weights[i] / all * ((is_inside(i) ? 1 : 0) - space);
            squares += off * off;
        }
        error = std::sqrt(squares);
    }
};

TEST(HeldOut, PointsAreDenserBesideLampsAndWeighLessForIt) {
    const Room room;
    const HeldOut held_out = draw(room, 4096);
    ASSERT_EQ(held_out.points.size(), 4096U);
    ASSERT_EQ(held_out.weights.size(), held_out.points.size());
    const double sphere = 4.0 / 3 * M_PI;
    const double room_size = 64;
    const auto cube = [](double x) { return x * x * x; };
    const double at_light = 0.05;  // of 0.5 m, a tenth
    const Inside beside_lamp(held_out, {2, 4, 2}, 0.5);
    const Inside beside_light(held_out, glm::dvec3(Room::light), 0.5);
    const Inside elsewhere(held_out, {1, 1, 1}, 1);
    EXPECT_GT(beside_lamp.points, 4 * 0.5 * sphere * cube(0.5) / room_size);
    EXPECT_GT(beside_light.points, 4 * sphere * cube(0.5) / room_size);
    EXPECT_NEAR(beside_lamp.space, 0.5 * sphere * cube(0.5) / room_size, 4 * beside_lamp.error);
    EXPECT_NEAR(beside_light.space, sphere * (cube(0.5) - cube(at_light)) / room_size, 4 * beside_light.error);
    EXPECT_NEAR(elsewhere.space, sphere / room_size, 4 * elsewhere.error);
    EXPECT_LT(beside_lamp.error, 0.25 * beside_lamp.space) << "or the test says nothing";
}

TEST(HeldOut, PointsKeepOffLightsWithoutSize) {
    const Room room(0, 10);
    const HeldOut held_out = draw(room, 2048);
    double nearest = 1;
    for (const glm::dvec3& point : held_out.points) {
        nearest = std::min(nearest, glm::distance(point, glm::dvec3(Room::light)));
    }
    EXPECT_GE(nearest, 0.05);
    EXPECT_LT(nearest, 0.1);
}

TEST(HeldOut, PointsAreEvenWhereThereIsNoLight) {
    const HeldOut held_out = draw(Room(0, 0), 256);
    for (const double weight : held_out.weights) EXPECT_EQ(weight, 1);
}

TEST(HeldOut, PointsAreTheSameForAnyNumberOfThreads) {
    const Room room;
    const HeldOut many = draw(room, 64);
    const ThreadLimit limit(1);
    const HeldOut one = draw(room, 64);
    EXPECT_EQ(many.points, one.points);
    EXPECT_EQ(many.weights, one.weights);
    EXPECT_NE(draw(room, 64, 1).points, one.points);
}

}  // namespace
}  // namespace lightgrid
