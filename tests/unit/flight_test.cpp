#include "viewer/flight.h"

#include "core/error.h"
#include "core/tracer.h"
#include "tests/gltf_builder.h"
#include "tests/scene_builder.h"
#include "viewer/default_flight.h"
#include "viewer/free_space.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace lightgrid {
namespace {

FlightKey key_at(double time_s, glm::dvec3 eye) {
    FlightKey key;
    key.time_s = time_s;
    key.eye = eye;
    return key;
}

TEST(Flight, PassesThroughItsKeys) {
    Flight flight;
    for (int i = 0; i < 5; ++i) {
        FlightKey key = key_at(i * i * 0.3, {i, std::sin(i), -2 * i});
        key.look_at = glm::dvec3(10, i, 0);
        key.object = glm::dvec3(i, i, i);
        flight.keys.push_back(key);
    }
    for (const FlightKey& key : flight.keys) {
        const FlightMoment moment = evaluate(flight, key.time_s);
        EXPECT_LT(glm::distance(moment.pose.eye, key.eye), 1e-12);
        EXPECT_LT(glm::distance(forward(moment.pose), glm::normalize(*key.look_at - key.eye)), 1e-12);
        EXPECT_LT(glm::distance(*moment.object, *key.object), 1e-12);
    }
}

TEST(Flight, EvenKeysOnALineAreFlownEvenly) {
    Flight flight;
    for (int i = 0; i < 4; ++i) flight.keys.push_back(key_at(2 * i, {3 * i, 0, 0}));
    for (double time = 0; time <= 6; time += 0.37) EXPECT_NEAR(evaluate(flight, time).pose.eye.x, 1.5 * time, 1e-12);
}

TEST(Flight, StandsStillBeforeAndAfter) {
    Flight flight;
    flight.keys = {key_at(1, {0, 0, 0}), key_at(2, {5, 0, 0})};
    EXPECT_EQ(evaluate(flight, -10).pose.eye.x, 0);
    EXPECT_EQ(evaluate(flight, 10).pose.eye.x, 5);
    flight.keys.pop_back();
    EXPECT_EQ(evaluate(flight, 10).pose.eye.x, 0);
}

TEST(Flight, TurnsTheShortWayRound) {
    Flight flight;
    flight.keys = {key_at(0, {}), key_at(1, {}), key_at(2, {})};
    flight.keys[0].yaw_deg = 350;
    flight.keys[1].yaw_deg = 10;
    flight.keys[2].yaw_deg = 30;
    EXPECT_NEAR(std::remainder(evaluate(flight, 0.5).pose.yaw_deg, 360), 0, 1e-9);
    EXPECT_NEAR(evaluate(flight, 1.5).pose.yaw_deg, 20, 1e-9);
}

TEST(Flight, FramesSpanTheWholeFlight) {
    Flight flight;
    flight.frames_per_second = 10;
    flight.keys = {key_at(1, {}), key_at(3, {})};
    EXPECT_EQ(frame_count(flight), 21);
    EXPECT_DOUBLE_EQ(frame_time_s(flight, 0, 5), 1);
    EXPECT_DOUBLE_EQ(frame_time_s(flight, 4, 5), 3);
    EXPECT_DOUBLE_EQ(frame_time_s(flight, 0, 1), 1);
}

TEST(Flight, ReadsBackWhatItWrote) {
    const TemporaryFolder folder;
    Flight flight;
    flight.frames_per_second = 23.976;
    flight.keys = {key_at(0, {0.1, 1.0 / 3, 1e-9}), key_at(0.7, {1, 2, 3})};
    flight.keys[0].look_at = glm::dvec3(M_PI, 0, 1e5);
    flight.keys[1].yaw_deg = 12.5;
    flight.keys[1].pitch_deg = -7;
    for (FlightKey& key : flight.keys) key.object = glm::dvec3(0.2);
    save_flight(flight, folder.path() / "path.json");
    const Flight read = load_flight(folder.path() / "path.json");
    EXPECT_EQ(read.frames_per_second, flight.frames_per_second);
    ASSERT_EQ(read.keys.size(), 2U);
    for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_EQ(read.keys[i].time_s, flight.keys[i].time_s);
        EXPECT_EQ(read.keys[i].eye, flight.keys[i].eye);
        EXPECT_EQ(read.keys[i].look_at, flight.keys[i].look_at);
        EXPECT_EQ(read.keys[i].yaw_deg, flight.keys[i].yaw_deg);
        EXPECT_EQ(read.keys[i].pitch_deg, flight.keys[i].pitch_deg);
        EXPECT_EQ(read.keys[i].object, flight.keys[i].object);
    }
}

