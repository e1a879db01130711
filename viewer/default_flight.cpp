#include "viewer/default_flight.h"

#include "core/sampling.h"
#include "viewer/free_space.h"
#include "viewer/gaze.h"
#include "viewer/route.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace lightgrid {
namespace {

/// Room that a flight asks for around itself, in cells of the lattice of free space: less and less until there is room
/// to go somewhere.
constexpr std::array<float, 4> wanted_clearances{1.5F, 1.0F, 0.6F, 0.3F};
/// Of the points of free space at the least clearance, that at a larger one are enough to fly through.
constexpr double enough_room = 0.4;
constexpr double least_duration_s = 10;
constexpr double most_duration_s = 24;
constexpr double keys_per_second = 4;
constexpr double sizes_ahead = 5;  // from eye to object, in the object's size
/// The object swings to and fro before the eye, so that it hides no part of the picture for long.
constexpr double swing_deg = 10;
constexpr double swing_s = 9;

/// From 0 to 1, starting and ending at rest.
double eased(double t) {
    constexpr double ramp = 0.12;  // of the time, at each end
    const double most = 1 / (1 - ramp);
    if (t < ramp) return most * t * t / (2 * ramp);
    if (t > 1 - ramp) return 1 - most * (1 - t) * (1 - t) / (2 * ramp);
    return most * (t - ramp / 2);
}

DefaultFlight turn_in_place(const Tracer& tracer, const LitVolume& volume) {
    const LookUp light = look_up(volume, Settings{});
    glm::dvec3 eye = tracer.scene().bounds.empty() ? glm::dvec3(0) : tracer.scene().bounds.center();
    float most = -1;
    for (std::size_t slot = 0; slot < volume.volume.list_start(); ++slot) {
        if (!is_valid(volume.volume.states[slot])) continue;
        const glm::dvec3 position = gather_position(volume.volume, slot);
        const float bright = luminance(mean_irradiance_at(light, position));
        if (bright > most) {
            most = bright;
            eye = position;
        }
    }
    DefaultFlight result;
    for (int i = 0; i <= 8; ++i) {
        FlightKey key{.time_s = i * least_duration_s / 8, .eye = eye, .yaw_deg = 45.0 * i};
        key.object = eye + 0.5 * volume.spacing * forward({eye, key.yaw_deg, -10});
        result.flight.keys.push_back(key);
    }
    result.object_size = 0.15 * volume.spacing;
    return result;
}

}  // namespace

DefaultFlight make_default_flight(const Tracer& tracer, const LitVolume& volume) {
    const LookUp light = look_up(volume, Settings{});
    const FreeSpace space = find_free_space(tracer, volume.volume, wanted_clearances, enough_room);
    const Route route = find_route(tracer, light, space);
    if (route.points.empty()) return turn_in_place(tracer, volume);

    DefaultFlight result;
    result.object_size = std::min(0.5 * space.room, 0.06 * route.length());
    const double duration = std::clamp(route.length() / (4 * result.object_size), least_duration_s, most_duration_s);
    const int keys = 1 + static_cast<int>(duration * keys_per_second);
    std::vector<FlightStop> stops;
    for (int i = 0; i < keys; ++i) {
        const double share = static_cast<double>(i) / (keys - 1);
        const double passed = eased(share) * route.length();
        FlightStop stop{.eye = route.at(passed),
                        .aside_deg = swing_deg * std::cos(2 * std::numbers::pi * share * duration / swing_s)};
        const glm::vec3 along = route.at(passed + 4 * route.step) - route.at(passed - 4 * route.step);
        if (glm::length(along) > 0) stop.heading = glm::normalize(along);
        stops.push_back(stop);
    }
    const std::vector<Gaze> gazes =
        choose_gazes(tracer, light, stops, result.object_size, sizes_ahead * result.object_size);
    const glm::dvec3 origin = tracer.scene().origin;
    for (std::size_t i = 0; i < gazes.size(); ++i) {
        result.flight.keys.push_back({.time_s = duration * static_cast<double>(i) / (keys - 1),
                                      .eye = origin + glm::dvec3(stops[i].eye),
                                      .yaw_deg = gazes[i].yaw_deg,
                                      .pitch_deg = gazes[i].pitch_deg,
                                      .object = origin + glm::dvec3(gazes[i].object)});
    }
    return result;
}

}  // namespace lightgrid
