#pragma once

#include "core/tracer.h"
#include "viewer/flight.h"
#include "viewer/look_up.h"

namespace lightgrid {

/// A flight through a level for which nobody has written one, and an object that fits it.
struct DefaultFlight {
    Flight flight;
    double object_size = 1;  // metres
};

/// Leads through free space from one place with interesting light to the next, smoothly and never through a surface;
/// the object flies ahead, and the camera looks at it and past it. Where there is no room to fly, it turns round in
/// place. The same for the same level and volume.
[[nodiscard]] DefaultFlight make_default_flight(const Tracer& tracer, const LitVolume& volume);

}  // namespace lightgrid
