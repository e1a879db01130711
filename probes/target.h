#pragma once

#include "probes/gather.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string>

/// What a bake is to reach or may cost, and what that asks of its parts.
namespace lightgrid {

/// One of the three, or none: then `default_error` for all parts of the error but bands.
struct Target {
    std::optional<std::uint32_t> samples;  // gather rays per probe, and nothing else is adapted
    std::optional<double> error;           // relRMSE, all parts together
    std::optional<double> seconds;         // of wall clock
};
inline constexpr double default_error = 0.02;

/// Predictions aim below the error that is asked for, so that the measured interval does not reach it.
inline constexpr double aimed_share = 0.75;
[[nodiscard]] double aimed_error(const Target& target) noexcept;
/// Of what is aimed at: what bands and interpolation may leave, and noise then 0.6 of it (in squares).
inline constexpr double interpolation_share = 0.8;
/// Where the other parts leave more than the target, noise and bias are reduced to this share of them: 3 % of the whole.
inline constexpr double noise_share = 0.25;
/// Less noise than this is not worth its time where no target is given and interpolation misses it anyway. More than
/// `default_error` of noise is not left there either: what interpolation misses may be next to lamps alone.
inline constexpr double default_noise = 0.5 * default_error;

/// What interpolation may leave (relRMSE) where bands leave `bands_error`: the rest of the target, but no less than half
/// of what bands leave, which no finer grid would make smaller.
[[nodiscard]] double interpolation_goal(const Target& target, double bands_error) noexcept;
/// What noise at points in cells may leave where bands and interpolation together leave `rest`.
[[nodiscard]] double noise_goal(const Target& target, double rest) noexcept;

/// What bias may be, certainly, before something is done about it (relRMSE): a quarter of the target, in squares.
inline constexpr double bias_share = 0.5;
[[nodiscard]] double bias_goal(const Target& target, double rest) noexcept;

/// A share to two digits, as messages tell it: "1.7 %". Estimates below 0 are "0 %".
[[nodiscard]] std::string rounded_percent(double share);

/// Relative noise of gathers with GatherOptions' replicates, and how it falls as their rays grow.
struct NoiseLaw {
    double variance = 0;  // of irradiance over its mean square, at `samples`
    std::uint32_t samples = 1;
    double exponent = 1;  // variance falls as samples^-exponent: 1 for random rays, more where even ones do better
    double rays = 1;      // of each sample: its own, and those aimed at lights

    [[nodiscard]] double at(double other_samples) const noexcept;
};

/// Summed variance of irradiance over its summed square, over all directions of all points of a gather.
[[nodiscard]] double relative_variance(const Gather& gather) noexcept;

/// Relative variance with `samples` rays, from a few replicates of a pilot at up to 512 of the points, with random numbers
/// of its own: counts that are decided from the numbers that are then averaged would bias both mean and error.
[[nodiscard]] double variance_at(const PathTracer& paths, std::span<const glm::vec3> points, const GatherRays& rays,
                                 std::uint32_t samples, std::uint64_t seed, PathCounts& counts);

/// From two such pilots.
[[nodiscard]] NoiseLaw measure_noise(const PathTracer& paths, std::span<const glm::vec3> points, const GatherRays& rays,
                                     std::uint64_t seed, PathCounts& counts);

/// Rounded up to whole replicates of at least 4 rays; no more than `most`.
[[nodiscard]] std::uint32_t whole_replicates(double samples, std::uint32_t most) noexcept;

/// Fewest rays, in whole replicates of at least 4, whose noise is at most `goal` (relRMSE); never more than `most`.
[[nodiscard]] std::uint32_t samples_for(const NoiseLaw& law, double goal, std::uint32_t most) noexcept;

}  // namespace lightgrid
