#include "probes/target.h"

#include "core/sampling.h"
#include "core/sh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace lightgrid {
namespace {

constexpr std::size_t pilot_points = 512;
/// Replicates pool over all points, so that few will do.
constexpr std::uint32_t pilot_replicates = 4;
constexpr std::uint32_t few_samples = 512;
constexpr std::uint32_t more_samples = 2048;
/// Evenly spread rays do no better than this where light has edges.
constexpr double steepest = 1.5;
constexpr std::uint32_t least_rays_per_replicate = 4;

}  // namespace

double aimed_error(const Target& target) noexcept {
    return target.seconds ? 0.0 : aimed_share * target.error.value_or(default_error);
}

double interpolation_goal(const Target& target, double bands_error) noexcept {
    const double aimed = interpolation_share * aimed_error(target);
    const double left = aimed * aimed - bands_error * bands_error;
    return std::max({std::sqrt(std::max(left, 0.0)), 0.5 * bands_error, 0.25 * aimed});
}

double noise_goal(const Target& target, double rest) noexcept {
    const double aimed = aimed_error(target);
    const bool is_asked = target.error || target.seconds;
    const double beside_rest =
        is_asked ? noise_share * rest : std::clamp(noise_share * rest, default_noise, default_error);
    return std::max(std::sqrt(std::max(aimed * aimed - rest * rest, 0.0)), beside_rest);
}

double bias_goal(const Target& target, double rest) noexcept {
    return std::max(bias_share * target.error.value_or(default_error), noise_share * rest);
}

std::string rounded_percent(double share) {
    return fmt::format("{:.2g} %", 100 * std::max(share, 0.0));
}

double NoiseLaw::at(double other_samples) const noexcept {
    return variance * std::pow(static_cast<double>(samples) / other_samples, exponent);
}

double relative_variance(const Gather& gather) noexcept {
    double variance = 0;
    double energy = 0;
    for (std::size_t i = 0; i < gather.coefficients.size(); ++i) {
        const int k = static_cast<int>(i) % sh_size(gather.bands);
        const double lobe = cosine_lobe(static_cast<int>(std::sqrt(k + 0.5)));
        const Estimate& estimate = gather.coefficients[i];
        variance += lobe * lobe * glm::dot(estimate.error, estimate.error);
        energy += lobe * lobe * glm::dot(estimate.mean, estimate.mean);
    }
    return energy > 0 ? variance / energy : 0.0;
}

double variance_at(const PathTracer& paths, std::span<const glm::vec3> points, const GatherRays& rays,
                   std::uint32_t samples, std::uint64_t seed, PathCounts& counts) {
    const std::uint32_t replicates = GatherOptions{}.replicates;
    GatherOptions options;
    options.replicates = pilot_replicates;
    options.samples = samples / replicates * pilot_replicates;
    options.seed = mix_bits(seed, samples);
    options.rays = rays;
    return relative_variance(gather(paths, spread_over(points, pilot_points), options, &counts)) * pilot_replicates /
           replicates;
}

NoiseLaw measure_noise(const PathTracer& paths, std::span<const glm::vec3> points, const GatherRays& rays,
                       std::uint64_t seed, PathCounts& counts) {
    PathCounts counted;
    const double few = variance_at(paths, points, rays, few_samples, seed, counted);
    const double more = variance_at(paths, points, rays, more_samples, seed, counted);
    counts += counted;
    NoiseLaw law{more, more_samples, 1};
    const double samples = static_cast<double>(std::min(points.size(), pilot_points)) * (few_samples + more_samples) *
                           pilot_replicates / GatherOptions{}.replicates;
    if (samples > 0) law.rays = static_cast<double>(counted.rays + counted.shadow_rays) / samples;
    if (more > 0) {
        law.exponent = std::clamp(std::log(few / more) / std::log(double{more_samples} / few_samples), 1.0, steepest);
    }
    return law;
}

std::uint32_t whole_replicates(double samples, std::uint32_t most) noexcept {
    const std::uint32_t replicates = GatherOptions{}.replicates;
    const double least = replicates * least_rays_per_replicate;
    const double wanted = std::clamp(samples, least, std::max(least, static_cast<double>(most)));
    return static_cast<std::uint32_t>(std::ceil(wanted / replicates)) * replicates;
}

std::uint32_t samples_for(const NoiseLaw& law, double goal, std::uint32_t most) noexcept {
    if (!(law.variance > 0)) return whole_replicates(0, most);
    if (!(goal > 0)) return whole_replicates(most, most);
    return whole_replicates(law.samples * std::pow(law.variance / (goal * goal), 1 / law.exponent), most);
}

}  // namespace lightgrid
