#include "probes/error_report.h"

#include "core/parallel.h"
#include "core/sh.h"

#include <glm/gtc/constants.hpp>

#include <algorithm>
#include <cmath>

namespace lightgrid {
namespace {

constexpr std::size_t normals_per_point = 64;
constexpr int resamplings = 1000;
constexpr int most_tries_per_point = 64;
constexpr std::size_t worst_listed = 5;

/// Sums over the normals and colours of one point.
struct PointSums {
    double reference = 0;  // A B
    double total = 0;
    double without_bands = 0;
    double noise = 0;
    double bands = 0;
    double interpolation = 0;
    double storage = 0;
    double cross = 0;
    double bias = 0;
};

double component_sum(glm::dvec3 v) {
    return v.x + v.y + v.z;
}

std::vector<glm::vec3> even_normals() {
    std::vector<glm::vec3> normals;
    for (std::uint32_t i = 0; i < normals_per_point; ++i) normals.push_back(sphere_direction(sobol_point(i, 0)));
    return normals;
}

double signed_root(double square) {
    return std::copysign(std::sqrt(std::abs(square)), square);
}

/// sqrt(sum part / sum reference) with its interval over resampled points.
ErrorPart summarise(const std::vector<PointSums>& sums, double PointSums::*part) {
    const auto ratio = [&](auto&& index) {
        double numerator = 0;
        double denominator = 0;
        for (std::size_t i = 0; i < sums.size(); ++i) {
            const PointSums& point = sums[index(i)];
            numerator += point.*part;
            denominator += point.reference;
        }
        return denominator > 0 ? signed_root(numerator / denominator) : 0.0;
    };
    ErrorPart result;
    result.relrmse = ratio([](std::size_t i) { return i; });
    std::vector<double> resampled;
    resampled.reserve(resamplings);
    RandomStream random(0);
    for (int k = 0; k < resamplings; ++k) {
        resampled.push_back(ratio([&](std::size_t) {
            return std::min(sums.size() - 1, static_cast<std::size_t>(random.next() * static_cast<float>(sums.size())));
        }));
    }
    std::sort(resampled.begin(), resampled.end());
    result.interval = {resampled[resamplings * 25 / 1000], resampled[resamplings * 975 / 1000 - 1]};
    return result;
}

double percentile(std::vector<double>& values, double share) {
    const auto index = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + index, values.end());
    return values[static_cast<std::size_t>(index)];
}

}  // namespace

double mean_square_irradiance(std::span<const glm::vec3> sh) {
    double sum = 0;
    for (int l = 0; sh_size(l) < static_cast<int>(sh.size()); ++l) {
        const double lobe = cosine_lobe(l);
        for (int i = sh_size(l); i < sh_size(l + 1); ++i) {
            const glm::dvec3 value(sh[static_cast<std::size_t>(i)]);
            sum += lobe * lobe * component_sum(value * value);
        }
    }
    return sum / (4 * glm::pi<double>());
}

HeldOut trace_held_out(const Volume& volume, const PathTracer& paths, const LightEvidence& light,
                       const HeldOutOptions& options) {
    const Tracer& tracer = paths.tracer();
    const glm::dvec3 origin = tracer.scene().origin;
    std::vector<double> sizes;
    for (const Grid& grid : std::span(volume.grids).first(std::min(options.grids, volume.grids.size()))) {
        const glm::dvec3 size = glm::dvec3(grid.counts - 1) * grid.spacing;
        sizes.push_back(std::max(size.x * size.y * size.z, 1e-300));
    }
    const AliasTable pick(sizes);

    HeldOut held_out;
    if (pick.empty()) return held_out;
    std::vector<std::optional<glm::dvec3>> found(options.points);
    for_each_index(options.points, [&](std::size_t i) {
        RandomStream random(mix_bits(mix_bits(options.seed, 2), i));
        for (int attempt = 0; attempt < most_tries_per_point && !found[i]; ++attempt) {
            const Grid& grid = volume.grids[pick.sample(random.next())];
            const glm::vec2 xy = random.next2();
            const glm::dvec3 u(xy, random.next());
            const glm::dvec3 place = grid.origin + u * glm::dvec3(grid.counts - 1) * grid.spacing;
            const double clearance = 0.01 * std::min({grid.spacing.x, grid.spacing.y, grid.spacing.z});
            if (is_free(tracer, glm::vec3(place - origin), static_cast<float>(clearance), light)) found[i] = place;
        }
    });
    std::vector<glm::vec3> relative;
    for (const auto& place : found) {
        if (!place) continue;
        held_out.points.push_back(*place);
        relative.emplace_back(*place - origin);
    }
    if (relative.empty()) return held_out;

    GatherOptions gather_options;
    gather_options.bands = options.bands;
    gather_options.samples = options.samples;
    gather_options.normals = even_normals();
    gather_options.seed = mix_bits(options.seed, 3);
    held_out.a = gather(paths, relative, gather_options, &held_out.counts);
    gather_options.seed = mix_bits(options.seed, 4);
    held_out.b = gather(paths, relative, gather_options, &held_out.counts);
    return held_out;
}

