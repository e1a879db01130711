#pragma once

#include "core/environment.h"
#include "core/sampling.h"
#include "core/tracer.h"
#include "probes/emitters.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

/// The unbiased estimator of light: next-event estimation, multiple importance sampling, Russian roulette.
namespace lightgrid {

/// A part of the light at a point: an integral of radiance times f over all directions is the sum of radiance *
/// f(direction) over the samples of a gather; `radiance` has been divided by density and sample count.
struct LightSample {
    glm::vec3 direction{0};  // towards where the light comes from, unit length
    glm::vec3 radiance{0};   // cd/m^2 sr
};

struct PathCounts {
    std::uint64_t rays = 0;  // closest-hit
    std::uint64_t shadow_rays = 0;
    std::uint64_t dropped = 0;  // samples that were not finite, counted as black

    PathCounts& operator+=(const PathCounts& other) {
        rays += other.rays;
        shadow_rays += other.shadow_rays;
        dropped += other.dropped;
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

class PathTracer {
  public:
    /// Keeps references to both; they must outlive it.
    PathTracer(const Tracer& tracer, const Environment& environment);

    [[nodiscard]] const Tracer& tracer() const noexcept { return *tracer_; }
    [[nodiscard]] const Environment& environment() const noexcept { return *environment_; }
    [[nodiscard]] const Estimators& estimators() const noexcept { return use_; }
    [[nodiscard]] const Emitters& emitters() const noexcept { return emitters_; }

    /// All light that arrives at `point` (relative to Scene::origin) but that which comes straight from punctual
    /// lights, by gather rays along `even`, each continued as a path, and as many samples of emitters and environment.
    ///
    /// key           picks the random numbers: one per (seed, probe, replicate)
    /// even          at least one direction, spread evenly over the sphere; the whole set is turned at random
    /// out           appended to
    /// most_bounces  paths end there; a limit makes the result too dark and is for rough looks only
    void gather(glm::vec3 point, std::uint64_t key, std::span<const glm::vec3> even, std::vector<LightSample>& out,
                PathCounts& counts, std::uint32_t most_bounces = unlimited) const;

    static constexpr std::uint32_t unlimited = 0xffffffffU;

    /// Light straight from punctual lights: one shadow ray each, exact. Appended to `out`.
    void gather_punctual(glm::vec3 point, std::vector<LightSample>& out, PathCounts& counts) const;

  private:
    struct Vertex;
    class Dimensions;

    [[nodiscard]] LightSample from_emitters(const Vertex& vertex, Dimensions& dimensions, PathCounts& counts) const;
    [[nodiscard]] LightSample from_environment(const Vertex& vertex, Dimensions& dimensions, PathCounts& counts) const;
    [[nodiscard]] LightSample from_lights(const Vertex& vertex, Dimensions& dimensions, PathCounts& counts) const;
    [[nodiscard]] glm::vec3 radiance_along(glm::vec3 origin, glm::vec3 direction, Dimensions& dimensions,
                                           PathCounts& counts, std::uint32_t most_bounces) const;

    const Tracer* tracer_;
    const Environment* environment_;
    Emitters emitters_;
    Estimators use_;
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
