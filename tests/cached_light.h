#pragma once

#include "probes/cache_bias.h"
#include "probes/gather.h"
#include "probes/surface_cache.h"

#include <glm/glm.hpp>

#include <vector>

/// Light by a surface cache, for comparison with values that are known.
namespace lightgrid {

/// As gather, by a cache that is made for these points. What the cache itself says that its light is off counts as
/// standard error of the irradiance.
///
/// cache_options  rays_per_probe is set to the gather's samples
inline Gather gather_by_cache(const PathTracer& paths, const std::vector<glm::vec3>& points, CacheOptions cache_options,
                              GatherOptions options, PathCounts* counts = nullptr) {
    cache_options.rays_per_probe = options.samples;
    const SurfaceCache cache = build_surface_cache(paths, points, cache_options);
    options.rays.cache = &cache;
    Gather light = gather(paths, points, options, counts);
    const CacheBias bias = measure_bias(paths, cache, points, options.normals, {.samples = options.samples, .seed = 1});
    for (std::size_t i = 0; i < light.irradiance.size(); ++i) {
        const glm::dvec3 off = 0.5 * (bias.a[i] + bias.b[i]);
        glm::dvec3& error = light.irradiance[i].error;
        error = glm::sqrt(error * error + off * off);
    }
    if (counts != nullptr) *counts += bias.counts;
    return light;
}

}  // namespace lightgrid
