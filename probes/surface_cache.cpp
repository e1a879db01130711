#include "probes/surface_cache.h"

#include "core/parallel.h"
#include "core/sampling.h"

#include <algorithm>

namespace lightgrid {
namespace {

/// Patches of a generation are twice as wide as those of the one before, so that few are needed to close the level.
constexpr int most_generations = 8;
/// Samples of a patch that no probe saw: what light it sends is one bounce further away.
constexpr std::uint32_t most_unseen_samples = 4;

/// What the random numbers are for: each has a stream of its own.
enum Stream : std::uint64_t { finding, lighting, carrying, sky };

/// Of the sky for each ray, as its weights assume; at probes as much as at samples.
constexpr float sky_samples_per_ray = 1;

/// A place where a ray met a surface and no patch is known.
struct Unknown {
    SurfaceSide side;
    Hit hit;
    glm::vec3 direction{0};
    std::uint32_t sample = 0;  // that sent the ray; not used in the first generation
    std::uint32_t ray = 0;
    glm::vec3 share{1};
};

/// What light came to a patch's sample from one source.
struct SampleLight {
    glm::vec3 sampled{0};    // of emitters, environment and punctual lights, as a white surface would reflect it
    glm::vec3 from_rays{0};  // summed over rays
};

/// Where the rays of a patch's samples go.
class CarryingRays {
  public:
    CarryingRays(std::uint64_t seed, std::size_t patch, std::uint32_t rays)
        : key_(mix_bits(mix_bits(seed, patch), carrying)), rays_(rays) {}

    /// rank  of the sample, in its patch
    [[nodiscard]] glm::vec3 direction(glm::vec3 normal, std::uint32_t rank, std::uint32_t ray) const {
        return cosine_direction(normal, sobol_point(rank * rays_ + ray, key_));
    }

  private:
    std::uint64_t key_;
    std::uint32_t rays_;
};

glm::vec3 side_normal(const Surface& surface) {
    return surface.front ? surface.normal : -surface.normal;
}

/// What a sky sends along a patch's rays that left the level, its samples taken one after the other.
class SkyOfPatch {
  public:
    SkyOfPatch(const Transport& transport, const CacheOptions& options, std::size_t patch)
        : transport_(transport),
          first_(transport.first_sample[patch]),
          rays_(options.seed, patch, transport.rays),
          passed_(std::lower_bound(transport.passed.begin(), transport.passed.end(), first_,
                                   [](const Transport::PassedRay& ray, std::uint32_t s) { return ray.from < s; })) {}

    /// Summed over rays of sample s.
    ///
    /// radiance  of the sky, by direction
    template <typename Radiance>
    glm::vec3 to_sample(std::uint32_t s, glm::vec3 normal, Radiance radiance) {
        glm::vec3 sum(0);
        for (std::uint32_t r = 0; r < transport_.rays; ++r) {
            if (transport_.landed[std::size_t{s} * transport_.rays + r] != Transport::sky) continue;
            sum += radiance(rays_.direction(normal, s - first_, r));
        }
        while (passed_ != transport_.passed.end() && passed_->from < s) ++passed_;
        for (; passed_ != transport_.passed.end() && passed_->from == s; ++passed_) {
            if (passed_->patch != Transport::sky) continue;
            sum += passed_->share * radiance(rays_.direction(normal, s - first_, passed_->ray));
        }
        return sum;
    }

  private:
    const Transport& transport_;
    std::uint32_t first_;
    CarryingRays rays_;
    std::vector<Transport::PassedRay>::const_iterator passed_;
};

class SurfaceFinder {
  public:
    SurfaceFinder(const PathTracer& paths, const CacheOptions& options)
        : paths_(paths),
          options_(options),
          sources_(paths.sources().count),
          patches_(options.width),
          sky_(paths.estimators().sky ? sky_of_cache(paths.environment(), options) : SkyLight()) {
        transport_.rays = options.rays_per_sample;
    }

