#pragma once

#include "probes/paths.h"
#include "probes/surface_patches.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

/// The light that the level's surfaces reflect, solved once and read by all gathers.
namespace lightgrid {

struct CacheOptions {
    float width = 0.25F;                // metres, of patches: half a spacing of probes or so
    std::uint32_t rays_per_probe = 16;  // that find the surfaces
    std::uint32_t rays_per_sample = 8;  // by which they light each other
    std::uint32_t light_samples = 16;   // of emitters, environment and punctual lights, per sample
    double accuracy = 1e-3;             // of the solution, relative
    std::uint64_t seed = 0;
};

/// How a cache came about.
struct CacheMade {
    float width = 0;  // of patches, metres
    std::size_t samples = 0;
    std::size_t patches = 0;
    std::size_t cut_cubes = 0;
    int generations = 0;
    int sweeps = 0;
    double residual = 0;
    PathCounts counts;
};

/// Reflected light is taken as constant over a patch: the mean over samples that lie there as the hits of gather rays
/// do, so that gathers read the right light on the whole though not its detail within a patch. Emission is left to
/// those who read, and their own sampling of it.
class SurfaceCache {
  public:
    SurfaceCache(SurfacePatches patches, std::vector<glm::vec3> radiance, SkyLight sky, CacheMade made)
        : patches_(std::move(patches)), radiance_(std::move(radiance)), sky_(std::move(sky)), made_(made) {}

    /// Mean radiance that the side which a ray met reflects (its share for BLEND and transmission included); null where
    /// it is not known.
    [[nodiscard]] const glm::vec3* look_up(const Tracer& tracer, const Hit& hit, glm::vec3 origin, glm::vec3 direction,
                                           PathCounts& counts) const noexcept {
        const std::uint32_t patch = patches_.find(tracer, {hit, origin, direction}, counts.shadow_rays);
        return patch == SurfacePatches::none ? nullptr : &radiance_[patch];
    }

    [[nodiscard]] const SkyLight& sky() const noexcept { return sky_; }
    [[nodiscard]] const CacheMade& made() const noexcept { return made_; }

  private:
    SurfacePatches patches_;
    std::vector<glm::vec3> radiance_;  // by patch
    SkyLight sky_;
    CacheMade made_;
};

/// Where light is needed is found by a few rays from every point; patches that those do not see but that light them
/// are found by the rays that follow, wider with every generation. The same bits for any thread count.
///
/// points  of the probes, relative to Scene::origin
[[nodiscard]] SurfaceCache build_surface_cache(const PathTracer& paths, std::span<const glm::vec3> points,
                                               const CacheOptions& options);

}  // namespace lightgrid
