#pragma once

#include "core/environment.h"
#include "core/sampling.h"
#include "core/tracer.h"
#include "probes/emitters.h"
#include "probes/light_sources.h"
#include "probes/sky_light.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

/// The unbiased estimator of light: next-event estimation, multiple importance sampling, Russian roulette.
namespace lightgrid {

class SurfaceCache;

/// A part of the light at a point: an integral of radiance times f over all directions is the sum of radiance *
/// f(direction) over the samples of a gather; `radiance` has been divided by density and sample count.
struct LightSample {
    glm::vec3 direction{0};    // towards where the light comes from, unit length
    glm::vec3 radiance{0};     // cd/m^2 sr
    std::uint32_t source = 0;  // of samples that were aimed at a light; 0 where a ray found it
};

/// A set of lights: bit 0 is the sky, 1 all emissive surfaces, 2 to 63 the punctual lights, by index, in turn.
using LightSet = std::uint64_t;
inline constexpr LightSet sky_light = 1;
inline constexpr LightSet emissive_light = 2;
[[nodiscard]] constexpr LightSet punctual_light(std::size_t index) noexcept {
    return LightSet{1} << (2 + index % 62);
}

struct PathCounts {
    std::uint64_t rays = 0;  // closest-hit
    std::uint64_t shadow_rays = 0;
    std::uint64_t dropped = 0;  // samples that were not finite, counted as black
    LightSet tested = 0;        // lights that a ray asked for where they shine, were nothing in the way

    PathCounts& operator+=(const PathCounts& other) {
        rays += other.rays;
        shadow_rays += other.shadow_rays;
        dropped += other.dropped;
        tested |= other.tested;
        return *this;
    }
};

/// What this level's light asks of the estimator; the rest is left out.
struct Estimators {
    bool emitters = false;     // emissive triangles are sampled
    bool environment = false;  // the environment is importance-sampled (it is not uniform)
    bool lights = false;       // punctual lights
    bool reflection = false;   // some surface reflects: paths go on behind the first hit
    bool sky = false;          // the environment is not black: rays that leave are looked up
};

/// How a gather goes about it.
struct GatherRays {
    static constexpr std::uint32_t unlimited = 0xffffffffU;
    /// Paths end after so many; a limit makes the result too dark and is for rough looks only.
    std::uint32_t most_bounces = unlimited;
    /// Paths end at the first surface whose reflected light is known here. Null: none is.
    const SurfaceCache* cache = nullptr;
    /// With a cache, one sample of emitters, and one of the environment, for each so many gather rays, but at least one:
    /// such samples cost as much as a ray, and the light that they are for has no other noise.
    std::uint32_t rays_per_emitter_sample = 1;
    std::uint32_t rays_per_sky_sample = 1;
};

/// A surface that a ray met, or the sky (no hit was found), and the share of light from there that what the ray has
/// passed before lets through.
struct Met {
    Hit hit;
    glm::vec3 share{1};
};

class PathTracer {
  public:
    /// Keeps references to tracer and environment; they must outlive it.
    PathTracer(const Tracer& tracer, const Environment& environment, LightSources sources = {});

    [[nodiscard]] const Tracer& tracer() const noexcept { return *tracer_; }
    [[nodiscard]] const Environment& environment() const noexcept { return *environment_; }
    [[nodiscard]] const Estimators& estimators() const noexcept { return use_; }
    [[nodiscard]] const Emitters& emitters() const noexcept { return emitters_; }
    [[nodiscard]] const LightSources& sources() const noexcept { return sources_; }
    /// All lights that shine. Where some of them were never tested (PathCounts), darkness is no evidence.
    [[nodiscard]] LightSet lights() const noexcept { return lights_; }

    /// All light that arrives at a point (relative to Scene::origin) but that which comes straight from punctual lights,
    /// by gather rays along `even`, each continued as a path, and by samples of emitters and environment.
    ///
    /// at    the point, from all sides; where no cut was made for it, one is made
    /// key   picks the random numbers: one per (seed, probe, replicate)
    /// even  at least one direction, spread evenly over the sphere; the whole set is turned at random
    /// out   appended to
    void gather(const Receiver& at, std::uint64_t key, std::span<const glm::vec3> even, std::vector<LightSample>& out,
                PathCounts& counts, const GatherRays& rays = {}) const;

    /// The part of the light at a probe that samples aimed at emitters and sky bring where gather rays read a cache.
    /// Appended to `out`.
    ///
    /// at  the same for look_along, so that the weights of both add up
    /// rays_per_emitter_sample  rays of look_along for each sample of emitters, in whose weights they count; 0: none
    void gather_lights(const Receiver& at, std::uint64_t key, std::uint32_t emitter_samples,
                       float rays_per_emitter_sample, const SkyLight& sky, std::uint32_t sky_samples,
                       std::vector<LightSample>& out, PathCounts& counts) const;

    /// Light straight from punctual lights: one shadow ray each, exact. Appended to `out`.
    void gather_punctual(glm::vec3 point, std::vector<LightSample>& out, PathCounts& counts) const;

