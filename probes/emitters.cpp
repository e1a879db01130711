#include "probes/emitters.h"

#include <cmath>

namespace lightgrid {
namespace {

/// Points of a triangle at which a textured emitter's power is estimated (a wrong estimate costs noise, not bias).
constexpr int power_samples = 16;

float mean_emission(const Scene& scene, const Mesh& mesh, std::uint32_t triangle) {
    const Material& material = scene.materials[mesh.material];
    const int samples =
        material.emission_texture.used() || material.alpha_mode != AlphaMode::opaque ? power_samples : 1;
    double sum = 0;
    for (int i = 0; i < samples; ++i) {
        const glm::vec2 where = triangle_point(sobol_point(static_cast<std::uint32_t>(i), 0));
        const SurfacePoint point = surface_at(scene, mesh, triangle, where);
        sum += luminance(point.alpha * point.emission);
    }
    return static_cast<float>(sum / samples);
}

double double_area(const Tracer::Corners& corners) {
    return glm::length(glm::cross(corners.b - corners.a, corners.c - corners.a));
}

}  // namespace

Emitters::Emitters(const Tracer& tracer) : tracer_(&tracer) {
    const Scene& scene = tracer.scene();
    std::vector<double> power;
    const auto add = [&](const std::vector<int>& meshes, std::uint32_t instance) {
        std::vector<std::uint32_t>& first = first_.emplace_back(meshes.size(), SurfaceId::none);
        for (std::uint32_t geometry = 0; geometry < meshes.size(); ++geometry) {
            const Mesh& mesh = scene.meshes[meshes[geometry]];
            const Material& material = scene.materials[mesh.material];
            if (!material.emits()) continue;
            first[geometry] = static_cast<std::uint32_t>(triangles_.size());
            for (std::uint32_t triangle = 0; triangle < mesh.triangles.size(); ++triangle) {
                const SurfaceId id{instance, geometry, triangle};
                const double area = 0.5 * double_area(tracer.corners(id));
                triangles_.push_back({id, area});
                power.push_back(area * mean_emission(scene, mesh, triangle) * (material.double_sided ? 2 : 1));
            }
        }
    };
    add(scene.placed, SurfaceId::none);
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
        add(scene.models[scene.instances[i].model].meshes, static_cast<std::uint32_t>(scene.placed.size()) + i);
    }
    table_ = AliasTable(power);
}

float Emitters::pdf_by_area(std::uint32_t index) const noexcept {
    return static_cast<float>(table_.probability(index) / triangles_[index].area);
}

Emitters::Sample Emitters::sample(glm::vec3 receiver, double pick, glm::vec2 where) const noexcept {
    const std::uint32_t index = table_.sample(pick);
    const glm::vec2 barycentric = triangle_point(where);
    const Hit hit{triangles_[index].id, 0, barycentric};
    Surface surface = tracer_->surface(hit, glm::vec3(0));
    const glm::vec3 to_emitter = surface.position - receiver;
    const float distance_squared = glm::dot(to_emitter, to_emitter);
    const float cosine = -glm::dot(to_emitter, surface.normal) / std::sqrt(distance_squared);
    if (cosine == 0 || !(distance_squared > 0)) return {};

    const Material& material = tracer_->scene().materials[surface.mesh->material];
    Sample sample;
    sample.id = hit.id;
    surface.offset += std::sqrt(distance_squared) * 0x1p-20F;  // Embree's rounding at the far end grows with the ray
    sample.position = surface.leave(-to_emitter);
    sample.pdf = pdf_by_area(index) * distance_squared / std::abs(cosine);
    if (cosine > 0 || material.double_sided) {
        const SurfacePoint point = surface_at(tracer_->scene(), *surface.mesh, hit.id.triangle, barycentric);
        sample.radiance = point.alpha * point.emission;
    }
    return sample;
}

float Emitters::pdf(glm::vec3 receiver, const Hit& hit, const Surface& surface) const noexcept {
    if (empty()) return 0;
    const std::size_t list =
        hit.id.instance == SurfaceId::none ? 0 : 1 + hit.id.instance - tracer_->scene().placed.size();
    const std::uint32_t first = first_[list][hit.id.geometry];
    if (first == SurfaceId::none) return 0;
    const glm::vec3 to_emitter = surface.position - receiver;
    const float distance_squared = glm::dot(to_emitter, to_emitter);
    const float cosine = std::abs(glm::dot(to_emitter, surface.normal)) / std::sqrt(distance_squared);
    return cosine > 0 ? pdf_by_area(first + hit.id.triangle) * distance_squared / cosine : 0.0F;
}

}  // namespace lightgrid
