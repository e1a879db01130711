#include "viewer/exposure.h"

#include "core/sampling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace lightgrid {
namespace {

constexpr double shown_grey = 0.16;
/// How far the eye adapts to where it is: 0 not at all, 1 wholly.
constexpr double adaptation = 0.8;
/// Beyond this ratio to the whole volume's light the eye adapts no further.
constexpr double widest = 50;
/// Where light is looked at, in cells before the eye.
constexpr std::array<double, 4> distances{0, 1, 2, 4};

/// Luminance of albedo times area, and area.
struct AlbedoSum {
    double reflected = 0;
    double area = 0;

    void add(const AlbedoSum& other, double scale) {
        reflected += scale * other.reflected;
        area += scale * other.area;
    }
};

AlbedoSum albedo_of(const Scene& scene, const Mesh& mesh) {
    AlbedoSum sum;
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
        const glm::uvec3 corners = mesh.triangles[i];
        const glm::vec3 a = mesh.positions[corners.x];
        const auto area =
            static_cast<double>(glm::length(glm::cross(mesh.positions[corners.y] - a, mesh.positions[corners.z] - a)));
        sum.reflected += area * luminance(surface_at(scene, mesh, i, glm::vec2(1.0F / 3)).albedo);
        sum.area += area;
    }
    return sum;
}

}  // namespace

float mean_albedo(const Scene& scene) {
    AlbedoSum sum;
    for (const int mesh : scene.placed) sum.add(albedo_of(scene, scene.meshes[static_cast<std::size_t>(mesh)]), 1);
    std::vector<AlbedoSum> models(scene.models.size());
    for (std::size_t i = 0; i < models.size(); ++i) {
        for (const int mesh : scene.models[i].meshes) {
            models[i].add(albedo_of(scene, scene.meshes[static_cast<std::size_t>(mesh)]), 1);
        }
    }
    for (const Instance& instance : scene.instances) {
        // By as much its areas grow, unless it is stretched; then, about.
        const double growth = std::cbrt(std::abs(glm::determinant(glm::dmat3(glm::mat3(instance.to_level)))));
        sum.add(models[static_cast<std::size_t>(instance.model)], growth * growth);
    }
    return sum.area > 0 ? std::max(static_cast<float>(sum.reflected / sum.area), grey_albedo) : grey_albedo;
}

float automatic_exposure_at(const LookUp& light, const Pose& pose, float albedo) {
    const double usual = luminance(light.volume->usual_light);
    if (!(usual > 0)) return 1;
    double sum = 0;
    for (const double distance : distances) {
        const glm::dvec3 at = pose.eye + distance * light.volume->spacing * forward(pose);
        const double here = luminance(mean_irradiance_at(light, at));
        sum += std::log(std::clamp(here / usual, 1 / widest, widest));
    }
    const double adapted = usual * std::exp(adaptation * sum / distances.size());
    const double shown = std::sqrt(static_cast<double>(grey_albedo) * static_cast<double>(albedo));
    return static_cast<float>(shown_grey * std::numbers::pi / (shown * adapted));
}

float exposure_of(const Settings& settings, const LookUp& light, const Pose& pose, float albedo) {
    const bool measured = settings.automatic_exposure && light.volume != nullptr;
    const float base = measured ? automatic_exposure_at(light, pose, albedo) : 1.0F;
    return base * std::exp2(std::clamp(settings.exposure_stops, -most_stops, most_stops));
}

}  // namespace lightgrid
