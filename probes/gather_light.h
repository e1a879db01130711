#pragma once

#include "probes/gather.h"
#include "probes/kept_transport.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

/// What light brings to probes whose gather has been traced.
namespace lightgrid {

inline constexpr std::uint32_t gather_replicates = GatherOptions{}.replicates;

/// Of the random numbers of one replicate of a point's gather.
[[nodiscard]] std::uint64_t replicate_key(std::uint64_t seed, std::size_t point, std::uint32_t replicate) noexcept;
/// How a replicate turns its even directions.
[[nodiscard]] glm::mat3 replicate_rotation(std::uint64_t key) noexcept;

/// A point's light: coefficients, and the irradiance of these along the six axes, replicate by replicate.
class PointLight {
  public:
    explicit PointLight(int bands);

    [[nodiscard]] static std::size_t values(int bands);

    void add(std::uint32_t replicate, glm::vec3 direction, glm::dvec3 radiance);
    void set(std::uint32_t replicate, std::span<const glm::vec3> coefficients);

    /// Mean and standard error over the replicates.
    [[nodiscard]] std::vector<Estimate> estimates();

  private:
    int bands_;
    std::size_t coefficients_;
    std::vector<glm::dvec3> values_;
};

/// What there is to be seen from probes.
struct LightSeen {
    std::span<const glm::vec3> reflected;          // radiance, by patch; empty: black
    std::span<const glm::vec3> straight;           // by source: a factor of what comes straight from it but for the sky
    std::function<glm::vec3(glm::vec3)> sky = {};  // radiance that rays in a direction meet; empty: black
};

/// Rays are summed up as they were before they were turned, for which their basis functions are known, and the sum is
/// turned.
class GatherLight {
  public:
    /// Keeps references.
    GatherLight(const KeptGather& gather, const LightSeen& seen, int bands);

    /// Estimates by value (KeptGather::aimed).
    ///
    /// other  light that the gather does not know of, likewise; or nothing
    [[nodiscard]] std::vector<Estimate> at(std::size_t point, std::span<const Estimate> other = {}) const;

  private:
    [[nodiscard]] std::vector<glm::vec3> from_rays(std::size_t point, std::uint32_t replicate) const;
    /// ray  that went there, as `rotation` turned it
    [[nodiscard]] glm::vec3 light_at(std::uint32_t place, std::uint32_t ray, const glm::mat3& rotation) const;

    const KeptGather& gather_;
    const LightSeen& seen_;
    int bands_;
    std::size_t coefficients_;
    std::vector<glm::vec3> even_;  // directions
    std::vector<double> basis_;    // of these
};

}  // namespace lightgrid
