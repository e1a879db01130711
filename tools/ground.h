#pragma once

#include "core/tracer.h"

#include <glm/glm.hpp>

#include <optional>

/// Where people are in a level: above something to stand on.
namespace lightgrid {

/// Metres straight down to the first surface, where that is one to stand on: no steeper than 60 degrees, seen from
/// whichever side, since winding lies. Below a level, and beside one that ends in the void, there is none.
///
/// point  relative to Scene::origin
[[nodiscard]] std::optional<float> height_above_ground(const Tracer& tracer, glm::vec3 point);

}  // namespace lightgrid
