#pragma once

#include "core/sampling.h"
#include "core/tracer.h"

#include <glm/glm.hpp>
#include <glm/gtc/constants.hpp>

/// Light as a first attempt computes it, to compare with.
namespace lightgrid {

struct NaiveOptions {
    int samples = 65536;
    float offset = 1e-3F;  // metres, along the normal, by which rays start off a surface
    int bounces = 64;
};

/// Irradiance from emissive surfaces: paths that meet them by chance, in float, with a fixed offset and a fixed number
/// of bounces.
[[nodiscard]] inline float naive_irradiance(const Tracer& tracer, glm::vec3 point, glm::vec3 normal,
                                            const NaiveOptions& options) {
    RandomStream random(1);
    float sum = 0;
    for (int i = 0; i < options.samples; ++i) {
        glm::vec3 origin = point;
        glm::vec3 direction = cosine_direction(normal, random.next2());
        float throughput = 1;
        for (int bounce = 0; bounce <= options.bounces; ++bounce) {
            const Hit hit = tracer.closest_hit(origin, direction);
            if (!hit.found()) break;
            const Surface surface = tracer.surface(hit, direction);
            const Material& material = tracer.scene().materials[surface.mesh->material];
            if (surface.front) sum += throughput * material.emission.x;
            throughput *= material.base_color.x;
            const glm::vec3 side = surface.front ? surface.normal : -surface.normal;
            origin = origin + hit.distance * direction + options.offset * side;
            direction = cosine_direction(side, random.next2());
        }
    }
    return glm::pi<float>() * sum / static_cast<float>(options.samples);
}

}  // namespace lightgrid
