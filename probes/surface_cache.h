#pragma once

#include "probes/paths.h"
#include "probes/surface_patches.h"
#include "probes/transport.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <functional>
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

/// A sample of a patch, so that light which changed can be traced to it again.
struct PatchPlace {
    Hit hit;
    glm::vec3 direction{0};  // of the ray that met it
    glm::vec3 albedo{0};     // its part of its patch's reflected share
};

/// The level's surfaces, how light goes between them, and what comes to them straight from each source.
struct Surfaces {
    SurfacePatches patches;
    Transport transport;
    std::vector<PatchPlace> places;               // by sample
    std::vector<std::vector<glm::dvec3>> direct;  // E of the transport, by source and patch
    SkyLight sky;
    CacheMade made;
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

/// The sky as a cache's gathers read it; or what rays read of it alone.
[[nodiscard]] SkyLight sky_of_cache(const Environment& environment, const CacheOptions& options);
[[nodiscard]] SkyLight sky_of_rays(const Environment& environment);

/// Where light is needed is found by a few rays from every point; patches that those do not see but that light them
/// are found by the rays that follow, wider with every generation. The same bits for any thread count.
///
/// points  of the probes, relative to Scene::origin
[[nodiscard]] Surfaces find_surfaces(const PathTracer& paths, std::span<const glm::vec3> points,
                                     const CacheOptions& options);

/// A place that a ray met.
struct SeenPlace {
    Hit hit;
    glm::vec3 origin{0};     // of the ray
    glm::vec3 direction{0};  // of the ray
};

/// Patches for places where none is known, and for what lights them, behind those that there are. Returns the patch of
/// each place, or SurfacePatches::none where a cube is full.
[[nodiscard]] std::vector<std::uint32_t> add_places(const PathTracer& paths, std::span<const SeenPlace> places,
                                                    const CacheOptions& options, Surfaces& surfaces);

/// What comes to the same patches straight from the sources of `paths`, all together: E of the transport. Takes shadow
/// rays alone; where the transport's rays left the level is known.
///
/// options  as the surfaces were found with
[[nodiscard]] std::vector<glm::dvec3> trace_direct(const PathTracer& paths, const Transport& transport,
                                                   std::span<const PatchPlace> places, const SkyLight& sky,
                                                   const CacheOptions& options, PathCounts& counts);

/// What comes to the same patches straight from a sky, by the transport's rays alone: no ray is traced.
///
/// radiance  of the sky, by direction; any sign; called from any thread
[[nodiscard]] std::vector<glm::dvec3> direct_from_sky(const Tracer& tracer, const Transport& transport,
                                                      std::span<const PatchPlace> places,
                                                      const std::function<glm::vec3(glm::vec3)>& radiance,
                                                      const CacheOptions& options);

/// All bounces of the light of all sources.
[[nodiscard]] SurfaceCache light_surfaces(Surfaces surfaces, const CacheOptions& options);

[[nodiscard]] SurfaceCache build_surface_cache(const PathTracer& paths, std::span<const glm::vec3> points,
                                               const CacheOptions& options);

}  // namespace lightgrid
