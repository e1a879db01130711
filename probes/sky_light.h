#pragma once

#include "core/environment.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace lightgrid {

/// The environment as gathers read it: what rays that leave bring, and what samples of it bring, made ready once so
/// that neither costs more than a look at a small table.
///
/// The two are weighted by w = p / (p + s q) and 1 - w, q the density of Environment::sample, p = 1 / (4 pi), s samples
/// for each ray. Any weights that add up to one leave the sum right, whatever density the rays have; these keep what
/// rays bring, L w, below p / s of all light of the sky, so that it may be averaged over the texels of a small map where L
/// itself may not: a sun stays where it is, in the samples.
///
/// Source of the weights: Veach, "Robust Monte Carlo Methods for Light Transport Simulation", 1997, 9.2.
class SkyLight {
  public:
    struct Sample {
        glm::vec3 direction{0};
        glm::vec3 radiance{0};  // times 1 - w, divided by the density of the sample
    };

    /// Black.
    SkyLight() = default;
    /// samples_per_ray  > 0; not used where the environment is uniform: there are no samples then
    SkyLight(const Environment& environment, float samples_per_ray, std::uint64_t seed);

    /// What rays bring, without samples.
    [[nodiscard]] static SkyLight of_rays(const Environment& environment, float samples_per_ray);

    /// Radiance times w, averaged over a texel of 1.6 degrees or so.
    [[nodiscard]] const glm::vec3& along(glm::vec3 direction) const noexcept;

    /// Samples drawn together, stratified; each set alone is fair.
    ///
    /// pick   any number: which set
    /// count  at most samples_drawn; rounded up to a power of two
    [[nodiscard]] std::span<const Sample> samples(std::uint64_t pick, std::uint32_t count) const noexcept;

    [[nodiscard]] bool is_black() const noexcept { return texels_.empty(); }
    [[nodiscard]] bool has_samples() const noexcept { return !samples_.empty(); }

    static constexpr std::uint32_t samples_drawn = 1U << 16;

  private:
    static constexpr int texels_along = 128;

    std::vector<glm::vec3> texels_;  // of an octahedral map; one where the sky is uniform
    std::vector<Sample> samples_;
};

}  // namespace lightgrid
