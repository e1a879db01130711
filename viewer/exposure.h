#pragma once

#include "core/scene.h"
#include "viewer/camera.h"
#include "viewer/look_up.h"

namespace lightgrid {

/// A surface of mean lightness, for want of a level.
inline constexpr float grey_albedo = 0.5F;

/// Of the level's surfaces by area, luminance; at least that of grey: what is dark shall look dark.
[[nodiscard]] float mean_albedo(const Scene& scene);

/// What radiance is multiplied by so that a grey surface (albedo 0.5) in the usual light comes out at 0.16, which tone
/// mapping shows as a middle grey; in a level that is lighter, a surface of the geometric mean of its albedo and grey,
/// so that white stays lighter than grey without washing out. The usual light is between that of the whole volume and that around the eye and
/// before it, so that exposure follows a flight smoothly and needs no picture to be measured. 1 where there is no
/// light.
[[nodiscard]] float automatic_exposure_at(const LookUp& light, const Pose& pose, float albedo);

/// The exposure that `settings` ask for.
[[nodiscard]] float exposure_of(const Settings& settings, const LookUp& light, const Pose& pose, float albedo);

}  // namespace lightgrid
