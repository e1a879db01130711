#include "tools/lit_level.h"

#include "core/parallel.h"
#include "core/sampling.h"
#include "core/scene.h"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace lightgrid {
namespace {

constexpr int most_layers = 32;  // of what lets light through, behind one another

struct Look {
    glm::vec3 radiance{0};
    float depth = std::numeric_limits<float>::infinity();  // along the ray
    bool section = false;
};

/// What is seen along a ray; with `cut` it starts on a cut, which may go through a solid.
Look look(const LitLevel& level, glm::dvec3 from, glm::dvec3 direction, bool cut) {
    const Scene& scene = level.tracer->scene();
    Look seen;
    if (cut && looks_solid(*level.tracer, from)) {
        seen.section = true;
        seen.depth = 0;
        return seen;
    }
    const glm::vec3 along(direction);
    const glm::vec3 origin(from - scene.origin);
    glm::vec3 through(1);
    Hit hit;
    for (int layer = 0; layer < most_layers && through != glm::vec3(0); ++layer) {
        hit = level.tracer->closest_hit(origin, along, std::numeric_limits<float>::infinity(), hit);
        if (!hit.found()) {
            seen.radiance += through * level.environment->radiance(along);
            break;
        }
        if (layer == 0) seen.depth = hit.distance;
        const Surface surface = level.tracer->surface(hit, along);
        const SurfacePoint point = surface_at(scene, *surface.mesh, hit.id.triangle, hit.barycentric);
        const glm::vec3 normal = surface.front ? surface.normal : -surface.normal;
        const glm::dvec3 position = glm::dvec3(surface.position) + scene.origin;
        const glm::vec3 irradiance = glm::max(level.sampler->irradiance(position, normal, level.look_up), 0.0F);
        seen.radiance += through * reflected_share(point) * irradiance * std::numbers::inv_pi_v<float>;
        const bool emits = surface.front || scene.materials[surface.mesh->material].double_sided;
        if (emits) seen.radiance += through * point.alpha * point.emission;
        through *= passed_share(point);
    }
    return seen;
}

}  // namespace

Camera Camera::looking_at(glm::dvec3 eye, glm::dvec3 target, double horizontal_angle_deg) {
    Camera camera;
    camera.eye = eye;
    camera.forward = glm::normalize(target - eye);
    const glm::dvec3 sky = std::abs(camera.forward.y) > 0.999 ? glm::dvec3(0, 0, -1) : glm::dvec3(0, 1, 0);
    camera.right = glm::normalize(glm::cross(camera.forward, sky));
    camera.up = glm::cross(camera.right, camera.forward);
    camera.half_width = std::tan(glm::radians(horizontal_angle_deg) / 2);
    return camera;
}

Camera Camera::around(const Box& box, glm::dvec3 direction, double horizontal_angle_deg, double aspect) {
    // The frame is fitted to the corners by halving the interval of distances.
    double near = 0;
    double far = 100 * glm::length(box.size());
    const glm::dvec3 back = -glm::normalize(direction);
    Camera camera;
    for (int step = 0; step < 60; ++step) {
        const double distance = 0.5 * (near + far);
        camera = looking_at(box.center() + distance * back, box.center(), horizontal_angle_deg);
        bool fits = true;
        for (int corner = 0; corner < 8; ++corner) {
            const glm::dvec3 pick(corner & 1, corner / 2 & 1, corner / 4);
            const glm::dvec3 seen = camera.project(box.min + pick * box.size());
            fits = fits && seen.z > 0 && std::abs(seen.x) < 0.95 && std::abs(seen.y) < 0.95 / aspect;
        }
        (fits ? far : near) = distance;
    }
    return camera;
}

Camera::Ray Camera::ray(glm::dvec2 at) const {
    const glm::dvec3 aside = half_width * (at.x * right + at.y * up);
    Ray ray = orthographic ? Ray{eye + aside, forward} : Ray{eye, glm::normalize(forward + aside)};
    if (cut) {
        const double towards = -glm::dot(cut->normal, ray.direction);
        const double above = glm::dot(cut->normal, ray.origin) - cut->offset;
        if (above > 0 && towards > 0) ray.origin += above / towards * ray.direction;
    }
    return ray;
}

