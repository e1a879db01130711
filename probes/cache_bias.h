#pragma once

#include "probes/surface_cache.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace lightgrid {

/// What a surface cache adds to the irradiance at points, or takes away: its noise, which all probes and replicates
/// share, and what patches average away. Two independent unbiased estimates, so that their product is one of the square.
struct CacheBias {
    std::vector<glm::dvec3> a, b;  // per point, per normal: lux, cached minus true
    PathCounts counts;
};

struct BiasOptions {
    std::uint32_t samples = 1024;  // gather rays per point and estimate
    std::uint64_t seed = 0;
};

/// Follows a path from each surface that gather rays meet, and compares what it brings with what the cache says there.
/// Light that needs no cache (emitters, sky, lights seen directly) is the same for both and is not traced.
///
/// points  relative to Scene::origin
/// normals  the same for all points
[[nodiscard]] CacheBias measure_bias(const PathTracer& paths, const SurfaceCache& cache,
                                     std::span<const glm::vec3> points, std::span<const glm::vec3> normals,
                                     const BiasOptions& options);

}  // namespace lightgrid
