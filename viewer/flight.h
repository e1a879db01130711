#pragma once

#include "viewer/camera.h"

#include <glm/glm.hpp>

#include <filesystem>
#include <optional>
#include <vector>

namespace lightgrid {

/// Where camera and object are at a time.
struct FlightKey {
    double time_s = 0;
    glm::dvec3 eye{0};
    std::optional<glm::dvec3> look_at{};  // else by yaw and pitch, see Pose
    double yaw_deg = 0;
    double pitch_deg = 0;
    std::optional<glm::dvec3> object{};  // its centre; in all keys of a flight or in none
};

/// A path through a level.
struct Flight {
    double frames_per_second = 30;
    std::vector<FlightKey> keys;  // at least one; times rise

    [[nodiscard]] double start_s() const { return keys.front().time_s; }
    [[nodiscard]] double duration_s() const { return keys.back().time_s - keys.front().time_s; }
};

struct FlightMoment {
    Pose pose;
    std::optional<glm::dvec3> object;
};

/// Between the keys: cubic Hermite curves through them whose tangents are those of the chord between the neighbours
/// (Catmull-Rom, for uneven times). Looks at the interpolated look_at if all keys have one; else yaw and pitch are
/// interpolated, each turn the short way round. Before the first key and after the last it stands still.
[[nodiscard]] FlightMoment evaluate(const Flight& flight, double time_s);

/// The time of a frame: `frames` of them, spread evenly over the whole flight.
[[nodiscard]] double frame_time_s(const Flight& flight, int frame, int frames);
/// As many frames as the flight's own rate asks for; at least 1.
[[nodiscard]] int frame_count(const Flight& flight);

/// JSON: {"frames_per_second": 30, "keys": [{"time_s": 0, "eye": [x, y, z], "look_at": [x, y, z] or "yaw_deg": 0,
/// "pitch_deg": 0, "object": [x, y, z]}, ...]}. Level coordinates; frames_per_second and object may be missing.
///
/// Throws Error that names the file, and the key by its number from 0: no JSON, no keys, a value of the wrong kind or
/// not finite, times that do not rise, a name that is not known, an object in some keys but not in others.
[[nodiscard]] Flight load_flight(const std::filesystem::path& path);
/// Written whole or not at all; reads back to the same numbers.
void save_flight(const Flight& flight, const std::filesystem::path& path);

}  // namespace lightgrid