    /// Goes on with what another has found.
    SurfaceFinder(const PathTracer& paths, const CacheOptions& options, Surfaces&& found)
        : paths_(paths),
          options_(options),
          sources_(found.direct.size()),
          patches_(std::move(found.patches)),
          sky_(std::move(found.sky)),
          places_(std::move(found.places)),
          lost_rays_(places_.size()),
          light_(places_.size() * sources_),
          transport_(std::move(found.transport)),
          direct_(std::move(found.direct)),
          made_(found.made) {
        transport_.first_sample.pop_back();
    }

    void look_around(std::span<const glm::vec3> points) { static_cast<void>(find(seen_from(points))); }

    std::vector<std::uint32_t> add(std::span<const SeenPlace> places) {
        std::vector<Unknown> unknown;
        unknown.reserve(places.size());
        for (const SeenPlace& p : places) {
            unknown.push_back({SurfaceSide(p.hit, p.origin, p.direction), p.hit, p.direction, 0, 0, {}});
        }
        return find(std::move(unknown));
    }

    Surfaces finish() {
        complete();
        made_.width = options_.width;
        made_.samples = places_.size();
        made_.patches = patches_.size();
        made_.cut_cubes = patches_.cut_cubes();
        return {std::move(patches_), std::move(transport_), std::move(places_),
                std::move(direct_),  std::move(sky_),       made_};
    }

  private:
    /// Makes patches for places, and for what lights them; returns those of the places.
    std::vector<std::uint32_t> find(std::vector<Unknown> unknown) {
        std::vector<std::uint32_t> of_places;
        int level = 0;
        for (; !unknown.empty() && level < most_generations; ++level) {
            const std::size_t first_new = patches_.size();
            std::vector<std::uint32_t> patch;
            const std::vector<Unknown> chosen = grow(unknown, level, patch);
            if (level == 0) of_places = std::move(patch);
            unknown = light_up(first_new, chosen);
        }
        for (const Unknown& lost : unknown) ++lost_rays_[lost.sample];
        made_.generations = std::max(made_.generations, level);
        return of_places;
    }

    /// Everything that a few rays from each point meet. The rays of all points are one low-discrepancy sequence.
    std::vector<Unknown> seen_from(std::span<const glm::vec3> points) {
        std::vector<std::vector<Unknown>> found(points.size());
        std::vector<PathCounts> counts(points.size());
        for_each_index(points.size(), [&](std::size_t i) {
            std::vector<glm::vec3> directions(options_.rays_per_probe);
            for (std::uint32_t r = 0; r < directions.size(); ++r) {
                const auto index = static_cast<std::uint32_t>(i) * options_.rays_per_probe + r;
                directions[r] = sphere_direction(sobol_point(index, mix_bits(options_.seed, finding)));
            }
            const std::vector<Hit> hits = paths_.closest_hits(points[i], directions, counts[i]);
            std::vector<Met> met;
            for (std::uint32_t r = 0; r < directions.size(); ++r) {
                const glm::vec3 direction = directions[r];
                met.clear();
                paths_.look_along({points[i], {}}, points[i], direction, hits[r], 0, sky_, {}, met, counts[i]);
                for (const Met& m : met) {
                    if (m.hit.found())
                        found[i].push_back({SurfaceSide(m.hit, points[i], direction), m.hit, direction, 0, 0, {}});
                }
            }
        });
        return join(found, counts);
    }

