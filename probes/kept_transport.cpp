#include "probes/kept_transport.h"

#include "core/hash.h"
#include "core/parallel.h"
#include "core/sampling.h"
#include "core/sh.h"
#include "probes/bake.h"

#include <glm/gtc/constants.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <utility>

namespace lightgrid {
namespace {

/// What the random numbers are for: each has a stream of its own.
enum Stream : std::uint64_t { turning, others };

constexpr std::uint32_t replicates = GatherOptions{}.replicates;

std::uint64_t replicate_key(std::uint64_t seed, std::size_t point, std::uint32_t replicate) {
    return mix_bits(mix_bits(mix_bits(seed, 1), point), replicate);
}
glm::mat3 rotation_of(std::uint64_t key) {
    return random_rotation(mix_bits(key, turning));
}

std::vector<glm::vec3> points_of(const KeptGather& gather, const Volume& volume, const Scene& scene) {
    std::vector<glm::vec3> points;
    points.reserve(gather.slots.size());
    for (const std::uint64_t slot : gather.slots) points.emplace_back(gather_position(volume, slot) - scene.origin);
    return points;
}

/// A point's light: coefficients, and the irradiance of these along the six axes, replicate by replicate.
class PointLight {
  public:
    explicit PointLight(int bands)
        : bands_(bands),
          coefficients_(static_cast<std::size_t>(sh_size(bands))),
          values_(replicates * values(bands), glm::dvec3(0)) {}

    [[nodiscard]] static std::size_t values(int bands) {
        return static_cast<std::size_t>(sh_size(bands)) + axis_normals.size();
    }

    void add(std::uint32_t replicate, glm::vec3 direction, glm::dvec3 radiance) {
        std::array<float, static_cast<std::size_t>(sh_size(max_sh_bands))> basis;
        sh_basis(bands_, direction, std::span(basis.data(), coefficients_));
        glm::dvec3* value = values_.data() + replicate * values(bands_);
        for (std::size_t i = 0; i < coefficients_; ++i) value[i] += radiance * static_cast<double>(basis[i]);
    }
    void set(std::uint32_t replicate, std::span<const glm::vec3> coefficients) {
        std::copy(coefficients.begin(), coefficients.end(),
                  values_.begin() + static_cast<std::ptrdiff_t>(replicate * values(bands_)));
    }

    /// Mean and standard error over the replicates.
    [[nodiscard]] std::vector<Estimate> estimates() {
        const std::size_t n = values(bands_);
        std::vector<glm::vec3> sh(coefficients_);
        for (std::uint32_t r = 0; r < replicates; ++r) {
            for (std::size_t i = 0; i < coefficients_; ++i) sh[i] = glm::vec3(values_[r * n + i]);
            for (std::size_t axis = 0; axis < axis_normals.size(); ++axis) {
                values_[r * n + coefficients_ + axis] = glm::dvec3(irradiance_from_sh(sh, axis_normals[axis]));
            }
        }
        std::vector<Estimate> result(n);
        for (std::size_t i = 0; i < n; ++i) {
            // From the first: no cancellation where all agree.
            glm::dvec3 sum(0);
            glm::dvec3 squares(0);
            for (std::uint32_t r = 1; r < replicates; ++r) {
                const glm::dvec3 deviation = values_[r * n + i] - values_[i];
                sum += deviation;
                squares += deviation * deviation;
            }
            result[i].mean = values_[i] + sum / double{replicates};
            const glm::dvec3 variance = (squares - sum * sum / double{replicates}) / double{replicates - 1};
            result[i].error = glm::sqrt(glm::max(variance, 0.0) / double{replicates});
        }
        return result;
    }

