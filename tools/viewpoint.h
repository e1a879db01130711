#pragma once

#include "core/tracer.h"
#include "probes/volume.h"
#include "tools/lit_level.h"

namespace lightgrid {

/// A camera for a level that nobody has chosen one for: it stands at a valid, lit probe at about a third of the
/// volume's height and looks, slightly down, where surfaces are far but not out of sight.
[[nodiscard]] Camera find_viewpoint(const Tracer& tracer, const Volume& volume, double horizontal_angle_deg);

}  // namespace lightgrid