    /// Makes patches for what is unknown, and tells the rays that went there; returns those that become samples, patch
    /// by patch.
    ///
    /// patch  set to that of each
    std::vector<Unknown> grow(const std::vector<Unknown>& unknown, int level, std::vector<std::uint32_t>& patch) {
        const bool first = level == 0;
        std::vector<SurfaceSide> sides;
        sides.reserve(unknown.size());
        for (const Unknown& u : unknown) sides.push_back(u.side);
        const auto first_new = patches_.size();
        patch = patches_.add(paths_.tracer(), sides, level, made_.counts.shadow_rays);

        // Those of a patch one after the other.
        const std::uint32_t most = first ? static_cast<std::uint32_t>(unknown.size()) : most_unseen_samples;
        std::vector<std::uint32_t> count(patches_.size() - first_new);
        for (const std::uint32_t p : patch) {
            if (p != SurfacePatches::none) count[p - first_new] = std::min(most, count[p - first_new] + 1);
        }
        auto next = static_cast<std::uint32_t>(places_.size());
        const std::uint32_t first_sample = next;
        std::vector<std::uint32_t> place;
        for (const std::uint32_t n : count) {
            transport_.first_sample.push_back(next);
            place.push_back(next - first_sample);
            next += n;
        }
        std::vector<std::uint32_t> left = count;
        std::vector<std::uint32_t> order(next - first_sample);
        for (std::uint32_t i = 0; i < unknown.size(); ++i) {
            if (!first) land(unknown[i], patch[i]);
            if (patch[i] == SurfacePatches::none) continue;
            const std::uint32_t p = patch[i] - static_cast<std::uint32_t>(first_new);
            if (left[p] == 0) continue;
            --left[p];
            order[place[p]++] = i;
        }
        std::vector<Unknown> chosen;
        chosen.reserve(order.size());
        for (const std::uint32_t i : order) chosen.push_back(unknown[i]);
        places_.resize(next);
        lost_rays_.resize(next);
        light_.resize(std::size_t{next} * sources_);
        transport_.landed.resize(std::size_t{next} * transport_.rays, Transport::none);
        return chosen;
    }

    void land(const Unknown& u, std::uint32_t patch) {
        if (patch == SurfacePatches::none) {
            ++lost_rays_[u.sample];
        } else if (u.share == glm::vec3(1)) {
            transport_.landed[std::size_t{u.sample} * transport_.rays + u.ray] = patch;
        } else {
            transport_.passed.push_back({u.sample, u.ray, patch, u.share});
        }
    }

    /// Light of the samples of new patches, and their rays; returns where those went that is unknown.
    std::vector<Unknown> light_up(std::size_t first_new, const std::vector<Unknown>& chosen) {
        const std::size_t count = patches_.size() - first_new;
        std::vector<std::vector<Unknown>> unknown(count);
        std::vector<std::vector<Transport::PassedRay>> passed(count);
        std::vector<PathCounts> counts(count);
        const std::uint32_t first_sample = transport_.first_sample[first_new];
        for_each_index(count, [&](std::size_t i) {
            const std::size_t patch = first_new + i;
            const std::uint32_t begin = transport_.first_sample[patch];
            const std::uint32_t end = patch + 1 < patches_.size() ? transport_.first_sample[patch + 1]
                                                                  : static_cast<std::uint32_t>(places_.size());
            for (std::uint32_t s = begin; s < end; ++s) {
                light_sample(patch, s, s - begin, chosen[s - first_sample], unknown[i], passed[i], counts[i]);
            }
        });
        for (const auto& p : passed) transport_.passed.insert(transport_.passed.end(), p.begin(), p.end());
        return join(unknown, counts);
    }

