#pragma once

#include "core/tracer.h"

#include <cstdint>
#include <optional>

namespace lightgrid {

/// The height above which objects want room under the open sky: that of the highest ground on which they can stand
/// there. Ground is what a ray from above meets first, wide enough to stand on, unless it is the roof of a room: of a
/// space below, as high as half of `headroom`, that has walls on most sides, seen from their front. Single spots are no
/// ground: half a percent of the level's area may lie higher.
///
/// headroom  of objects, metres, > 0: what counts as wide and as high is in proportion to it
/// rays      counted up by those that it takes
/// returns   y in the level's coordinates; none where nothing is open to the sky but roofs, and in an empty level
[[nodiscard]] std::optional<double> top_of_open_ground(const Tracer& tracer, double headroom, std::uint64_t& rays);

}  // namespace lightgrid
