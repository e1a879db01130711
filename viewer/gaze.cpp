#include "viewer/gaze.h"

#include "core/parallel.h"
#include "viewer/free_space.h"
#include "viewer/panorama.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lightgrid {
namespace {

constexpr Directions directions{.yaws = 72, .pitches = 15, .lowest_pitch_deg = -45, .pitch_step_deg = 5};
/// Rows of pitch in which the eye may look, and how far it turns from stop to stop.
constexpr int lowest_gaze = 4;
constexpr int gaze_pitches = 6;
constexpr int most_yaw_steps = 2;
constexpr int most_pitch_steps = 1;
constexpr int states = directions.yaws * gaze_pitches;

constexpr double object_drop_deg = 8;  // below the picture's middle
constexpr double least_share = 0.4;    // of the wanted distance to the object

// What is weighed, in units of the worth of a view.
constexpr double worth_of_heading = 0.06;
constexpr double cost_of_nearness = 0.6;   // of the object
constexpr double cost_of_hiding = 3;       // the object
constexpr double cost_of_crossing = 1;     // a surface with the object
constexpr double cost_of_turning = 0.012;  // times the square of steps
constexpr double cost_of_jumping = 2;      // times the square of the share by which the object's distance changes

/// From one stop to the next.
constexpr int softening = 3;

glm::dvec3 towards_object(double yaw_deg, double pitch_deg, double aside_deg) {
    return forward(turned({{}, yaw_deg, pitch_deg}, aside_deg, -object_drop_deg));
}

/// How far from the eye an object of this radius can be, at most `ahead`, and be seen as a whole, clear of surfaces.
double distance_in_sight(const Tracer& tracer, glm::vec3 eye, glm::dvec3 direction, double radius, double ahead) {
    const glm::dvec3 right = glm::normalize(glm::cross(direction, glm::dvec3(0, 1, 0)));
    const glm::dvec3 up = glm::cross(right, direction);
    double free = ahead + 2 * radius;
    for (const glm::dvec2 aside :
         {glm::dvec2(0), glm::dvec2(1, 0), glm::dvec2(-1, 0), glm::dvec2(0, 1), glm::dvec2(0, -1)}) {
        const glm::vec3 ray(glm::normalize(ahead * direction + 1.2 * radius * (aside.x * right + aside.y * up)));
        const Hit hit = tracer.closest_hit(eye, ray, static_cast<float>(free));
        if (hit.found()) free = std::min(free, static_cast<double>(hit.distance));
    }
    return std::min(ahead, free - 1.5 * radius);
}

/// A way of looking from a stop.
struct Look {
    double worth = 0;
    double distance = 0;  // to the object
    glm::vec3 object{0};
    double best = 0;  // of all ways to here
    int from = 0;
};

double yaw_of(int state) {
    return directions.yaw_deg(state / gaze_pitches);
}
int row_of(int state) {
    return lowest_gaze + state % gaze_pitches;
}

std::vector<Look> looks_from(const Tracer& tracer, const LookUp& light, const FlightStop& stop, double size,
                             double ahead) {
    const Panorama panorama = look_round(tracer, light, stop.eye, ahead, directions);
    std::vector<Look> looks(states);
    for (int state = 0; state < states; ++state) {
        Look& look = looks[static_cast<std::size_t>(state)];
        const double pitch = directions.pitch_deg(row_of(state));
        const glm::dvec3 to_object = towards_object(yaw_of(state), pitch, stop.aside_deg);
        const double distance = distance_in_sight(tracer, stop.eye, to_object, 0.5 * size, ahead);
        look.distance = std::max(distance, least_share * ahead);
        look.object = stop.eye + glm::vec3(look.distance * to_object);
        look.worth = worth_of_view(panorama, state / gaze_pitches, row_of(state)) +
                     worth_of_heading * glm::dot(glm::dvec3(stop.heading), forward({{}, yaw_of(state), pitch})) -
                     cost_of_nearness * (1 - look.distance / ahead) - (distance < look.distance ? cost_of_hiding : 0);
    }
    return looks;
}

/// Finds the best way to every look of a stop from those of the stop before.
void join(const Tracer& tracer, const std::vector<Look>& before, std::vector<Look>& looks, double ahead) {
    for_each_index(looks.size(), [&](std::size_t i) {
        Look& look = looks[i];
        look.best = -std::numeric_limits<double>::infinity();
        const int yaw = static_cast<int>(i) / gaze_pitches;
        const int pitch = static_cast<int>(i) % gaze_pitches;
        for (int turn = -most_yaw_steps; turn <= most_yaw_steps; ++turn) {
            for (int rise = -most_pitch_steps; rise <= most_pitch_steps; ++rise) {
                if (pitch + rise < 0 || pitch + rise >= gaze_pitches) continue;
                const int from = (yaw + turn + directions.yaws) % directions.yaws * gaze_pitches + pitch + rise;
                const Look& last = before[static_cast<std::size_t>(from)];
                const double jump = (look.distance - last.distance) / ahead;
                const double sum = last.best + look.worth - cost_of_turning * (turn * turn + rise * rise) -
                                   cost_of_jumping * jump * jump;
                if (sum <= look.best) continue;
                const double crossing = is_clear(tracer, last.object, look.object) ? 0 : cost_of_crossing;
                if (sum - crossing <= look.best) continue;
                look.best = sum - crossing;
                look.from = from;
            }
        }
    });
}

/// Mean over a few neighbours on both sides, and again: what is followed with the eye does not jerk.
void soften(std::vector<double>& values) {
    const auto last = static_cast<std::ptrdiff_t>(values.size()) - 1;
    for (int round = 0; round < 2; ++round) {
        const std::vector<double> before = values;
        for (std::ptrdiff_t i = 0; i <= last; ++i) {
            double sum = 0;
            for (std::ptrdiff_t k = i - softening; k <= i + softening; ++k) {
                sum += before[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(k, 0, last))];
            }
            values[static_cast<std::size_t>(i)] = sum / (2 * softening + 1);
        }
    }
}

}  // namespace

