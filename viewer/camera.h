#pragma once

#include <glm/glm.hpp>

namespace lightgrid {

/// Where an eye is and where it looks. Level coordinates, metres.
struct Pose {
    glm::dvec3 eye{0};
    double yaw_deg = 0;    // 0 looks along -Z, 90 along -X: counter-clockwise seen from above
    double pitch_deg = 0;  // up positive, within [-most_pitch_deg, most_pitch_deg]
};

/// Short of straight up and down, where yaw would mean nothing.
inline constexpr double most_pitch_deg = 89;

/// Unit vectors of what the eye sees.
[[nodiscard]] glm::dvec3 forward(const Pose& pose);
[[nodiscard]] glm::dvec3 rightward(const Pose& pose);

/// The pose of an eye that looks at `target`; its pitch is clamped. With `target` at the eye, or no number: along -Z.
[[nodiscard]] Pose looking_at(glm::dvec3 eye, glm::dvec3 target);

/// Turned by as much; the pitch is clamped, the yaw stays in [0, 360).
[[nodiscard]] Pose turned(const Pose& pose, double yaw_deg, double pitch_deg);

/// Moved along its own axes: x to the right, y up (the level's +Y), z forward, metres.
[[nodiscard]] Pose moved(const Pose& pose, glm::dvec3 by);

/// How an eye sees.
struct Lens {
    double vertical_angle_deg = 60;
    double near = 0.05;  // metres, positive
    double far = 1000;
};

/// Near enough not to cut into what one flies along, and far enough for all of a level.
///
/// diagonal     of the level's bounds, metres
/// object_size  of what flies along; what leaves it room leaves it to the eye
[[nodiscard]] Lens lens_for(double diagonal, double object_size);

/// From positions relative to `origin` to OpenGL's clip space, composed in double.
///
/// aspect  width over height of the picture
[[nodiscard]] glm::mat4 clip_from_level(const Pose& pose, const Lens& lens, double aspect, glm::dvec3 origin);

/// The unit direction seen at a pixel's centre.
///
/// pixel  from the upper left corner
[[nodiscard]] glm::dvec3 ray_through(const Pose& pose, const Lens& lens, glm::dvec2 pixel, glm::ivec2 size);

}  // namespace lightgrid
