#pragma once

#include "core/tracer.h"

#include <optional>
#include <string>

namespace lightgrid {

/// What speaks against a level's unit being the metre.
struct UnitHint {
    std::string evidence;        // "its rooms would be 549 m high"
    std::string unit;            // what it may be: "millimetre", "centimetre" or "inch"
    double metres_per_unit = 1;  // of that
};

/// Takes the level's unit for the metre and looks for what is larger than people build: rooms more than 70 m high; or
/// thousands of triangles in many layers, none of them small, without a room as high as rooms are. Terrain, however
/// wide, has neither; halls, towns and woods are not as large or not in as many layers. Rooms are what is between a level
/// floor and a level ceiling that does not shine (a sky's does), both seen from their front.
///
/// The unit is the smallest in which people can stand in the rooms; the centimetre where there are none.
///
/// returns  none where nothing speaks against the metre
[[nodiscard]] std::optional<UnitHint> find_unit_hint(const Tracer& tracer);

}  // namespace lightgrid
