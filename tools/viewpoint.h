#pragma once

#include "core/tracer.h"
#include "probes/volume.h"
#include "tools/lit_level.h"

namespace lightgrid {

/// A camera for a level that nobody has chosen one for: the eyes of somebody who stands in it, at 1.6 m or less where the
/// headroom is less, under one of up to 1,024 lit probes, looking slightly down. Of all that, what is enclosed most, sees
/// far, and has most different surfaces in the picture.
[[nodiscard]] Camera find_viewpoint(const Tracer& tracer, const Volume& volume, double horizontal_angle_deg);

}  // namespace lightgrid
