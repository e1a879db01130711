#include "probes/emitters.h"

#include "core/sampling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>

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

/// Twice the area, along the normal of the front side.
glm::dvec3 double_area(const Tracer::Corners& corners) {
    const glm::dvec3 cross = glm::cross(corners.b - corners.a, corners.c - corners.a);
    return corners.mirrored ? -cross : cross;
}

/// The same for triangles whose corners are the same, whatever their order.
std::array<double, 9> corner_key(const Tracer::Corners& t) {
    std::array<std::array<double, 3>, 3> corners = {
        {{t.a.x, t.a.y, t.a.z}, {t.b.x, t.b.y, t.b.z}, {t.c.x, t.c.y, t.c.z}}};
    std::sort(corners.begin(), corners.end());
    std::array<double, 9> key;
    for (std::size_t i = 0; i < key.size(); ++i) key[i] = corners[i / 3][i % 3];
    return key;
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
                const double area = 0.5 * glm::length(double_area(tracer.corners(id)));
                triangles_.push_back({id, area, material.double_sided, static_cast<std::uint32_t>(triangles_.size())});
                power.push_back(area * mean_emission(scene, mesh, triangle) * (material.double_sided ? 2 : 1));
            }
        }
    };
    add(scene.placed, SurfaceId::none);
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
        add(scene.models[scene.instances[i].model].meshes, static_cast<std::uint32_t>(scene.placed.size()) + i);
    }
    merge_coincident(power);
    tree_ = tree_of(power);
}

EmitterTree Emitters::tree_of(std::span<const double> power) const {
    std::vector<EmitterTree::Emitter> emitters(triangles_.size());
    for (std::size_t i = 0; i < emitters.size(); ++i) {
        if (!(power[i] > 0)) continue;
        const Tracer::Corners corners = tracer_->corners(triangles_[i].id);
        emitters[i].min = glm::min(glm::min(corners.a, corners.b), corners.c);
        emitters[i].max = glm::max(glm::max(corners.a, corners.b), corners.c);
        emitters[i].normal = glm::normalize(double_area(corners));
        emitters[i].both_sides = triangles_[i].both_sides;
        emitters[i].power = power[i];
    }
    return EmitterTree(emitters);
}

void Emitters::merge_coincident(std::span<double> power) {
    struct Place {
        int material;
        std::array<double, 9> corners;
        std::uint32_t index;

        auto operator<=>(const Place&) const = default;
    };
    std::vector<Place> places;
    places.reserve(triangles_.size());
    for (std::uint32_t i = 0; i < triangles_.size(); ++i) {
        const SurfaceId& id = triangles_[i].id;
        places.push_back({tracer_->mesh(id).material, corner_key(tracer_->corners(id)), i});
    }
    std::sort(places.begin(), places.end());
    for (std::size_t begin = 0, end = 0; begin < places.size(); begin = end) {
        const auto same = [&](const Place& p) {
            return p.material == places[begin].material && p.corners == places[begin].corners;
        };
        Triangle& sampled = triangles_[places[begin].index];
        for (end = begin + 1; end < places.size() && same(places[end]); ++end) {
            Triangle& other = triangles_[places[end].index];
            const bool opposite =
                glm::dot(double_area(tracer_->corners(sampled.id)), double_area(tracer_->corners(other.id))) < 0;
            if (opposite && !sampled.both_sides) {
                sampled.both_sides = true;
                power[places[begin].index] *= 2;
            }
            power[places[end].index] = 0;
            other.sampled_as = places[begin].index;
        }
        for (std::size_t i = begin + 1; i < end; ++i) triangles_[places[i].index].both_sides = sampled.both_sides;
    }
}

std::uint32_t Emitters::index_of(const SurfaceId& id) const noexcept {
    const std::size_t placed = tracer_->scene().placed.size();
    const std::uint32_t first = first_[id.instance == SurfaceId::none ? 0 : 1 + id.instance - placed][id.geometry];
    return first == SurfaceId::none ? SurfaceId::none : first + id.triangle;
}

bool Emitters::emits(const Hit& hit, bool front) const noexcept {
    const std::uint32_t index = index_of(hit.id);
    return index != SurfaceId::none && (front || triangles_[index].both_sides);
}

Emitters::Sample Emitters::sample(const Receiver& receiver, double pick, glm::vec2 where) const noexcept {
    const auto [index, probability] = tree_.draw(receiver, pick);
    if (!(probability > 0)) return {};
    const glm::vec2 barycentric = triangle_point(where);
    const Hit hit{triangles_[index].id, 0, barycentric};
    Surface surface = tracer_->surface(hit, glm::vec3(0));
    const glm::vec3 to_emitter = surface.position - receiver.position;
    const float distance_squared = glm::dot(to_emitter, to_emitter);
    const float cosine = -glm::dot(to_emitter, surface.normal) / std::sqrt(distance_squared);
    if (cosine == 0 || !(distance_squared > 0)) return {};

    Sample sample;
    sample.id = hit.id;
    surface.offset += std::sqrt(distance_squared) * 0x1p-20F;  // Embree's rounding at the far end grows with the ray
    sample.position = surface.leave(-to_emitter);
    sample.pdf = static_cast<float>(probability / triangles_[index].area) * distance_squared / std::abs(cosine);
    if (cosine > 0 || triangles_[index].both_sides) {
        const SurfacePoint point = surface_at(tracer_->scene(), *surface.mesh, hit.id.triangle, barycentric);
        sample.radiance = point.alpha * point.emission;
    }
    return sample;
}

float Emitters::pdf(const Receiver& receiver, const Hit& hit, const Surface& surface) const noexcept {
    if (empty()) return 0;
    const std::uint32_t index = index_of(hit.id);
    if (index == SurfaceId::none) return 0;
    const glm::vec3 to_emitter = surface.position - receiver.position;
    const float distance_squared = glm::dot(to_emitter, to_emitter);
    const float cosine = std::abs(glm::dot(to_emitter, surface.normal)) / std::sqrt(distance_squared);
    if (!(cosine > 0)) return 0;
    const Triangle& sampled = triangles_[triangles_[index].sampled_as];
    const float probability = tree_.probability(receiver, triangles_[index].sampled_as);
    return static_cast<float>(probability / sampled.area) * distance_squared / cosine;
}

}  // namespace lightgrid