TEST(Flight, WrongPathsAreRefusedByFileAndKey) {
    const TemporaryFolder folder;
    const auto refusal = [&](const std::string& text) {
        write_bytes(folder.path() / "p.json", text);
        try {
            static_cast<void>(load_flight(folder.path() / "p.json"));
        } catch (const Error& error) {
            EXPECT_EQ(error.fault(), Fault::input);
            EXPECT_NE(error.where().find("p.json"), std::string::npos) << error.what();
            return std::string(error.what());
        }
        return std::string("accepted");
    };
    const std::string first = R"({"time_s": 0, "eye": [0,0,0], "look_at": [1,0,0]})";
    const auto two = [&](const std::string& second) { return R"({"keys": [)" + first + ", " + second + "]}"; };
    EXPECT_NE(refusal("{").find("parse error"), std::string::npos);
    EXPECT_NE(refusal("[]").find("is no JSON object"), std::string::npos);
    EXPECT_NE(refusal("{}").find("no \"keys\""), std::string::npos);
    EXPECT_NE(refusal(R"({"keys": []})").find("no \"keys\""), std::string::npos);
    EXPECT_NE(refusal(R"({"kezs": []})").find("kezs"), std::string::npos);
    EXPECT_NE(refusal(R"({"frames_per_second": 0, "keys": []})").find("not positive"), std::string::npos);
    EXPECT_NE(refusal(two(R"({"time_s": 1})")).find("key 1: needs \"time_s\" and \"eye\""), std::string::npos);
    EXPECT_NE(refusal(two(R"({"time_s": 1, "eye": [0,0]})")).find("key 1: \"eye\""), std::string::npos);
    EXPECT_NE(refusal(two(R"({"time_s": 1, "eye": [0,0,"a"]})")).find("key 1: \"eye\""), std::string::npos);
    EXPECT_NE(refusal(two(R"({"time_s": 1, "eye": [0,0,0]})")).find("key 1: needs either"), std::string::npos);
    EXPECT_NE(refusal(two(R"({"time_s": 0, "eye": [0,0,0], "yaw_deg": 1})")).find("key 1: \"time_s\" 0 is not after"),
              std::string::npos);
    EXPECT_NE(refusal(two(R"({"time_s": 1, "eye": [0,0,0], "pitch_deg": 95})")).find("pitch_deg"), std::string::npos);
    EXPECT_NE(refusal(two(R"({"time_s": 1, "eye": [0,0,0], "yaw_deg": 0, "object": [0,0,0]})")).find("in some keys"),
              std::string::npos);
    EXPECT_NE(refusal(two(R"({"time_s": 1e999, "eye": [0,0,0], "yaw_deg": 0})")), "accepted");
    EXPECT_EQ(refusal(two(R"({"time_s": 1, "eye": [0,0,0], "yaw_deg": 0})")), "accepted");
}

// ---- the default flight --------------------------------------------------------------------------------------------

/// Two rooms of 6 x 3 x 6 m with a door between them, lit from the side.
struct TwoRooms {
    Scene scene;
    Volume volume;

    TwoRooms() {
        const int wall = add_grey(scene, 0.5F);
        add_box(scene, wall, {-6, 0, -3}, {6, 3, 3}, Facing::inward);
        add_box(scene, wall, {-0.1F, 0, -3}, {0.1F, 3, 0.5F}, Facing::outward);
        add_box(scene, wall, {-0.1F, 0, 1.7F}, {0.1F, 3, 3}, Facing::outward);
        add_box(scene, wall, {-0.1F, 2.2F, 0.5F}, {0.1F, 3, 1.7F}, Facing::outward);
        volume = make_volume({{{-5.75, 0.25, -2.75}, {0.5, 0.5, 0.5}, {24, 6, 12}}}, 3);
        for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
            if (volume.states[slot] == ProbeState::absent) continue;
            volume.coefficients[slot * 9] = glm::vec3(1);
            volume.coefficients[slot * 9 + 3] = glm::vec3(0.3F);
        }
    }
};

