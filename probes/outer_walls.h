#pragma once

#include "core/tracer.h"

#include <cstdint>

namespace lightgrid {

/// The level's bounds without what lies behind its outer walls: a sill or a roof that stands out takes the bounds with
/// it, and probes there would be in the open, bright neighbours of dark ones inside, with a wall between them. A side
/// moves in to where its wall begins, where two thirds of it or more are wall within `reach`, and as far as hardly any
/// of that wall is cut off: uneven ground stays.
///
/// reach  metres, > 0
/// rays   counted up by those that it takes
[[nodiscard]] Box within_outer_walls(const Tracer& tracer, double reach, std::uint64_t& rays);

}  // namespace lightgrid