  private:
    int bands_;
    std::size_t coefficients_;
    std::vector<glm::dvec3> values_;
};

/// Light by samples aimed at sources, at one point.
///
/// rays_per_sample  of emitters, as PathTracer::gather_lights
/// out              by source
void aim(const PathTracer& paths, glm::vec3 point, std::size_t index, std::uint64_t seed, std::uint32_t count,
         float rays_per_sample, const SkyLight& sky, std::vector<PointLight>& out, PathCounts& counts) {
    std::vector<LightSample> light;
    for (std::uint32_t r = 0; r < replicates; ++r) {
        light.clear();
        paths.gather_lights({point}, replicate_key(seed, index, r), count, rays_per_sample, sky, count, light, counts);
        for (const LightSample& sample : light) {
            out[sample.source].add(r, sample.direction, glm::dvec3(sample.radiance));
        }
    }
    light.clear();
    paths.gather_punctual(point, light, counts);
    for (const LightSample& sample : light) {
        for (std::uint32_t r = 0; r < replicates; ++r) {
            out[sample.source].add(r, sample.direction, glm::dvec3(sample.radiance));
        }
    }
}

std::vector<KeptEstimate> kept(const std::vector<Estimate>& estimates) {
    std::vector<KeptEstimate> result;
    result.reserve(estimates.size());
    for (const Estimate& e : estimates) result.push_back({glm::vec3(e.mean), glm::vec3(e.error)});
    return result;
}

/// Traces the gathers of one batch.
class GatherTracer {
  public:
    GatherTracer(const PathTracer& paths, const SurfacePatches& patches, const SkyLight& sky, int bands,
                 const std::function<void(std::size_t)>& done)
        : paths_(paths), patches_(patches), sky_(sky), bands_(bands), done_(done) {}

    KeptGather trace(const Batch& batch, std::uint64_t seed, PathCounts& counts) {
        const std::size_t sources = paths_.sources().count;
        const std::size_t values = PointLight::values(bands_);
        KeptGather gather;
        gather.slots.assign(batch.slots.begin(), batch.slots.end());
        gather.rays = (batch.samples + replicates - 1) / replicates;
        gather.seed = seed;
        gather.landed.assign(batch.points.size() * replicates * gather.rays, Transport::none);
        gather.aimed.assign(sources, std::vector<KeptEstimate>(batch.points.size() * values));
        const std::vector<glm::vec3> even = even_directions(gather.rays);
        std::vector<std::vector<RayEnd>> ends(batch.points.size() * replicates);
        std::vector<std::vector<Missing>> missing(ends.size());
        std::vector<PathCounts> counted(batch.points.size());
        for_each_index(batch.points.size(), [&](std::size_t point) {
            std::vector<PointLight> aimed(sources, PointLight(bands_));
            aim(paths_, batch.points[point], point, seed, gather.rays, 1, sky_, aimed, counted[point]);
            for (std::size_t s = 0; s < sources; ++s) {
                const std::vector<KeptEstimate> estimates = kept(aimed[s].estimates());
                std::copy(estimates.begin(), estimates.end(),
                          gather.aimed[s].begin() + static_cast<std::ptrdiff_t>(point * values));
            }
            for (std::uint32_t r = 0; r < replicates; ++r) {
                const std::size_t set = point * replicates + r;
                follow(batch.points[point], rotation_of(replicate_key(seed, point, r)), even,
                       std::span(gather.landed).subspan(set * gather.rays, gather.rays), ends[set], missing[set],
                       counted[point]);
            }
            if (!done_) return;
            const std::lock_guard lock(mutex_);
            done_(++gathered_);
        });
        std::vector<Missing>& all_missing = missing_.emplace_back();
        for (std::size_t set = 0; set < ends.size(); ++set) {
            gather.first_end.push_back(gather.ends.size());
            for (Missing& m : missing[set]) {
                m.index += m.is_end ? gather.ends.size() : set * gather.rays;
                all_missing.push_back(m);
            }
            gather.ends.insert(gather.ends.end(), ends[set].begin(), ends[set].end());
        }
        gather.first_end.push_back(gather.ends.size());
        for (const PathCounts& c : counted) counts += c;
        return gather;
    }

