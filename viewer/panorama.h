#pragma once

#include "core/tracer.h"
#include "viewer/camera.h"
#include "viewer/look_up.h"

#include <glm/glm.hpp>

#include <vector>

namespace lightgrid {

/// Directions at equal steps of yaw, all round, and of pitch.
struct Directions {
    int yaws = 0;
    int pitches = 0;
    double lowest_pitch_deg = 0;
    double pitch_step_deg = 0;

    [[nodiscard]] double yaw_deg(int yaw) const { return 360.0 * yaw / yaws; }
    [[nodiscard]] double pitch_deg(int pitch) const { return lowest_pitch_deg + pitch_step_deg * pitch; }
    [[nodiscard]] glm::dvec3 at(int yaw, int pitch) const { return forward({{}, yaw_deg(yaw), pitch_deg(pitch)}); }
};

/// How bright irradiance (lux) looks to an eye that knows the volume's usual light: 1 for that or more, 0 for a hundredth
/// of it or less, even steps for equal ratios between.
[[nodiscard]] double brightness(double irradiance, const LookUp& light);

/// What there is to see from a point: what a ray in each direction is worth to an onlooker.
struct Panorama {
    Directions directions;
    std::vector<float> worth;  // [pitch][yaw]
};

/// Lit surfaces are worth up to 1, the farther the more; what one sees from behind, or nothing at all, is worth less
/// than 0, and what is in the way much less.
///
/// eye   relative to Scene::origin
/// near  metres: surfaces at this distance are worth half of those far away
[[nodiscard]] Panorama look_round(const Tracer& tracer, const LookUp& light, glm::vec3 eye, double near,
                                  const Directions& directions);

/// Of a picture with its middle in a direction: the mean of what is in it, and how much the surfaces differ
/// (standard deviation).
[[nodiscard]] double worth_of_view(const Panorama& panorama, int yaw, int pitch);

}  // namespace lightgrid
