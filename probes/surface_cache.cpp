#include "probes/surface_cache.h"

#include "core/parallel.h"
#include "core/sampling.h"
#include "probes/transport.h"

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

/// A patch's sample: a point of it, its albedo, and what light came to it.
struct PatchSample {
    glm::vec3 albedo{0};     // reflected share
    glm::vec3 sampled{0};    // of emitters, environment and punctual lights, as a white surface would reflect it
    glm::vec3 from_rays{0};  // summed over rays
    std::uint32_t lost_rays = 0;
};

class CacheBuilder {
  public:
    CacheBuilder(const PathTracer& paths, const CacheOptions& options)
        : paths_(paths),
          options_(options),
          patches_(options.width),
          sky_(paths.environment(), sky_samples_per_ray, mix_bits(options.seed, sky)) {
        transport_.rays = options.rays_per_sample;
    }

    SurfaceCache build(std::span<const glm::vec3> points) {
        std::vector<Unknown> unknown = look_around(points);
        while (!unknown.empty() && made_.generations < most_generations) {
            const std::size_t first_new = patches_.size();
            const std::vector<Unknown> chosen = grow(unknown);
            ++made_.generations;
            unknown = light_up(first_new, chosen);
        }
        for (const Unknown& lost : unknown) ++samples_[lost.sample].lost_rays;
        complete_transport();

        const TransportSolution solution = solve(transport_, options_.accuracy);
        made_.width = options_.width;
        made_.samples = samples_.size();
        made_.patches = patches_.size();
        made_.cut_cubes = patches_.cut_cubes();
        made_.sweeps = solution.sweeps;
        made_.residual = solution.residual;
        std::vector<glm::vec3> radiance;
        radiance.reserve(solution.light.size());
        for (const glm::dvec3& light : solution.light) radiance.emplace_back(light);
        return {std::move(patches_), std::move(radiance), std::move(sky_), made_};
    }

  private:
    /// Everything that a few rays from each point meet. The rays of all points are one low-discrepancy sequence.
    std::vector<Unknown> look_around(std::span<const glm::vec3> points) {
        std::vector<std::vector<Unknown>> found(points.size());
        std::vector<PathCounts> counts(points.size());
        for_each_index(points.size(), [&](std::size_t i) {
            std::vector<Met> met;
            for (std::uint32_t r = 0; r < options_.rays_per_probe; ++r) {
                const auto index = static_cast<std::uint32_t>(i) * options_.rays_per_probe + r;
                const glm::vec3 direction = sphere_direction(sobol_point(index, mix_bits(options_.seed, finding)));
                met.clear();
                static_cast<void>(paths_.look_along({points[i], {}}, points[i], direction, 0, sky_, met, counts[i]));
                for (const Met& m : met) {
                    found[i].push_back({SurfaceSide(m.hit, points[i], direction), m.hit, direction, 0, 0, {}});
                }
            }
        });
        return join(found, counts);
    }

    /// Makes patches for what is unknown, and tells the rays that went there; returns those that become samples, patch
    /// by patch.
    std::vector<Unknown> grow(const std::vector<Unknown>& unknown) {
        const bool first = made_.generations == 0;
        std::vector<SurfaceSide> sides;
        sides.reserve(unknown.size());
        for (const Unknown& u : unknown) sides.push_back(u.side);
        const auto first_new = patches_.size();
        const std::vector<std::uint32_t> patch =
            patches_.add(paths_.tracer(), sides, made_.generations, made_.counts.shadow_rays);

        // Those of a patch one after the other.
        const std::uint32_t most = first ? static_cast<std::uint32_t>(unknown.size()) : most_unseen_samples;
        std::vector<std::uint32_t> count(patches_.size() - first_new);
        for (const std::uint32_t p : patch) {
            if (p != SurfacePatches::none) count[p - first_new] = std::min(most, count[p - first_new] + 1);
        }
        auto next = static_cast<std::uint32_t>(samples_.size());
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
        samples_.resize(next);
        transport_.landed.resize(std::size_t{next} * transport_.rays, Transport::none);
        return chosen;
    }

