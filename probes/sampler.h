#pragma once

#include <array>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "probes/volume.h"

namespace lightgrid {

enum class Outside : std::uint8_t { clamp, fade };  // beyond the volume: nearest light, or fade to `environment`

struct SampleOptions {
    float normal_bias = 0;  // metres that the position is moved along the normal before the look-up
    Outside outside = Outside::clamp;
    float fade_distance = 1;                    // metres over which `fade` goes to the environment
    std::span<const glm::vec3> environment{};  // bands^2 coefficients; empty: black
};

/// Interpolated coefficients. weight: the share of trilinear weight that valid corners carried, before renormalisation;
/// 0: no valid corner, sh is then all zero and means "unknown", not "black".
struct Sample {
    std::vector<glm::vec3> sh;
    float weight = 0;
};

/// Finds cells in a volume quickly. Keeps a reference: the volume must outlive it and stay as it is.
class Sampler {
  public:
    explicit Sampler(const Volume& volume);

    /// Trilinear, weights renormalised over valid corners; where grids overlap, the finest spacing answers.
    [[nodiscard]] Sample sample(glm::dvec3 position, const SampleOptions& options = {}) const;
    /// Irradiance, lux; not clamped at zero.
    [[nodiscard]] glm::vec3 irradiance(glm::dvec3 position, glm::vec3 normal, const SampleOptions& options = {}) const;
};

}  // namespace lightgrid
