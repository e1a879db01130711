#pragma once

#include "viewer/camera.h"
#include "viewer/look_up.h"

namespace lightgrid {

/// What radiance is multiplied by so that a grey surface (albedo 0.5) in the usual light comes out at 0.16, which tone
/// mapping shows as a middle grey. The usual light is between that of the whole volume and that around the eye and
/// before it, so that exposure follows a flight smoothly and needs no picture to be measured. 1 where there is no
/// light.
[[nodiscard]] float automatic_exposure_at(const LookUp& light, const Pose& pose);

/// The exposure that `settings` ask for.
[[nodiscard]] float exposure_of(const Settings& settings, const LookUp& light, const Pose& pose);

}  // namespace lightgrid