    void land(const Unknown& u, std::uint32_t patch) {
        if (patch == SurfacePatches::none) {
            ++samples_[u.sample].lost_rays;
        } else if (u.share == glm::vec3(1)) {
            transport_.landed[std::size_t{u.sample} * transport_.rays + u.ray] = patch;
        } else {
            transport_.passed.push_back({u.sample, patch, u.share});
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
                                                                  : static_cast<std::uint32_t>(samples_.size());
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
        PatchSample& sample = samples_[index];
        const Surface surface = tracer.surface(place.hit, place.direction);
        sample.albedo =
            reflected_share(surface_at(tracer.scene(), *surface.mesh, place.hit.id.triangle, place.hit.barycentric));
        if (sample.albedo == glm::vec3(0)) return;
        const glm::vec3 normal = surface.front ? surface.normal : -surface.normal;
        const std::uint64_t key = mix_bits(options_.seed, patch);
        const std::uint32_t lights = options_.light_samples;
        const float rays_per_light = static_cast<float>(transport_.rays) / static_cast<float>(lights);
        sample.sampled =
            paths_.direct_light(surface, normal, mix_bits(key, lighting), rank, lights, rays_per_light, sky_, counts);
        std::vector<Met> met;
        for (std::uint32_t r = 0; r < transport_.rays; ++r) {
            const glm::vec3 direction =
                cosine_direction(normal, sobol_point(rank * transport_.rays + r, mix_bits(key, carrying)));
            const glm::vec3 origin = surface.leave(direction);
            met.clear();
            sample.from_rays +=
                paths_.look_along({surface.position, normal}, origin, direction, 1 / rays_per_light, sky_, met, counts);
            for (const Met& m : met) {
                const SurfaceSide side(m.hit, origin, direction);
                const std::uint32_t landed = patches_.find(tracer, side, counts.shadow_rays);
                if (landed == SurfacePatches::none) {
                    unknown.push_back({side, m.hit, direction, index, r, m.share});
                } else if (m.share == glm::vec3(1)) {
                    transport_.landed[std::size_t{index} * transport_.rays + r] = landed;
                } else {
                    passed.push_back({index, landed, m.share});
                }
            }
        }
    }

    /// Weights and direct light. Rays whose end is not known do not count.
    void complete_transport() {
        transport_.first_sample.push_back(static_cast<std::uint32_t>(samples_.size()));
        std::stable_sort(transport_.passed.begin(), transport_.passed.end(),
                         [](const auto& a, const auto& b) { return a.from < b.from; });
        transport_.weights.reserve(samples_.size());
        for (std::size_t patch = 0; patch < patches_.size(); ++patch) {
            const std::uint32_t begin = transport_.first_sample[patch];
            const std::uint32_t end = transport_.first_sample[patch + 1];
            glm::dvec3 direct(0);
            for (std::uint32_t s = begin; s < end; ++s) {
                const PatchSample& sample = samples_[s];
                const std::uint32_t rays = transport_.rays - std::min(transport_.rays, sample.lost_rays);
                const float share = rays > 0 ? 1 / static_cast<float>(rays) : 0;
                const glm::vec3 albedo = sample.albedo / static_cast<float>(end - begin);
                transport_.weights.push_back(albedo * share);
                direct += glm::dvec3(albedo * (sample.sampled + share * sample.from_rays));
            }
            transport_.direct.push_back(direct);
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
    SurfacePatches patches_;
    SkyLight sky_;
    std::vector<PatchSample> samples_;  // patch by patch
    Transport transport_;
    CacheMade made_;
};

}  // namespace

SurfaceCache build_surface_cache(const PathTracer& paths, std::span<const glm::vec3> points,
                                 const CacheOptions& options) {
    return CacheBuilder(paths, options).build(points);
}

}  // namespace lightgrid