TEST(DefaultFlight, GoesThroughTheDoorAndNeverThroughAWall) {
    const TwoRooms rooms;
    const Tracer tracer(rooms.scene);
    const LitVolume lit(rooms.volume);
    const DefaultFlight flight = make_default_flight(tracer, lit);
    ASSERT_GE(flight.flight.keys.size(), 2U);
    EXPECT_GT(flight.object_size, 0);

    constexpr int steps = 2000;
    bool left = false;
    bool right = false;
    std::optional<FlightMoment> before;
    for (int i = 0; i <= steps; ++i) {
        const FlightMoment moment = evaluate(flight.flight, frame_time_s(flight.flight, i, steps + 1));
        ASSERT_TRUE(moment.object);
        left = left || moment.pose.eye.x < -1;
        right = right || moment.pose.eye.x > 1;
        EXPECT_GT(clearance_at(tracer, glm::vec3(moment.pose.eye), 1), 0.2F) << "at step " << i;
        if (before) {
            EXPECT_TRUE(is_clear(tracer, glm::vec3(before->pose.eye), glm::vec3(moment.pose.eye))) << "at step " << i;
            EXPECT_TRUE(is_clear(tracer, glm::vec3(*before->object), glm::vec3(*moment.object))) << "at step " << i;
            // Smooth: at 100 steps a second no turn of more than a few degrees.
            EXPECT_GT(glm::dot(forward(before->pose), forward(moment.pose)), std::cos(glm::radians(5.0)));
        }
        before = moment;
    }
    EXPECT_TRUE(left);
    EXPECT_TRUE(right);
}

/// A block of 4 x 3 x 4 m on a plate of 10 x 10 m, in the void.
struct Diorama {
    Scene scene;
    Volume volume;

    Diorama() {
        const int stone = add_grey(scene, 0.5F);
        add_box(scene, stone, {-5, -1, -5}, {5, 0, 5}, Facing::outward);
        add_box(scene, stone, {-2, 0, -2}, {2, 3, 2}, Facing::outward);
        volume = make_volume({{{-7, -0.75, -7}, {0.5, 0.5, 0.5}, {29, 13, 29}}}, 1);
        for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
            if (volume.states[slot] == ProbeState::absent) continue;
            volume.coefficients[slot] = glm::vec3(1);
            const glm::dvec3 at = gather_position(volume, slot);
            const bool in_block = std::abs(at.x) < 2 && std::abs(at.z) < 2 && at.y < 3;
            const bool in_plate = std::abs(at.x) < 5 && std::abs(at.z) < 5 && at.y < 0;
            if (in_block || in_plate) volume.states[slot] = ProbeState::missing;
        }
    }
};

/// What a person sees at moments spread evenly over a flight.
struct Seen {
    int moments = 0;
    int object = 0;        // in sight as a whole, in the picture, and of a size that one sees
    int level = 0;         // fills at least a quarter of the picture
    double nearest = 1e9;  // surface to the eye, in sizes of the object
};

Seen look_on(const Tracer& tracer, const DefaultFlight& flight) {
    Seen seen;
    constexpr glm::ivec2 size(16, 9);
    constexpr int steps = 200;
    for (int i = 0; i < steps; ++i, ++seen.moments) {
        const FlightMoment moment = evaluate(flight.flight, frame_time_s(flight.flight, i, steps));
        const glm::dvec3 eye = moment.pose.eye;
        const glm::dvec3 to_object = *moment.object - eye;
        const double distance = glm::length(to_object);
        const glm::dvec3 up = glm::cross(rightward(moment.pose), forward(moment.pose));
        bool clear = true;
        for (const glm::dvec3 side : {glm::dvec3(0), up, -up, rightward(moment.pose), -rightward(moment.pose)}) {
            const glm::dvec3 edge = *moment.object + 0.5 * flight.object_size * side;
            clear = clear && is_clear(tracer, glm::vec3(eye), glm::vec3(edge));
        }
        const double from_middle_deg = glm::degrees(std::acos(glm::dot(to_object / distance, forward(moment.pose))));
        const double across_deg = glm::degrees(flight.object_size / distance);
        seen.object += clear && from_middle_deg < 25 && across_deg > 5 && across_deg < 40 ? 1 : 0;
        int hits = 0;
        for (int y = 0; y < size.y; ++y) {
            for (int x = 0; x < size.x; ++x) {
                const glm::dvec3 ray = ray_through(moment.pose, {}, {x, y}, size);
                hits += tracer.closest_hit(glm::vec3(eye), glm::vec3(ray)).found() ? 1 : 0;
            }
        }
        seen.level += 4 * hits >= size.x * size.y ? 1 : 0;
        seen.nearest = std::min(seen.nearest, clearance_at(tracer, glm::vec3(eye), 10) / flight.object_size);
    }
    return seen;
}