std::vector<double> measure_bands(const PathTracer& paths, const std::vector<glm::vec3>& points, int most_bands,
                                  std::uint32_t samples, const GatherRays& rays, std::uint64_t seed,
                                  PathCounts& counts) {
    GatherOptions options;
    options.bands = most_bands;
    options.samples = samples;
    options.normals = even_normals();
    options.rays = rays;
    options.seed = mix_bits(seed, 0);
    const Gather a = gather(paths, points, options, &counts);
    options.seed = mix_bits(seed, 1);
    const Gather b = gather(paths, points, options, &counts);
    std::vector<double> squares(static_cast<std::size_t>(most_bands));
    double reference = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        std::vector<glm::vec3> sh_a;
        std::vector<glm::vec3> sh_b;
        for (const Estimate& estimate : a.sh(i)) sh_a.emplace_back(estimate.mean);
        for (const Estimate& estimate : b.sh(i)) sh_b.emplace_back(estimate.mean);
        for (std::size_t k = 0; k < options.normals.size(); ++k) {
            const std::size_t index = i * options.normals.size() + k;
            reference += component_sum(a.irradiance[index].mean * b.irradiance[index].mean);
            for (int bands = 1; bands <= most_bands; ++bands) {
                const auto left = [&](const std::vector<glm::vec3>& sh, const Estimate& exact) {
                    const auto kept = std::span(sh).first(static_cast<std::size_t>(sh_size(bands)));
                    return exact.mean - glm::dvec3(irradiance_from_sh(kept, options.normals[k]));
                };
                squares[static_cast<std::size_t>(bands) - 1] +=
                    component_sum(left(sh_a, a.irradiance[index]) * left(sh_b, b.irradiance[index]));
            }
        }
    }
    for (double& square : squares) square = reference > 0 ? std::sqrt(std::max(square / reference, 0.0)) : 0.0;
    return squares;
}

void trace_bias(HeldOut& held_out, const PathTracer& paths, const SurfaceCache& cache, const BiasOptions& options) {
    std::vector<glm::vec3> relative;
    for (const glm::dvec3& point : held_out.points) relative.emplace_back(point - paths.tracer().scene().origin);
    held_out.bias = measure_bias(paths, cache, relative, even_normals(), options);
    held_out.counts += held_out.bias->counts;
}

ErrorPart bias_of(const HeldOut& held_out) {
    if (!held_out.bias) return {};
    std::vector<PointSums> sums(held_out.points.size());
    for (std::size_t i = 0; i < held_out.bias->a.size(); ++i) {
        PointSums& sum = sums[i / normals_per_point];
        sum.reference += component_sum(held_out.a.irradiance[i].mean * held_out.b.irradiance[i].mean);
        sum.bias += component_sum(held_out.bias->a[i] * held_out.bias->b[i]);
    }
    return summarise(sums, &PointSums::bias);
}

