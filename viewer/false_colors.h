#pragma once

#include "tools/false_color.h"
#include "viewer/gl_objects.h"
#include "viewer/level_mesh.h"
#include "viewer/settings.h"

#include <span>

namespace lightgrid {

/// Numbers on the level in the colours of `lightgrid draw`: what false_color.glsl asks for.
struct FalseColors {
    LevelColors what = LevelColors::irradiance;  // or standard_error, difference
    LogScale scale;                              // lux, or shares
    Tone tone = Tone::film;                      // that they have to survive
};

/// Of differences from the path tracer, which is the same for all levels: 1 to 100 %.
[[nodiscard]] LogScale difference_scale();

/// Scales that show all of a level's light: irradiance, and its standard error as a share.
struct LightScales {
    LogScale irradiance;
    LogScale standard_error;
};
[[nodiscard]] LightScales scales_of(std::span<const VertexLight> light);

void set_false_colors(const Uniforms& uniforms, const FalseColors& colors);

}  // namespace lightgrid