    /// Patches for what rays met where none was known, and tells the rays. Gathers as they were traced.
    void add_places(Surfaces& surfaces, const CacheOptions& options, std::vector<KeptGather>& gathers,
                    PathCounts& counts) const {
        std::vector<SeenPlace> places;
        for (const std::vector<Missing>& batch : missing_) {
            for (const Missing& m : batch) places.push_back(m.place);
        }
        surfaces.made.counts = {};
        const std::vector<std::uint32_t> patches = lightgrid::add_places(paths_, places, options, surfaces);
        counts += surfaces.made.counts;
        auto patch = patches.begin();
        for (std::size_t b = 0; b < gathers.size(); ++b) {
            for (const Missing& m : missing_[b]) {
                (m.is_end ? gathers[b].ends[m.index].at : gathers[b].landed[m.index]) = *patch++;
            }
        }
    }

  private:
    /// A ray met a place that no patch is known for.
    struct Missing {
        SeenPlace place;
        std::size_t index = 0;  // of KeptGather::landed, or ends
        bool is_end = false;
    };

    void follow(glm::vec3 point, const glm::mat3& rotation, std::span<const glm::vec3> even,
                std::span<std::uint32_t> landed, std::vector<RayEnd>& ends, std::vector<Missing>& missing,
                PathCounts& counts) const {
        std::vector<Met> met;
        std::vector<glm::vec3> light(paths_.sources().count);
        for (std::uint32_t i = 0; i < even.size(); ++i) {
            const glm::vec3 direction = rotation * even[i];
            met.clear();
            std::fill(light.begin(), light.end(), glm::vec3(0));
            paths_.look_along({point, {}}, point, direction, 1, SkyLight(), light, met, counts);
            for (const Met& m : met) {
                const std::uint32_t at =
                    m.hit.found() ? patches_.find(paths_.tracer(), {m.hit, point, direction}, counts.shadow_rays)
                                  : Transport::sky;
                const bool is_end = m.share != glm::vec3(1);
                if (at == SurfacePatches::none) {
                    missing.push_back({{m.hit, point, direction}, is_end ? ends.size() : i, is_end});
                }
                if (is_end) {
                    ends.push_back({i, at, m.share});
                } else {
                    landed[i] = at;
                }
            }
            for (std::uint32_t s = 0; s < light.size(); ++s) {
                if (light[s] != glm::vec3(0)) ends.push_back({i, RayEnd::emitter + s, light[s]});
            }
        }
    }

    const PathTracer& paths_;
    const SurfacePatches& patches_;
    const SkyLight& sky_;
    int bands_;
    const std::function<void(std::size_t)>& done_;
    std::mutex mutex_;                           // of the next
    std::size_t gathered_ = 0;                   // points
    std::vector<std::vector<Missing>> missing_;  // by batch
};

/// What light brings to the points of a gather. Rays are summed up as they were before they were turned, for which their
/// basis functions are known, and the sum is turned.
class GatherLight {
  public:
    GatherLight(const KeptGather& gather, std::span<const glm::vec3> radiance, const LightChange& change,
                const SkyLight& sky, int bands)
        : gather_(gather),
          radiance_(radiance),
          change_(change),
          sky_(sky),
          bands_(bands),
          coefficients_(static_cast<std::size_t>(sh_size(bands))),
          even_(even_directions(gather.rays)),
          basis_(even_.size() * coefficients_) {
        for (std::size_t i = 0; i < even_.size(); ++i) {
            sh_basis(bands, glm::dvec3(even_[i]), std::span(basis_).subspan(i * coefficients_, coefficients_));
        }
    }

