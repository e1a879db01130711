#include "viewer/panorama.h"

#include "core/sampling.h"

#include <algorithm>
#include <cmath>

namespace lightgrid {
namespace {

/// Of a picture of 16:9 that is 60 degrees high.
constexpr double half_width_deg = 45;
constexpr double half_height_deg = 30;

constexpr double in_the_way = 0.4;  // of `near`
constexpr double worth_in_the_way = -1;
constexpr double worth_of_nothing = -0.4;
constexpr double worth_in_the_dark = 0.1;  // of what it would be worth in the light

constexpr double grey = 0.5;  // albedo: as bright as that in the usual light is bright enough

double worth_of_ray(const Tracer& tracer, const LookUp& light, glm::vec3 eye, glm::vec3 direction, double near) {
    const Hit hit = tracer.closest_hit(eye, direction);
    if (!hit.found()) return worth_of_nothing;
    const auto distance = static_cast<double>(hit.distance);
    if (distance < in_the_way * near) return worth_in_the_way;
    const Surface surface = tracer.surface(hit, direction);
    if (!surface.front) return worth_of_nothing;
    const Scene& scene = tracer.scene();
    const glm::vec3 albedo = surface_at(scene, *surface.mesh, hit.id.triangle, hit.barycentric).albedo;
    const glm::vec3 lit = surface_irradiance(light, scene.origin + glm::dvec3(surface.position), surface.normal);
    const double bright = brightness(luminance(albedo * lit) / grey, light);
    return distance / (distance + near) * (worth_in_the_dark + (1 - worth_in_the_dark) * bright);
}

}  // namespace

double brightness(double irradiance, const LookUp& light) {
    const double usual = luminance(light.volume->usual_light);
    if (!(usual > 0)) return 1;
    return std::clamp(1 + 0.5 * std::log10(std::max(irradiance / usual, 1e-9)), 0.0, 1.0);
}

Panorama look_round(const Tracer& tracer, const LookUp& light, glm::vec3 eye, double near,
                    const Directions& directions) {
    Panorama panorama{directions, {}};
    panorama.worth.reserve(static_cast<std::size_t>(directions.yaws) * static_cast<std::size_t>(directions.pitches));
    for (int pitch = 0; pitch < directions.pitches; ++pitch) {
        for (int yaw = 0; yaw < directions.yaws; ++yaw) {
            const glm::vec3 direction(directions.at(yaw, pitch));
            panorama.worth.push_back(static_cast<float>(worth_of_ray(tracer, light, eye, direction, near)));
        }
    }
    return panorama;
}

double worth_of_view(const Panorama& panorama, int yaw, int pitch) {
    const Directions& all = panorama.directions;
    const int aside = static_cast<int>(half_width_deg * all.yaws / 360);
    const int above = static_cast<int>(half_height_deg / all.pitch_step_deg);
    double sum = 0;
    double seen = 0;
    double squares = 0;
    int count = 0;
    int surfaces = 0;
    for (int row = std::max(pitch - above, 0); row <= std::min(pitch + above, all.pitches - 1); ++row) {
        for (int column = yaw - aside; column <= yaw + aside; ++column) {
            const int wrapped = (column + all.yaws) % all.yaws;
            const auto worth = static_cast<double>(panorama.worth[static_cast<std::size_t>(row * all.yaws + wrapped)]);
            ++count;
            sum += worth;
            if (worth < 0) continue;
            ++surfaces;
            seen += worth;
            squares += worth * worth;
        }
    }
    if (surfaces == 0) return sum / count;
    const double mean = seen / surfaces;
    return sum / count + std::sqrt(std::max(0.0, squares / surfaces - mean * mean));
}

}  // namespace lightgrid