    /// What rays from one point meet first.
    [[nodiscard]] std::vector<Hit> closest_hits(glm::vec3 origin, std::span<const glm::vec3> directions,
                                                PathCounts& counts) const;

    /// A ray that starts at a probe (normal 0) or on a surface (cosine-weighted about the normal), past surfaces that
    /// light passes to the first that stops it, or to the sky. The light straight from emitters and sky along it,
    /// weighted against `samples_per_ray` samples of emitters for each such ray, is added to `light`.
    ///
    /// first  what it meets first
    /// light  by source; empty: nobody asks
    /// met    appended to: all surfaces on the way, that reflect or not, and the sky
    void look_along(const Receiver& from, glm::vec3 origin, glm::vec3 direction, const Hit& first,
                    float samples_per_ray, const SkyLight& sky, std::span<glm::vec3> light, std::vector<Met>& met,
                    PathCounts& counts) const;

    /// The other part of the light that comes straight to a surface's side: the i-th `count` samples of emitters, sky
    /// and punctual lights, for `rays_per_sample` cosine-weighted rays of look_along each. The mean radiance that a
    /// white surface would reflect (irradiance / pi) is added to `light`, by source.
    ///
    /// at      the surface's place, and the normal of the side; the same for look_along, so that the weights of both add up
    /// key     picks the random numbers; all samples of one key are stratified together
    void direct_light(const Surface& surface, const Receiver& at, std::uint64_t key, std::uint32_t i,
                      std::uint32_t count, float rays_per_sample, const SkyLight& sky, std::span<glm::vec3> light,
                      PathCounts& counts) const;

    /// What the side that a ray met reflects towards it, estimated by the i-th path of a key: unbiased, the truth that a
    /// cache is measured against.
    [[nodiscard]] glm::vec3 reflected_radiance(const Hit& hit, glm::vec3 direction, std::uint64_t key, std::uint32_t i,
                                               PathCounts& counts) const;

    /// The surface neither emits nor lets light pass: all there is to it is what it reflects.
    [[nodiscard]] bool only_reflects(const Hit& hit) const noexcept;

  private:
    struct Vertex;
    struct Aimed;
    class Dimensions;

    void gather_paths(const Receiver& at, std::uint64_t key, std::span<const glm::vec3> even,
                      std::vector<LightSample>& out, PathCounts& counts, const GatherRays& rays) const;
    void gather_cached(const Receiver& at, std::uint64_t key, std::span<const glm::vec3> even,
                       std::vector<LightSample>& out, PathCounts& counts, const GatherRays& rays) const;

    // Light of samples as if nothing were in the way. rays_per_sample: how many rays are sent from the vertex by its own
    // density for each of these samples.
    [[nodiscard]] Aimed at_emitters(const Vertex& vertex, Dimensions& dimensions, float rays_per_sample = 1) const;
    [[nodiscard]] Aimed at_environment(const Vertex& vertex, Dimensions& dimensions) const;
    [[nodiscard]] Aimed at_sky(const Vertex& vertex, const SkyLight::Sample& sample) const;
    [[nodiscard]] Aimed at_lights(const Vertex& vertex, Dimensions& dimensions) const;
    // What of it arrives: of one, or of all that were collected, appended to `out`.
    [[nodiscard]] glm::vec3 arriving(const Vertex& vertex, const Aimed& aimed, PathCounts& counts) const;
    static void aim(const Aimed& sample, float weight, std::vector<Aimed>& aimed);
    void let_through(const Vertex& vertex, std::span<const Aimed> aimed, std::vector<LightSample>& out,
                     PathCounts& counts) const;
    /// Where a path last chose a direction, how densely, and how many samples of emitters were taken there for it.
    struct Scattering {
        Receiver at;
        float pdf = 0;
        float samples_per_ray = 1;
    };
    [[nodiscard]] glm::vec3 radiance_along(glm::vec3 origin, glm::vec3 direction, Hit hit, Scattering scattering,
                                           Dimensions& dimensions, PathCounts& counts, const GatherRays& rays) const;
    // What reaches the start of a ray, `share` of it let through: from the sky, weighted against one sample of the kind
    // above, or from an emitting surface that it met, against samples_per_ray samples.
    [[nodiscard]] glm::vec3 sky_along(glm::vec3 share, glm::vec3 direction, float pdf) const;
    [[nodiscard]] glm::vec3 emission_of(glm::vec3 share, const Hit& hit, const Surface& surface,
                                        const SurfacePoint& point, const Receiver& from, float pdf,
                                        float samples_per_ray) const;

    const Tracer* tracer_;
    const Environment* environment_;
    LightSources sources_;
    Emitters emitters_;
    Estimators use_;
    LightSet lights_ = 0;
    std::vector<char> only_reflects_;  // by material
};

/// What a punctual light brings to `point` where nothing is in the way: `radiance` is the irradiance (lux) on a surface
/// that faces it.
struct PunctualLight {
    glm::vec3 direction{0};  // towards the light
    glm::vec3 irradiance{0};
    float free_distance = 0;  // towards it, that has to be free of surfaces
};
[[nodiscard]] PunctualLight punctual_light_at(const Light& light, glm::vec3 point) noexcept;

}  // namespace lightgrid