glm::dvec3 Camera::project(glm::dvec3 position) const {
    const glm::dvec3 offset = position - eye;
    const double depth = glm::dot(offset, forward);
    const double scale = half_width * (orthographic ? 1 : depth);
    return {glm::dot(offset, right) / scale, glm::dot(offset, up) / scale, depth};
}

View render(const LitLevel& level, const Camera& camera, glm::ivec2 size, int samples) {
    const std::size_t count = static_cast<std::size_t>(size.x) * size.y;
    View view{{size.x, size.y, std::vector<glm::vec3>(count)},
              std::vector<float>(count),
              std::vector<float>(count, std::numeric_limits<float>::infinity())};
    for_each_index(static_cast<std::size_t>(size.y), [&](std::size_t y) {
        for (int x = 0; x < size.x; ++x) {
            const std::size_t pixel = y * size.x + x;
            const auto ray_at = [&](double dx, double dy) {
                return camera.ray({2 * (x + dx) / size.x - 1, (size.y - 2 * (static_cast<double>(y) + dy)) / size.x});
            };
            glm::dvec3 sum(0);
            int inside = 0;
            for (int i = 0; i < samples * samples; ++i) {
                const glm::ivec2 place(i % samples, i / samples);
                const Camera::Ray ray = ray_at((place.x + 0.5) / samples, (place.y + 0.5) / samples);
                const Look seen = look(level, ray.origin, ray.direction, camera.cut.has_value());
                sum += glm::dvec3(seen.radiance);
                inside += seen.section ? 1 : 0;
            }
            const int lit = samples * samples - inside;
            view.light.pixels[pixel] = lit > 0 ? glm::vec3(sum / static_cast<double>(lit)) : glm::vec3(0);
            view.section[pixel] = static_cast<float>(inside) / static_cast<float>(samples * samples);
            const Camera::Ray center = ray_at(0.5, 0.5);
            const Look seen = look(level, center.origin, center.direction, camera.cut.has_value());
            if (std::isfinite(seen.depth)) {
                const glm::dvec3 position = center.origin + static_cast<double>(seen.depth) * center.direction;
                view.depth[pixel] = static_cast<float>(glm::dot(position - camera.eye, camera.forward));
            }
        }
    });
    return view;
}

glm::vec3 mean_irradiance(const Sampler& sampler, glm::dvec3 position) {
    const Sample sample = sampler.sample(position);
    // Of all bands only the first has a mean over the sphere: A_0 L_0 Y_00 = sqrt(pi) / 2 L_0.
    return sample.sh.empty() ? glm::vec3(0) : 0.5F * std::sqrt(std::numbers::pi_v<float>) * sample.sh[0];
}

bool looks_solid(const Tracer& tracer, glm::dvec3 position) {
    constexpr std::array<glm::vec3, 6> axes{{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}};
    const glm::vec3 from(position - tracer.scene().origin);
    int backs = 0;
    for (const glm::vec3& axis : axes) {
        const Hit hit = tracer.closest_hit(from, axis);
        if (hit.found() && !tracer.surface(hit, axis).front) ++backs;
    }
    return backs >= 4;
}

float automatic_exposure(const RadianceImage& light) {
    double sum = 0;
    std::size_t seen = 0;
    for (const glm::vec3& pixel : light.pixels) {
        const float bright = luminance(pixel);
        if (!(bright > 0)) continue;
        sum += std::log(static_cast<double>(bright));
        ++seen;
    }
    return seen == 0 ? 1.0F : static_cast<float>(0.16 / std::exp(sum / static_cast<double>(seen)));
}

glm::vec3 tone_map(glm::vec3 radiance, float exposure) {
    const glm::vec3 x = glm::max(radiance * exposure, 0.0F);
    const glm::vec3 film = glm::clamp(x * (2.51F * x + 0.03F) / (x * (2.43F * x + 0.59F) + 0.14F), 0.0F, 1.0F);
    const glm::vec3 curved = 1.055F * glm::pow(film, glm::vec3(1 / 2.4F)) - 0.055F;
    return glm::mix(curved, 12.92F * film, glm::lessThan(film, glm::vec3(0.0031308F)));
}

}  // namespace lightgrid