TEST(DefaultFlight, HasTheObjectAndTheLevelInSight) {
    const TwoRooms rooms;
    const Diorama diorama;
    for (const auto& [scene, volume] :
         {std::pair(&rooms.scene, &rooms.volume), std::pair(&diorama.scene, &diorama.volume)}) {
        const Tracer tracer(*scene);
        const LitVolume lit(*volume);
        const Seen seen = look_on(tracer, make_default_flight(tracer, lit));
        EXPECT_GE(seen.object, 0.97 * seen.moments);
        EXPECT_GE(seen.level, 0.97 * seen.moments);
        EXPECT_GE(seen.nearest, 1);
    }
}

TEST(DefaultFlight, IsTheSameEveryTime) {
    const TwoRooms rooms;
    const Tracer tracer(rooms.scene);
    const LitVolume lit(rooms.volume);
    const Flight a = make_default_flight(tracer, lit).flight;
    const Flight b = make_default_flight(tracer, lit).flight;
    ASSERT_EQ(a.keys.size(), b.keys.size());
    for (std::size_t i = 0; i < a.keys.size(); ++i) {
        EXPECT_EQ(a.keys[i].eye, b.keys[i].eye);
        EXPECT_EQ(a.keys[i].yaw_deg, b.keys[i].yaw_deg);
        EXPECT_EQ(a.keys[i].pitch_deg, b.keys[i].pitch_deg);
        EXPECT_EQ(a.keys[i].object, b.keys[i].object);
    }
}

/// A plate with a parapet of 1 m round it and two blocks on it, over a void that the volume reaches far into: below the
/// plate there is four times as much free space as above.
TEST(DefaultFlight, StaysAboveTheGroundOfALevelOverAVoid) {
    Scene scene;
    const int stone = add_grey(scene, 0.5F);
    add_box(scene, stone, {-6, -0.5F, -6}, {6, 0, 6}, Facing::outward);
    add_box(scene, stone, {-6, 0, -6}, {6, 1, -5.5F}, Facing::outward);
    add_box(scene, stone, {-6, 0, 5.5F}, {6, 1, 6}, Facing::outward);
    add_box(scene, stone, {-3, 0, -3}, {-1, 2, 0}, Facing::outward);
    add_box(scene, stone, {-6, -6, -6}, {-5, -0.5F, -5}, Facing::outward);  // a pier, which there is light on
    Volume volume = make_volume({{{-7.75, -11.75, -7.75}, {1, 1, 1}, {17, 16, 17}}}, 1);
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        if (volume.states[slot] != ProbeState::absent) volume.coefficients[slot] = glm::vec3(1);
    }
    const Tracer tracer(scene);
    const LitVolume lit(volume);
    const Flight flight = make_default_flight(tracer, lit).flight;
    double passed = 0;
    for (std::size_t i = 0; i < flight.keys.size(); ++i) {
        EXPECT_GT(flight.keys[i].eye.y, 0) << "key " << i;
        if (i > 0) passed += glm::distance(flight.keys[i].eye, flight.keys[i - 1].eye);
    }
    EXPECT_GT(passed, 5) << "it flies";
}

TEST(DefaultFlight, TurnsInPlaceWhereThereIsNoRoom) {
    TwoRooms rooms;
    for (std::size_t slot = 0; slot < rooms.volume.slots(); ++slot) {
        if (rooms.volume.states[slot] != ProbeState::absent) rooms.volume.states[slot] = ProbeState::missing;
    }
    const Tracer tracer(rooms.scene);
    const LitVolume lit(rooms.volume);
    const Flight flight = make_default_flight(tracer, lit).flight;
    EXPECT_EQ(flight.keys.front().eye, flight.keys.back().eye);
    const double quarter = frame_time_s(flight, 1, 5);
    EXPECT_NEAR(evaluate(flight, quarter).pose.yaw_deg - evaluate(flight, 0).pose.yaw_deg, 90, 1e-6);
}

TEST(FreeSpace, LinksGoBothWaysAndThroughNothing) {
    const TwoRooms rooms;
    const Tracer tracer(rooms.scene);
    const FreeSpace space = find_free_space(tracer, rooms.volume, std::array{0.5F}, 0);
    ASSERT_GT(space.points.size(), 100U);
    for (std::uint32_t i = 0; i < space.points.size(); i += 7) {
        for (std::uint32_t k = space.first_link[i]; k < space.first_link[i + 1]; ++k) {
            const std::uint32_t to = space.links[k].to;
            EXPECT_TRUE(is_clear(tracer, space.points[i], space.points[to]));
            bool back = false;
            for (std::uint32_t j = space.first_link[to]; j < space.first_link[to + 1]; ++j) {
                back = back || space.links[j].to == i;
            }
            EXPECT_TRUE(back);
        }
    }
}

}  // namespace
}  // namespace lightgrid
