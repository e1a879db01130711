#include "probes/error_report.h"

#include "core/parallel.h"
#include "core/sh.h"

#include <glm/gtc/constants.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

namespace lightgrid {
namespace {

constexpr int resamplings = 1000;
constexpr std::size_t worst_listed = 5;

/// Sums over the normals and colours of one point.
struct PointSums {
    double weight = 1;     // HeldOut::weights
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

double signed_root(double square) {
    return std::copysign(std::sqrt(std::abs(square)), square);
}

/// A part's square over the reference's, and its standard error by the spread of points (linearised).
struct Share {
    double square = 0;
    double error = 0;
};

/// index  of the i-th of as many points as there are
template <typename Index>
Share share_of(const std::vector<PointSums>& sums, double PointSums::*part, Index&& index) {
    double x = 0;
    double y = 0;
    double xx = 0;
    double xy = 0;
    double yy = 0;
    for (std::size_t i = 0; i < sums.size(); ++i) {
        const PointSums& point = sums[index(i)];
        const double numerator = point.weight * point.*part;
        const double denominator = point.weight * point.reference;
        x += numerator;
        y += denominator;
        xx += numerator * numerator;
        xy += numerator * denominator;
        yy += denominator * denominator;
    }
    if (!(y > 0)) return {};
    const double square = x / y;
    return {square, std::sqrt(std::max(xx - 2 * square * xy + square * square * yy, 0.0)) / y};
}

/// The root of a part's share with its interval: what the share of points that are drawn from these points is off
/// theirs, in its own standard errors, the share of these points is off that of all space. Squares beside lamps make
/// the one as lopsided as the other; percentiles of the resampled shares themselves would be too low. Source: Efron,
/// Tibshirani, "An Introduction to the Bootstrap", 1993, section 12.5 (bootstrap-t).
ErrorPart summarise(const std::vector<PointSums>& sums, double PointSums::*part) {
    const Share whole = share_of(sums, part, [](std::size_t i) { return i; });
    std::vector<double> off;
    off.reserve(resamplings);
    RandomStream random(0);
    for (int k = 0; k < resamplings; ++k) {
        const Share drawn = share_of(sums, part, [&](std::size_t) {
            return std::min(sums.size() - 1, static_cast<std::size_t>(random.next() * static_cast<float>(sums.size())));
        });
        off.push_back(drawn.error > 0 ? (drawn.square - whole.square) / drawn.error : 0.0);
    }
    std::sort(off.begin(), off.end());
    const double low = whole.square - off[resamplings * 975 / 1000 - 1] * whole.error;
    const double high = whole.square - off[resamplings * 25 / 1000] * whole.error;
    return {signed_root(whole.square), {signed_root(low), signed_root(high)}};
}

/// Of one point: what the volume has there against the reference, parts aside.
PointSums total_sums(const HeldOut& reference, std::size_t point, std::span<const glm::vec3> ours_sh) {
    const std::vector<glm::vec3>& normals = held_out_normals();
    PointSums sum;
    sum.weight = reference.weights[point];
    for (std::size_t k = 0; k < normals.size(); ++k) {
        const glm::dvec3 a = reference.a.irradiance[point * normals.size() + k].mean;
        const glm::dvec3 b = reference.b.irradiance[point * normals.size() + k].mean;
        const glm::dvec3 ours(irradiance_from_sh(ours_sh, normals[k]));
        sum.reference += component_sum(a * b);
        sum.total += component_sum((ours - a) * (ours - b));
    }
    return sum;
}

struct Weighted {
    double value = 0;
    double weight = 0;
};

/// The value that so large a share of the weight does not exceed. At least one value; sorts them.
double percentile(std::vector<Weighted>& values, double share) {
    std::sort(values.begin(), values.end(), [](const Weighted& x, const Weighted& y) { return x.value < y.value; });
    double all = 0;
    for (const Weighted& each : values) all += each.weight;
    double below = 0;
    for (const Weighted& each : values) {
        below += each.weight;
        if (below >= share * all) return each.value;
    }
    return values.back().value;
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

std::vector<double> measure_bands(const PathTracer& paths, const std::vector<glm::vec3>& points, int most_bands,
                                  std::uint32_t samples, const GatherRays& rays, std::uint64_t seed,
                                  PathCounts& counts) {
    GatherOptions options;
    options.bands = most_bands;
    options.samples = samples;
    options.normals = held_out_normals();
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

ErrorPart bias_of(const HeldOut& held_out) {
    if (!held_out.bias) return {};
    std::vector<PointSums> sums(held_out.points.size());
    for (std::size_t i = 0; i < held_out.bias->a.size(); ++i) {
        PointSums& sum = sums[i / held_out_normals().size()];
        sum.weight = held_out.weights[i / held_out_normals().size()];
        sum.reference += component_sum(held_out.a.irradiance[i].mean * held_out.b.irradiance[i].mean);
        sum.bias += component_sum(held_out.bias->a[i] * held_out.bias->b[i]);
    }
    return summarise(sums, &PointSums::bias);
}

ErrorPart measure_total(const Volume& volume, const HeldOut& reference, const SampleOptions& look_up) {
    if (reference.points.empty()) return {};
    const Sampler sampler(volume);
    std::vector<PointSums> sums(reference.points.size());
    for_each_index(sums.size(), [&](std::size_t i) {
        sums[i] = total_sums(reference, i, sampler.sample(reference.points[i], look_up).sh);
    });
    return summarise(sums, &PointSums::total);
}

ErrorReport measure_error(const Volume& volume, const HeldOut& reference, const Volume* rounded_from,
                          const SampleOptions& look_up) {
    ErrorReport report;
    report.points = reference.points.size();
    report.normals = held_out_normals().size();
    if (reference.points.empty()) return report;

    const Volume& unrounded = rounded_from != nullptr ? *rounded_from : volume;
    const Sampler sampler(volume);
    const Sampler unrounded_sampler(unrounded);
    const std::vector<glm::vec3>& normals = held_out_normals();
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
        PointSums& sum = sums[i] = total_sums(reference, i, interpolated.sh);
        for (std::size_t k = 0; k < normals.size(); ++k) {
            const glm::dvec3 a = reference.a.irradiance[i * normals.size() + k].mean;
            const glm::dvec3 b = reference.b.irradiance[i * normals.size() + k].mean;
            const glm::dvec3 truncated_a(irradiance_from_sh(sh_a, normals[k]));
            const glm::dvec3 truncated_b(irradiance_from_sh(sh_b, normals[k]));
            const glm::dvec3 ours(irradiance_from_sh(interpolated.sh, normals[k]));
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

    std::vector<std::pair<double PointSums::*, ErrorPart*>> parts{{&PointSums::total, &report.total},
                                                                  {&PointSums::without_bands, &report.without_bands},
                                                                  {&PointSums::noise, &report.noise},
                                                                  {&PointSums::bands, &report.bands},
                                                                  {&PointSums::interpolation, &report.interpolation},
                                                                  {&PointSums::storage, &report.storage},
                                                                  {&PointSums::cross, &report.cross}};
    if (reference.bias) parts.emplace_back(&PointSums::bias, &report.bias.emplace());
    for_each_index(parts.size(), [&](std::size_t i) { *parts[i].second = summarise(sums, parts[i].first); });

    std::vector<Weighted> sorted;
    for (std::size_t i = 0; i < report.points; ++i) sorted.push_back({mean_irradiance[i], reference.weights[i]});
    const double floor = 0.01 * percentile(sorted, 0.5);
    std::vector<Weighted> relative;
    for (std::size_t i = 0; i < report.points; ++i) {
        const double scale = std::max(mean_irradiance[i], floor);
        if (!(scale > 0)) continue;
        double square = 0;
        for (const double difference : differences[i]) {
            relative.push_back({difference / scale, reference.weights[i]});
            square += relative.back().value * relative.back().value;
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
