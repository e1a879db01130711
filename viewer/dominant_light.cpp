#include "viewer/dominant_light.h"

#include "core/sampling.h"
#include "core/sh.h"

#include <glm/gtc/constants.hpp>

#include <algorithm>
#include <vector>

namespace lightgrid {
namespace {

constexpr double first_basis = 0.28209479177387814;  // Y_00 = 1 / (2 sqrt(pi))

}  // namespace

DominantLight dominant_light(std::span<const glm::vec3> radiance) {
    DominantLight light;
    const glm::vec3 whole = glm::max(radiance[0], 0.0F) / static_cast<float>(first_basis);  // of all directions, lux
    glm::vec3 linear(0);
    if (radiance.size() > 1) linear = {luminance(radiance[3]), luminance(radiance[1]), luminance(radiance[2])};
    const float length = glm::length(linear);
    if (length > 0) {
        light.direction = linear / length;
        std::vector<float> basis(radiance.size());
        sh_basis(sh_bands(radiance.size()), light.direction, std::span(basis));
        glm::dvec3 sum(0);
        for (std::size_t i = 1; i < radiance.size(); ++i)
            sum += static_cast<double>(basis[i]) * glm::dvec3(radiance[i]);
        const glm::dvec3 fit = sum * (4 * glm::pi<double>() / static_cast<double>(radiance.size() - 1));
        light.illuminance = glm::clamp(glm::vec3(fit), glm::vec3(0), whole);
    }
    light.ambient = (whole - light.illuminance) / (4 * glm::pi<float>());
    const float all = luminance(whole);
    if (all > 0) light.share = luminance(light.illuminance) / all;
    return light;
}

float shadow_strength(const DominantLight& light, glm::vec3 normal) noexcept {
    const float lit = luminance(light.illuminance) * std::max(glm::dot(normal, light.direction), 0.0F);
    const float rest = glm::pi<float>() * luminance(light.ambient);
    return lit > 0 ? lit / (lit + rest) : 0.0F;
}

}  // namespace lightgrid