    void light_sample(std::size_t patch, std::uint32_t index, std::uint32_t rank, const Unknown& place,
                      std::vector<Unknown>& unknown, std::vector<Transport::PassedRay>& passed, PathCounts& counts) {
        const Tracer& tracer = paths_.tracer();
        const Surface surface = tracer.surface(place.hit, place.direction);
        const glm::vec3 albedo =
            reflected_share(surface_at(tracer.scene(), *surface.mesh, place.hit.id.triangle, place.hit.barycentric));
        places_[index] = {place.hit, place.direction, albedo};
        if (albedo == glm::vec3(0)) return;
        const glm::vec3 normal = side_normal(surface);
        const std::uint32_t lights = options_.light_samples;
        const float rays_per_light = static_cast<float>(transport_.rays) / static_cast<float>(lights);
        std::vector<glm::vec3> light(sources_);
        const EmitterCut cut = paths_.emitters().open({surface.position, normal}, lights);
        const Receiver at{surface.position, normal, &cut};
        paths_.direct_light(surface, at, mix_bits(mix_bits(options_.seed, patch), lighting), rank, lights,
                            rays_per_light, sky_, light, counts);
        for (std::size_t s = 0; s < sources_; ++s) light_[index * sources_ + s].sampled = light[s];
        std::fill(light.begin(), light.end(), glm::vec3(0));
        const CarryingRays rays(options_.seed, patch, transport_.rays);
        std::vector<glm::vec3> directions(transport_.rays);
        for (std::uint32_t r = 0; r < transport_.rays; ++r) directions[r] = rays.direction(normal, rank, r);
        const glm::vec3 origin = surface.leave(normal);
        const std::vector<Hit> hits = paths_.closest_hits(origin, directions, counts);
        std::vector<Met> met;
        for (std::uint32_t r = 0; r < transport_.rays; ++r) {
            const glm::vec3 direction = directions[r];
            met.clear();
            paths_.look_along(at, origin, direction, hits[r], 1 / rays_per_light, sky_, light, met, counts);
            for (const Met& m : met) {
                if (!m.hit.found()) {
                    if (m.share == glm::vec3(1)) {
                        transport_.landed[std::size_t{index} * transport_.rays + r] = Transport::sky;
                    } else {
                        passed.push_back({index, r, Transport::sky, m.share});
                    }
                    continue;
                }
                const SurfaceSide side(m.hit, origin, direction);
                const std::uint32_t landed = patches_.find(tracer, side, counts.shadow_rays);
                if (landed == SurfacePatches::none) {
                    unknown.push_back({side, m.hit, direction, index, r, m.share});
                } else if (m.share == glm::vec3(1)) {
                    transport_.landed[std::size_t{index} * transport_.rays + r] = landed;
                } else {
                    passed.push_back({index, r, landed, m.share});
                }
            }
        }
        for (std::size_t s = 0; s < sources_; ++s) light_[index * sources_ + s].from_rays = light[s];
    }

    /// Weights and direct light. Rays whose end is not known do not count.
    void complete() {
        transport_.first_sample.push_back(static_cast<std::uint32_t>(places_.size()));
        std::stable_sort(transport_.passed.begin(), transport_.passed.end(),
                         [](const auto& a, const auto& b) { return a.from < b.from; });
        transport_.weights.reserve(places_.size());
        direct_.resize(sources_);
        const std::size_t first_new = direct_.front().size();
        for (std::vector<glm::dvec3>& source : direct_) source.resize(patches_.size(), glm::dvec3(0));
        for (std::size_t patch = first_new; patch < patches_.size(); ++patch) {
            const std::uint32_t begin = transport_.first_sample[patch];
            const std::uint32_t end = transport_.first_sample[patch + 1];
            for (std::uint32_t s = begin; s < end; ++s) {
                const std::uint32_t rays = transport_.rays - std::min(transport_.rays, lost_rays_[s]);
                const float share = rays > 0 ? 1 / static_cast<float>(rays) : 0;
                glm::vec3& albedo = places_[s].albedo;
                albedo /= static_cast<float>(end - begin);
                transport_.weights.push_back(albedo * share);
                for (std::size_t source = 0; source < sources_; ++source) {
                    const SampleLight& light = light_[s * sources_ + source];
                    direct_[source][patch] += glm::dvec3(albedo * (light.sampled + share * light.from_rays));
                }
            }
        }
    }

    std::vector<Unknown> join(const std::vector<std::vector<Unknown>>& parts, std::span<const PathCounts> counts) {
        std::vector<Unknown> all;
        for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
        for (const PathCounts& c : counts) made_.counts += c;
        return all;
    }

