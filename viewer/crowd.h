#pragma once

#include "viewer/draw_balls.h"
#include "viewer/look_up.h"

#include <glm/glm.hpp>

#include <span>
#include <vector>

/// Many small objects that move through a volume at once, each lit as a whole by a look-up of its own. No OpenGL here.
namespace lightgrid {

inline constexpr std::size_t crowd_size = 1000;

/// As many balls as crowd_size, if the volume has any valid probe: each circles round one. Without light yet.
[[nodiscard]] std::vector<Ball> crowd_at(const LitVolume& volume, double time_s, glm::dvec3 origin);

/// Gives each ball the light at its centre.
void light_crowd(const LookUp& from, glm::dvec3 origin, std::span<Ball> balls);

}  // namespace lightgrid
