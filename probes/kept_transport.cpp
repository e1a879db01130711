#include "probes/kept_transport.h"

#include "core/hash.h"
#include "core/parallel.h"
#include "core/sampling.h"
#include "probes/bake.h"
#include "probes/gather_light.h"

#include <algorithm>
#include <mutex>
#include <utility>

namespace lightgrid {
namespace {

constexpr std::uint32_t replicates = gather_replicates;

/// Of the random numbers of samples that are aimed at light which has changed.
std::uint64_t others_seed(std::uint64_t seed) {
    return mix_bits(seed, 1);
}

std::vector<glm::vec3> points_of(const KeptGather& gather, const Volume& volume, const Scene& scene) {
    std::vector<glm::vec3> points;
    points.reserve(gather.slots.size());
    for (const std::uint64_t slot : gather.slots) points.emplace_back(gather_position(volume, slot) - scene.origin);
    return points;
}

/// Light by samples aimed at sources, at one point.
///
/// rays_per_sample  of emitters, as PathTracer::gather_lights
/// out              by source
void aim(const PathTracer& paths, const Receiver& at, std::size_t index, std::uint64_t seed, std::uint32_t count,
         float rays_per_sample, const SkyLight& sky, std::vector<PointLight>& out, PathCounts& counts) {
    std::vector<LightSample> light;
    for (std::uint32_t r = 0; r < replicates; ++r) {
        light.clear();
        paths.gather_lights(at, replicate_key(seed, index, r), count, rays_per_sample, sky, count, light, counts);
        for (const LightSample& sample : light) {
            out[sample.source].add(r, sample.direction, glm::dvec3(sample.radiance));
        }
    }
    light.clear();
    paths.gather_punctual(at.position, light, counts);
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
            const EmitterCut cut = paths_.emitters().open({batch.points[point]}, gather.rays * replicates);
            const Receiver at{batch.points[point], {}, &cut};
            aim(paths_, at, point, seed, gather.rays, 1, sky_, aimed, counted[point]);
            for (std::size_t s = 0; s < sources; ++s) {
                const std::vector<KeptEstimate> estimates = kept(aimed[s].estimates());
                std::copy(estimates.begin(), estimates.end(),
                          gather.aimed[s].begin() + static_cast<std::ptrdiff_t>(point * values));
            }
            for (std::uint32_t r = 0; r < replicates; ++r) {
                const std::size_t set = point * replicates + r;
                follow(at, replicate_rotation(replicate_key(seed, point, r)), even,
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

    void follow(const Receiver& from, const glm::mat3& rotation, std::span<const glm::vec3> even,
                std::span<std::uint32_t> landed, std::vector<RayEnd>& ends, std::vector<Missing>& missing,
                PathCounts& counts) const {
        const glm::vec3 point = from.position;
        const std::vector<glm::vec3> directions = turned(even, rotation);
        const std::vector<Hit> hits = paths_.closest_hits(point, directions, counts);
        std::vector<Met> met;
        std::vector<glm::vec3> light(paths_.sources().count);
        for (std::uint32_t i = 0; i < even.size(); ++i) {
            const glm::vec3 direction = directions[i];
            met.clear();
            std::fill(light.begin(), light.end(), glm::vec3(0));
            paths_.look_along(from, point, direction, hits[i], 1, SkyLight(), light, met, counts);
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

    const LightSeen seen{result.radiance, change.factor, [&](glm::vec3 direction) { return sky.along(direction); }};
    for (const KeptGather& gather : kept.gathers) {
        const std::vector<glm::vec3> points =
            others ? points_of(gather, volume, tracer.scene()) : std::vector<glm::vec3>();
        const GatherLight light(gather, seen, volume.bands);
        std::vector<PathCounts> counted(gather.slots.size());
        for_each_index(gather.slots.size(), [&](std::size_t point) {
            std::vector<Estimate> other;
            if (others) {
                std::vector<PointLight> aimed(1, PointLight(volume.bands));
                const EmitterCut cut = others->emitters().open({points[point]}, gather.rays * replicates);
                aim(*others, {points[point], {}, &cut}, point, others_seed(gather.seed), gather.rays, 0, sky, aimed,
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
