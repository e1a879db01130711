#pragma once

#include "core/environment.h"

#include <glm/glm.hpp>

#include <vector>

namespace lightgrid {

/// Of what nobody can tell from all directions: irradiance is exact to 1e-3.
inline constexpr int all_environment_samples = 1 << 18;

/// SH coefficients (core/sh.h) of an environment's radiance, L_i = integral L(w) Y_i(w) dw, estimated from directions
/// drawn in proportion to its luminance; deterministic. 0.1 us a sample.
///
/// bands    1 to max_sh_bands
/// samples  at least 1
[[nodiscard]] std::vector<glm::vec3> project_environment(const Environment& environment, int bands,
                                                         int samples = all_environment_samples);

}  // namespace lightgrid