    const PathTracer& paths_;
    const CacheOptions& options_;
    std::size_t sources_;
    SurfacePatches patches_;
    SkyLight sky_;
    std::vector<PatchPlace> places_;  // by sample, patch by patch
    std::vector<std::uint32_t> lost_rays_;
    std::vector<SampleLight> light_;  // by sample and source
    Transport transport_;
    std::vector<std::vector<glm::dvec3>> direct_;
    CacheMade made_;
};

}  // namespace

SkyLight sky_of_cache(const Environment& environment, const CacheOptions& options) {
    return {environment, sky_samples_per_ray, mix_bits(options.seed, sky)};
}

SkyLight sky_of_rays(const Environment& environment) {
    return SkyLight::of_rays(environment, sky_samples_per_ray);
}

Surfaces find_surfaces(const PathTracer& paths, std::span<const glm::vec3> points, const CacheOptions& options) {
    SurfaceFinder finder(paths, options);
    finder.look_around(points);
    return finder.finish();
}

std::vector<std::uint32_t> add_places(const PathTracer& paths, std::span<const SeenPlace> places,
                                      const CacheOptions& options, Surfaces& surfaces) {
    SurfaceFinder finder(paths, options, std::move(surfaces));
    std::vector<std::uint32_t> patches = finder.add(places);
    surfaces = finder.finish();
    return patches;
}

std::vector<glm::dvec3> trace_direct(const PathTracer& paths, const Transport& transport,
                                     std::span<const PatchPlace> places, const SkyLight& sky,
                                     const CacheOptions& options, PathCounts& counts) {
    std::vector<glm::dvec3> direct(transport.patches());
    std::vector<PathCounts> counted(direct.size());
    for_each_index(direct.size(), [&](std::size_t patch) {
        const std::uint32_t begin = transport.first_sample[patch];
        const std::uint64_t key = mix_bits(mix_bits(options.seed, patch), lighting);
        SkyOfPatch sky_of_patch(transport, options, patch);
        for (std::uint32_t s = begin; s < transport.first_sample[patch + 1]; ++s) {
            if (places[s].albedo == glm::vec3(0)) continue;
            const Surface surface = paths.tracer().surface(places[s].hit, places[s].direction);
            const glm::vec3 normal = side_normal(surface);
            const EmitterCut cut = paths.emitters().open({surface.position, normal}, options.light_samples);
            glm::vec3 sampled(0);
            paths.direct_light(surface, {surface.position, normal, &cut}, key, s - begin, options.light_samples, 0, sky,
                               {&sampled, 1}, counted[patch]);
            direct[patch] += glm::dvec3(places[s].albedo * sampled);
            if (sky.is_black()) continue;
            const glm::vec3 from_rays =
                sky_of_patch.to_sample(s, normal, [&](glm::vec3 direction) { return sky.along(direction); });
            direct[patch] += glm::dvec3(transport.weights[s] * from_rays);
        }
    });
    for (const PathCounts& c : counted) counts += c;
    return direct;
}

std::vector<glm::dvec3> direct_from_sky(const Tracer& tracer, const Transport& transport,
                                        std::span<const PatchPlace> places,
                                        const std::function<glm::vec3(glm::vec3)>& radiance,
                                        const CacheOptions& options) {
    std::vector<glm::dvec3> direct(transport.patches());
    for_each_index(direct.size(), [&](std::size_t patch) {
        SkyOfPatch sky(transport, options, patch);
        for (std::uint32_t s = transport.first_sample[patch]; s < transport.first_sample[patch + 1]; ++s) {
            if (places[s].albedo == glm::vec3(0)) continue;
            const glm::vec3 normal = side_normal(tracer.surface(places[s].hit, places[s].direction));
            direct[patch] += glm::dvec3(transport.weights[s] * sky.to_sample(s, normal, radiance));
        }
    });
    return direct;
}

SurfaceCache light_surfaces(Surfaces surfaces, const CacheOptions& options) {
    std::vector<glm::dvec3> direct(surfaces.transport.patches());
    for (const std::vector<glm::dvec3>& source : surfaces.direct) {
        for (std::size_t patch = 0; patch < direct.size(); ++patch) direct[patch] += source[patch];
    }
    const TransportSolution solution = solve(surfaces.transport, direct, options.accuracy);
    surfaces.made.sweeps = solution.sweeps;
    surfaces.made.residual = solution.residual;
    return {std::move(surfaces.patches),
            {solution.light.begin(), solution.light.end()},
            std::move(surfaces.sky),
            surfaces.made};
}

SurfaceCache build_surface_cache(const PathTracer& paths, std::span<const glm::vec3> points,
                                 const CacheOptions& options) {
    return light_surfaces(find_surfaces(paths, points, options), options);
}

}  // namespace lightgrid
