#pragma once

#include "core/tracer.h"
#include "viewer/look_up.h"

#include <glm/glm.hpp>

#include <span>
#include <vector>

namespace lightgrid {

/// A moment of a flight, a fraction of a second after the one before.
struct FlightStop {
    glm::vec3 eye{0};      // relative to Scene::origin
    glm::vec3 heading{0};  // unit length, or 0 where it stands still
    double aside_deg = 0;  // how far to the left of the picture's middle the object is wanted
};

/// Where the eye looks then, and where the object is that it has in sight.
struct Gaze {
    double yaw_deg = 0;  // of one gaze after the other: not wrapped
    double pitch_deg = 0;
    glm::vec3 object{0};  // relative to Scene::origin
};

/// Of all ways to turn the eye from stop to stop, the one that shows most: open, lit and varied views, nothing in the
/// way, the object in sight and through no surface from one stop to the next, slow turns, rather forward than back.
///
/// size   of the object, metres
/// ahead  from the eye to the object, metres; less where there is no room
[[nodiscard]] std::vector<Gaze> choose_gazes(const Tracer& tracer, const LookUp& light,
                                             std::span<const FlightStop> stops, double size, double ahead);

}  // namespace lightgrid