    /// other  light of sources that had to be traced: estimates by value
    [[nodiscard]] std::vector<Estimate> at(std::size_t point, std::span<const Estimate> other) const {
        PointLight light(bands_);
        for (std::uint32_t r = 0; r < replicates; ++r) light.set(r, from_rays(point, r));
        std::vector<Estimate> result = light.estimates();
        const auto add = [&](std::size_t i, glm::dvec3 mean, glm::dvec3 error) {
            result[i].mean += mean;
            result[i].error = glm::sqrt(result[i].error * result[i].error + error * error);
        };
        for (std::size_t s = 0; s < gather_.aimed.size(); ++s) {
            if (change_.factor[s] == glm::vec3(0)) continue;
            const glm::dvec3 factor(change_.factor[s]);
            for (std::size_t i = 0; i < result.size(); ++i) {
                const KeptEstimate& aimed = gather_.aimed[s][point * result.size() + i];
                add(i, factor * glm::dvec3(aimed.mean), factor * glm::dvec3(aimed.error));
            }
        }
        for (std::size_t i = 0; i < other.size(); ++i) add(i, other[i].mean, other[i].error);
        return result;
    }

  private:
    [[nodiscard]] std::vector<glm::vec3> from_rays(std::size_t point, std::uint32_t replicate) const {
        const std::size_t set = point * replicates + replicate;
        const glm::mat3 rotation = rotation_of(replicate_key(gather_.seed, point, replicate));
        const auto light_at = [&](std::uint32_t place, std::uint32_t ray) {
            if (place == Transport::sky) return sky_.along(rotation * even_[ray]);
            return place < RayEnd::emitter ? radiance_[place] : change_.factor[place - RayEnd::emitter];
        };
        std::vector<glm::dvec3> sum(coefficients_, glm::dvec3(0));
        const auto add = [&](std::uint32_t ray, glm::vec3 light) {
            const glm::dvec3 radiance(light);
            const double* basis = basis_.data() + ray * coefficients_;
            for (std::size_t i = 0; i < coefficients_; ++i) sum[i] += radiance * basis[i];
        };
        const std::uint32_t* landed = gather_.landed.data() + set * gather_.rays;
        for (std::uint32_t i = 0; i < gather_.rays; ++i) {
            if (landed[i] != Transport::none) add(i, light_at(landed[i], i));
        }
        for (std::uint64_t k = gather_.first_end[set]; k < gather_.first_end[set + 1]; ++k) {
            const RayEnd& end = gather_.ends[k];
            if (end.at != Transport::none) add(end.ray, end.share * light_at(end.at, end.ray));
        }
        std::vector<glm::vec3> result;
        const double share = 4 * glm::pi<double>() / gather_.rays;
        for (const glm::dvec3& value : sum) result.emplace_back(share * value);
        ShRotation(bands_, glm::dmat3(rotation)).apply(result);
        return result;
    }