ErrorReport measure_error(const Volume& volume, const HeldOut& reference, const Volume* rounded_from,
                          const SampleOptions& look_up) {
    ErrorReport report;
    report.points = reference.points.size();
    report.normals = normals_per_point;
    if (reference.points.empty()) return report;

    const Volume& unrounded = rounded_from != nullptr ? *rounded_from : volume;
    const Sampler sampler(volume);
    const Sampler unrounded_sampler(unrounded);
    const std::vector<glm::vec3> normals = even_normals();
    const std::size_t n = volume.sh_size();
    std::vector<PointSums> sums(report.points);
    std::vector<double> mean_irradiance(report.points);
    std::vector<std::vector<double>> differences(report.points);  // |dE| per normal and colour
    for_each_index(report.points, [&](std::size_t i) {
        const Sample interpolated = sampler.sample(reference.points[i], look_up);
        const Sample exact = unrounded_sampler.sample(reference.points[i], look_up);
        std::vector<glm::vec3> sh_a;
        std::vector<glm::vec3> sh_b;
        for (std::size_t k = 0; k < n; ++k) {
            sh_a.emplace_back(reference.a.sh(i)[k].mean);
            sh_b.emplace_back(reference.b.sh(i)[k].mean);
        }
        PointSums& sum = sums[i];
        for (std::size_t k = 0; k < normals.size(); ++k) {
            const glm::dvec3 a = reference.a.irradiance[i * normals.size() + k].mean;
            const glm::dvec3 b = reference.b.irradiance[i * normals.size() + k].mean;
            const glm::dvec3 truncated_a(irradiance_from_sh(sh_a, normals[k]));
            const glm::dvec3 truncated_b(irradiance_from_sh(sh_b, normals[k]));
            const glm::dvec3 ours(irradiance_from_sh(interpolated.sh, normals[k]));
            sum.reference += component_sum(a * b);
            sum.total += component_sum((ours - a) * (ours - b));
            const glm::dvec3 rounding = ours - glm::dvec3(irradiance_from_sh(exact.sh, normals[k]));
            sum.bands += component_sum((a - truncated_a) * (b - truncated_b));
            sum.cross +=
                component_sum((ours - truncated_a) * (truncated_b - b) + (ours - truncated_b) * (truncated_a - a));
            sum.storage += component_sum(rounding * rounding);
            sum.interpolation += component_sum((truncated_a - ours) * (truncated_b - ours));
            if (reference.bias) {
                const std::size_t index = i * normals.size() + k;
                sum.bias += component_sum(reference.bias->a[index] * reference.bias->b[index]);
            }
            const glm::dvec3 mean = 0.5 * (a + b);
            mean_irradiance[i] += component_sum(mean) / (3.0 * static_cast<double>(normals.size()));
            for (int c = 0; c < 3; ++c) differences[i].push_back(std::abs(ours[c] - mean[c]));
        }
        const Sampler::Corners corners = sampler.corners(reference.points[i], look_up);
        for (int c = 0; c < corners.count; ++c) {
            const double weight = corners.weights[c];
            sum.noise +=
                weight * weight * mean_square_irradiance(std::span(unrounded.errors).subspan(corners.slots[c] * n, n));
        }
        sum.noise *= static_cast<double>(normals.size());
        sum.without_bands = sum.interpolation;
        sum.interpolation -= sum.noise + sum.storage + sum.bias;
    });

    report.total = summarise(sums, &PointSums::total);
    report.without_bands = summarise(sums, &PointSums::without_bands);
    report.noise = summarise(sums, &PointSums::noise);
    report.bands = summarise(sums, &PointSums::bands);
    report.interpolation = summarise(sums, &PointSums::interpolation);
    report.storage = summarise(sums, &PointSums::storage);
    report.cross = summarise(sums, &PointSums::cross);
    if (reference.bias) report.bias = summarise(sums, &PointSums::bias);

    std::vector<double> sorted = mean_irradiance;
    const double floor = 0.01 * percentile(sorted, 0.5);
    std::vector<double> relative;
    for (std::size_t i = 0; i < report.points; ++i) {
        const double scale = std::max(mean_irradiance[i], floor);
        if (!(scale > 0)) continue;
        double square = 0;
        for (const double difference : differences[i]) {
            relative.push_back(difference / scale);
            square += relative.back() * relative.back();
        }
        report.worst.push_back({reference.points[i], std::sqrt(square / static_cast<double>(differences[i].size()))});
    }
    std::sort(report.worst.begin(), report.worst.end(),
              [](const auto& x, const auto& y) { return x.relative_error > y.relative_error; });
    if (report.worst.size() > worst_listed) report.worst.resize(worst_listed);
    if (!relative.empty()) {
        report.p50 = percentile(relative, 0.50);
        report.p95 = percentile(relative, 0.95);
        report.p99 = percentile(relative, 0.99);
    }
    return report;
}

}  // namespace lightgrid