std::vector<Gaze> choose_gazes(const Tracer& tracer, const LookUp& light, std::span<const FlightStop> stops,
                               double size, double ahead) {
    std::vector<std::vector<Look>> looks(stops.size());
    for_each_index(stops.size(), [&](std::size_t i) { looks[i] = looks_from(tracer, light, stops[i], size, ahead); });
    for (Look& look : looks.front()) look.best = look.worth;
    for (std::size_t i = 1; i < stops.size(); ++i) join(tracer, looks[i - 1], looks[i], ahead);

    std::vector<double> yaws(stops.size());
    std::vector<double> pitches(stops.size());
    const std::vector<Look>& ends = looks.back();
    int state = static_cast<int>(
        std::max_element(ends.begin(), ends.end(), [](const Look& a, const Look& b) { return a.best < b.best; }) -
        ends.begin());
    for (std::size_t i = stops.size(); i-- > 0; state = looks[i][static_cast<std::size_t>(state)].from) {
        const double after = i + 1 < stops.size() ? yaws[i + 1] : 180;
        yaws[i] = after + std::remainder(yaw_of(state) - after, 360);
        pitches[i] = directions.pitch_deg(row_of(state));
    }
    soften(yaws);
    soften(pitches);

    std::vector<double> distances(stops.size());
    for (std::size_t i = 0; i < stops.size(); ++i) {
        const glm::dvec3 to_object = towards_object(yaws[i], pitches[i], stops[i].aside_deg);
        distances[i] =
            std::max(distance_in_sight(tracer, stops[i].eye, to_object, 0.5 * size, ahead), least_share * ahead);
    }
    std::vector<double> smooth = distances;
    soften(smooth);
    std::vector<Gaze> gazes;
    for (std::size_t i = 0; i < stops.size(); ++i) {
        const glm::dvec3 to_object = towards_object(yaws[i], pitches[i], stops[i].aside_deg);
        gazes.push_back({yaws[i], pitches[i], stops[i].eye + glm::vec3(std::min(smooth[i], distances[i]) * to_object)});
    }
    return gazes;
}

}  // namespace lightgrid
