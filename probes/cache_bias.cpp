#include "probes/cache_bias.h"

#include "core/parallel.h"
#include "core/sampling.h"

#include <glm/gtc/constants.hpp>

namespace lightgrid {
namespace {

/// What the random numbers are for: each has a stream of its own.
enum Stream : std::uint64_t { turning, following };

void add_irradiance(glm::vec3 direction, glm::dvec3 radiance, std::span<const glm::vec3> normals,
                    std::span<glm::dvec3> irradiance) {
    for (std::size_t k = 0; k < normals.size(); ++k) {
        const float cosine = glm::dot(normals[k], direction);
        if (cosine > 0) irradiance[k] += radiance * static_cast<double>(cosine);
    }
}

}  // namespace

CacheBias measure_bias(const PathTracer& paths, const SurfaceCache& cache, std::span<const glm::vec3> points,
                       std::span<const glm::vec3> normals, const BiasOptions& options) {
    CacheBias bias;
    bias.a.resize(points.size() * normals.size());
    bias.b.resize(points.size() * normals.size());
    const std::vector<glm::vec3> even = even_directions(options.samples);
    const double share = 4 * glm::pi<double>() / options.samples;
    std::vector<PathCounts> counts(2 * points.size());
    for_each_index(2 * points.size(), [&](std::size_t task) {
        const std::size_t point = task / 2;
        std::vector<glm::dvec3>& estimates = task % 2 == 0 ? bias.a : bias.b;
        const auto irradiance = std::span(estimates).subspan(point * normals.size(), normals.size());
        const std::uint64_t key = mix_bits(options.seed, task);
        const std::vector<glm::vec3> directions = turned(even, random_rotation(mix_bits(key, turning)));
        const std::vector<Hit> hits = paths.closest_hits(points[point], directions, counts[task]);
        std::vector<Met> met;
        for (std::uint32_t i = 0; i < options.samples; ++i) {
            const glm::vec3 direction = directions[i];
            met.clear();
            paths.look_along({points[point], {}}, points[point], direction, hits[i], 0, cache.sky(), {}, met,
                             counts[task]);
            for (std::size_t k = 0; k < met.size(); ++k) {
                if (!met[k].hit.found()) continue;
                const glm::vec3* known =
                    cache.look_up(paths.tracer(), met[k].hit, points[point], direction, counts[task]);
                if (known == nullptr) continue;  // gathers follow a path there
                const glm::vec3 truth = paths.reflected_radiance(
                    met[k].hit, direction, mix_bits(mix_bits(key, following), k), i, counts[task]);
                add_irradiance(direction, share * glm::dvec3(met[k].share * (*known - truth)), normals, irradiance);
            }
        }
    });
    for (const PathCounts& c : counts) bias.counts += c;
    return bias;
}

}  // namespace lightgrid