    const KeptGather& gather_;
    std::span<const glm::vec3> radiance_;
    const LightChange& change_;
    const SkyLight& sky_;
    int bands_;
    std::size_t coefficients_;
    std::vector<glm::vec3> even_;  // directions
    std::vector<double> basis_;    // of these
};

}  // namespace

KeptTransport trace_transport(const PathTracer& paths, const BakePlan& plan, Surfaces surfaces,
                              const CacheOptions& options, std::uint64_t seed, PathCounts& counts,
                              const std::function<void(std::size_t)>& done) {
    const Scene& scene = paths.tracer().scene();
    KeptTransport kept;
    kept.light = light_of(scene, paths.environment(), paths.sources());
    kept.options = options;
    kept.volume = plan.volume;
    kept.samples = plan.samples;
    kept.placement = plan.placement;
    kept.why_spacing = plan.why_spacing;
    kept.why_samples = plan.why_samples;
    GatherTracer tracer(paths, surfaces.patches, surfaces.sky, plan.volume.bands, done);
    for (std::size_t b = 0; b < plan.batches.size(); ++b) {
        kept.gathers.push_back(tracer.trace(plan.batches[b], b == 0 ? seed : mix_bits(mix_bits(seed, 13), b), counts));
    }
    tracer.add_places(surfaces, options, kept.gathers, counts);
    kept.made = surfaces.made;
    kept.transport = std::move(surfaces.transport);
    kept.places = std::move(surfaces.places);
    for (const std::vector<glm::dvec3>& source : surfaces.direct) {
        kept.direct.emplace_back(source.begin(), source.end());
    }
    return kept;
}

KeptLight light_probes(const KeptTransport& kept, const Tracer& tracer, const Environment& environment,
                       Volume& volume) {
    const LightChange change = compare_light(kept.light, tracer.scene(), environment);
    KeptLight result;
    result.made = kept.made;
    result.made.counts = {};
    result.traced = change.any_other;
    PathCounts& counts = result.made.counts;
    std::optional<PathTracer> others;
    if (change.any_other) others.emplace(tracer, environment, change.others);
    const SkyLight sky = change.sky_is_new ? sky_of_cache(environment, kept.options) : sky_of_rays(environment);

    std::vector<glm::dvec3> direct(kept.transport.patches());
    if (others) {
        direct = trace_direct(*others, kept.transport, kept.places, change.sky_is_new ? sky : SkyLight(), kept.options,
                              counts);
    }
    for (std::size_t s = 0; s < kept.direct.size(); ++s) {
        const glm::dvec3 factor(change.factor[s]);
        if (factor == glm::dvec3(0)) continue;
        for (std::size_t patch = 0; patch < direct.size(); ++patch) {
            direct[patch] += factor * glm::dvec3(kept.direct[s][patch]);
        }
    }
    const TransportSolution solution = solve(kept.transport, direct, kept.options.accuracy);
    result.made.sweeps = solution.sweeps;
    result.made.residual = solution.residual;
    result.radiance.assign(solution.light.begin(), solution.light.end());

    for (const KeptGather& gather : kept.gathers) {
        const std::vector<glm::vec3> points =
            others ? points_of(gather, volume, tracer.scene()) : std::vector<glm::vec3>();
        const GatherLight light(gather, result.radiance, change, sky, volume.bands);
        std::vector<PathCounts> counted(gather.slots.size());
        for_each_index(gather.slots.size(), [&](std::size_t point) {
            std::vector<Estimate> other;
            if (others) {
                std::vector<PointLight> aimed(1, PointLight(volume.bands));
                aim(*others, points[point], point, mix_bits(gather.seed, Stream::others), gather.rays, 0, sky, aimed,
                    counted[point]);
                other = aimed[0].estimates();
            }
            const std::vector<Estimate> estimates = light.at(point, other);
            store(std::span(estimates).first(volume.sh_size()), std::span(estimates).subspan(volume.sh_size()),
                  gather.slots[point], volume);
        });
        for (const PathCounts& c : counted) counts += c;
    }
    return result;
}

bool has_places_for(const KeptTransport& kept, const Environment& environment) noexcept {
    return environment.is_black() || kept.light.sources.of_sky != LightSources::off;
}

BakePlan plan_of(const KeptTransport& kept, const Scene& scene) {
    BakePlan plan;
    plan.volume = kept.volume;
    plan.samples = kept.samples;
    plan.method = Method::cache;
    plan.first_grids = kept.volume.grids.size();
    plan.cache = kept.options;
    plan.placement = kept.placement;
    plan.why_spacing = kept.why_spacing;
    plan.why_samples = kept.why_samples;
    for (const KeptGather& gather : kept.gathers) {
        Batch batch;
        batch.slots.assign(gather.slots.begin(), gather.slots.end());
        batch.points = points_of(gather, kept.volume, scene);
        batch.samples = gather.rays * replicates;
        plan.points.insert(plan.points.end(), batch.points.begin(), batch.points.end());
        plan.batches.push_back(std::move(batch));
    }
    return plan;
}

}  // namespace lightgrid
