#include "probes/gather.h"

#include "core/parallel.h"
#include "core/sh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>

namespace lightgrid {
namespace {

/// Points that are worth a task each; the replicates of fewer are spread over tasks, too.
constexpr std::size_t many_points = 1024;

}  // namespace

bool Gather::is_black() const noexcept {
    return std::all_of(coefficients.begin(), coefficients.end(),
                       [](const Estimate& estimate) { return estimate.mean == glm::dvec3(0); });
}

GatherSums::GatherSums(const PathTracer& paths, std::vector<glm::vec3> points, GatherOptions options)
    : paths_(&paths),
      points_(std::move(points)),
      options_(std::move(options)),
      directions_(even_directions(options_.samples_per_replicate())) {
    const auto coefficients = static_cast<std::size_t>(sh_size(options_.bands));
    values_per_point_ = coefficients + options_.normals_per_point() + axis_normals.size();
    moments_.resize(points_.size() * values_per_point_);
    punctual_.resize(moments_.size());
    if (!paths.estimators().lights) return;
    std::vector<PathCounts> counts(points_.size());
    for_each_index(points_.size(), [&](std::size_t i) {
        std::vector<LightSample> light;
        paths_->gather_punctual(points_[i], light, counts[i]);
        project(i, light, std::span(punctual_).subspan(i * values_per_point_, values_per_point_));
    });
    for (const PathCounts& count : counts) counts_ += count;
}

void GatherSums::project(std::size_t point, std::span<const LightSample> light, std::span<glm::dvec3> values) const {
    const auto coefficients = static_cast<std::size_t>(sh_size(options_.bands));
    const std::size_t normals = options_.normals_per_point();
    const glm::vec3* normal = options_.normals.data() + (options_.one_normal_each ? point : 0);
    std::array<float, static_cast<std::size_t>(sh_size(max_sh_bands))> storage;
    const std::span basis(storage.data(), coefficients);
    for (const LightSample& sample : light) {
        const glm::dvec3 radiance(sample.radiance);
        sh_basis(options_.bands, sample.direction, basis);
        for (std::size_t i = 0; i < coefficients; ++i) values[i] += radiance * static_cast<double>(basis[i]);
        for (std::size_t k = 0; k < normals; ++k) {
            const float cosine = glm::dot(normal[k], sample.direction);
            if (cosine > 0) values[coefficients + k] += radiance * static_cast<double>(cosine);
        }
    }
    std::vector<glm::vec3> sh(coefficients);
    for (std::size_t i = 0; i < coefficients; ++i) sh[i] = glm::vec3(values[i]);
    for (std::size_t axis = 0; axis < axis_normals.size(); ++axis) {
        values[coefficients + normals + axis] = glm::dvec3(irradiance_from_sh(sh, axis_normals[axis]));
    }
}

EmitterCut GatherSums::cut_at(std::size_t point) const {
    return paths_->emitters().open({points_[point]}, options_.samples);
}

void GatherSums::trace(std::size_t point, std::uint32_t replicate, const EmitterCut& cut, std::span<glm::dvec3> values,
                       PathCounts& counts) const {
    std::vector<LightSample> light;
    const std::uint64_t key = mix_bits(mix_bits(mix_bits(options_.seed, 1), point), replicate);
    paths_->gather({points_[point], {}, &cut}, key, directions_, light, counts, options_.rays);
    project(point, light, values);
}

void GatherSums::add(std::size_t point, std::uint32_t replicate, std::span<const glm::dvec3> values) {
    for (std::size_t i = 0; i < values_per_point_; ++i) {
        Moments& moments = moments_[point * values_per_point_ + i];
        if (replicate == 0) moments.first = values[i];
        const glm::dvec3 deviation = values[i] - moments.first;
        moments.sum += deviation;
        moments.squares += deviation * deviation;
    }
}

void GatherSums::add_replicates(std::uint32_t count, const std::function<void(std::size_t)>& done) {
    std::size_t gathered = 0;
    std::mutex mutex;
    const auto tell = [&](const PathCounts& counts) {
        const std::lock_guard lock(mutex);
        counts_ += counts;
        if (done) done(++gathered);
    };
    if (points_.size() >= many_points) {
        for_each_index(points_.size(), [&](std::size_t point) {
            const EmitterCut cut = cut_at(point);
            std::vector<glm::dvec3> values(values_per_point_);
            for (std::uint32_t r = replicates_; r < replicates_ + count; ++r) {
                std::fill(values.begin(), values.end(), glm::dvec3(0));
                PathCounts counts;
                trace(point, r, cut, values, counts);
                add(point, r, values);
                tell(counts);
            }
        });
    } else {
        std::vector<EmitterCut> cuts(points_.size());
        for_each_index(points_.size(), [&](std::size_t point) { cuts[point] = cut_at(point); });
        std::vector<glm::dvec3> values(count * moments_.size());
        const auto of = [&](std::size_t task) {
            return std::span(values).subspan(task * values_per_point_, values_per_point_);
        };
        for_each_index(points_.size() * count, [&](std::size_t task) {
            PathCounts counts;
            const std::size_t point = task / count;
            trace(point, replicates_ + static_cast<std::uint32_t>(task % count), cuts[point], of(task), counts);
            tell(counts);
        });
        for (std::size_t task = 0; task < points_.size() * count; ++task) {
            add(task / count, replicates_ + static_cast<std::uint32_t>(task % count), of(task));
        }
    }
    replicates_ += count;
}

Gather GatherSums::result() const {
    const auto coefficients = static_cast<std::size_t>(sh_size(options_.bands));
    Gather gather;
    gather.bands = options_.bands;
    gather.normals = options_.normals_per_point();
    gather.coefficients.reserve(points_.size() * coefficients);
    gather.irradiance.reserve(points_.size() * gather.normals);
    gather.axis_irradiance.reserve(points_.size() * axis_normals.size());
    const double n = std::max(1U, replicates_);
    const auto estimate = [&](std::size_t i) {
        const Moments& moments = moments_[i];
        Estimate result;
        result.mean = punctual_[i] + moments.first + moments.sum / n;
        if (n > 1) {
            const glm::dvec3 variance = (moments.squares - moments.sum * moments.sum / n) / (n - 1);
            result.error = glm::sqrt(glm::max(variance, 0.0) / n);
        }
        return result;
    };
    for (std::size_t point = 0; point < points_.size(); ++point) {
        std::size_t i = point * values_per_point_;
        for (std::size_t k = 0; k < coefficients; ++k) gather.coefficients.push_back(estimate(i++));
        for (std::size_t k = 0; k < gather.normals; ++k) gather.irradiance.push_back(estimate(i++));
        for (std::size_t k = 0; k < axis_normals.size(); ++k) gather.axis_irradiance.push_back(estimate(i++));
    }
    return gather;
}

Gather gather(const PathTracer& paths, std::vector<glm::vec3> points, const GatherOptions& options,
              PathCounts* counts) {
    GatherSums sums(paths, std::move(points), options);
    sums.add_replicates(options.replicates);
    if (counts != nullptr) *counts += sums.counts();
    return sums.result();
}

void store(std::span<const Estimate> coefficients, std::span<const Estimate> axis_irradiance, std::size_t slot,
           Volume& volume) {
    const std::size_t n = volume.sh_size();
    for (std::size_t k = 0; k < std::min(n, coefficients.size()); ++k) {
        volume.coefficients[slot * n + k] = glm::vec3(coefficients[k].mean);
        volume.errors[slot * n + k] = glm::vec3(coefficients[k].error);
    }
    for (std::size_t k = 0; k < axis_normals.size(); ++k) {
        volume.axis_errors[slot * axis_normals.size() + k] = glm::vec3(axis_irradiance[k].error);
    }
}

void store(const Gather& gather, std::span<const std::size_t> slots, Volume& volume) {
    const std::span<const Estimate> axes = gather.axis_irradiance;
    for (std::size_t i = 0; i < slots.size(); ++i) {
        store(gather.sh(i), axes.subspan(i * axis_normals.size(), axis_normals.size()), slots[i], volume);
    }
}

}  // namespace lightgrid
