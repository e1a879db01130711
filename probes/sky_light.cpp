#include "probes/sky_light.h"

#include "core/parallel.h"
#include "core/sampling.h"

#include <glm/gtc/constants.hpp>

#include <algorithm>
#include <bit>
#include <cmath>

namespace lightgrid {
namespace {

/// Along each side of a texel.
constexpr int looks_along = 4;

/// The octahedral map: the upper half sphere in the diamond in the middle of the square [-1, 1]^2, the lower one in its
/// corners (Praun, Hoppe, "Spherical Parametrization and Remeshing", 2003).
glm::vec2 fold(glm::vec2 p) {
    return (1.0F - glm::abs(glm::vec2(p.y, p.x))) * glm::vec2(std::copysign(1.0F, p.x), std::copysign(1.0F, p.y));
}

glm::vec2 octahedral(glm::vec3 direction) {
    const glm::vec3 a = glm::abs(direction);
    const glm::vec2 p = glm::vec2(direction.x, direction.z) / (a.x + a.y + a.z);
    return direction.y < 0 ? fold(p) : p;
}

glm::vec3 octahedral_direction(glm::vec2 p) {
    const float y = 1 - std::abs(p.x) - std::abs(p.y);
    const glm::vec2 xz = y < 0 ? fold(p) : p;
    return glm::normalize(glm::vec3(xz.x, y, xz.y));
}

constexpr float ray_pdf = 0.25F * glm::one_over_pi<float>();

}  // namespace

SkyLight SkyLight::of_rays(const Environment& environment, float samples_per_ray) {
    SkyLight sky;
    if (environment.is_black()) return sky;
    if (environment.is_uniform()) {
        sky.texels_ = {environment.radiance({0, 1, 0})};
        return sky;
    }
    sky.texels_.resize(std::size_t{texels_along} * texels_along);
    for_each_index(texels_along, [&](std::size_t row) {
        for (int column = 0; column < texels_along; ++column) {
            glm::vec3 sum(0);
            for (int i = 0; i < looks_along * looks_along; ++i) {
                const glm::vec2 inside(i % looks_along, i / looks_along);
                const glm::vec2 place =
                    (glm::vec2(column, row) + (inside + 0.5F) / float{looks_along}) / float{texels_along};
                const Environment::Sample seen = environment.look_up(octahedral_direction(2.0F * place - 1.0F));
                sum += seen.radiance * (ray_pdf / (ray_pdf + samples_per_ray * seen.pdf));
            }
            sky.texels_[row * texels_along + column] = sum / float{looks_along * looks_along};
        }
    });
    return sky;
}

SkyLight::SkyLight(const Environment& environment, float samples_per_ray, std::uint64_t seed)
    : SkyLight(of_rays(environment, samples_per_ray)) {
    if (texels_.size() <= 1) return;
    samples_.resize(samples_drawn);
    constexpr std::uint32_t block = 1024;
    for_each_index(samples_drawn / block, [&](std::size_t task) {
        for (auto i = static_cast<std::uint32_t>(task) * block; i < (task + 1) * block; ++i) {
            // Sets are aligned blocks: nets in the place, and in the choice between image and sun.
            const std::uint64_t choice = mix_bits(seed, 1);
            const float pick = sobol_point(shuffled_index(i, static_cast<std::uint32_t>(choice)), choice).x;
            const Environment::Sample sky = environment.sample({pick, sobol_point(i, seed)});
            if (!(sky.pdf > 0)) continue;
            samples_[i] = {sky.direction, sky.radiance * (samples_per_ray / (ray_pdf + samples_per_ray * sky.pdf))};
        }
    });
}

const glm::vec3& SkyLight::along(glm::vec3 direction) const noexcept {
    if (texels_.size() <= 1) {
        static constexpr glm::vec3 black(0);
        return texels_.empty() ? black : texels_[0];
    }
    const glm::vec2 place = (octahedral(direction) + 1.0F) * (0.5F * texels_along);
    const int x = std::clamp(static_cast<int>(place.x), 0, texels_along - 1);
    const int y = std::clamp(static_cast<int>(place.y), 0, texels_along - 1);
    return texels_[static_cast<std::size_t>(y) * texels_along + x];
}

std::span<const SkyLight::Sample> SkyLight::samples(std::uint64_t pick, std::uint32_t count) const noexcept {
    const std::size_t set = std::min(samples_drawn, std::bit_ceil(count));
    return std::span(samples_).subspan((pick & (samples_drawn / set - 1)) * set, count);
}

}  // namespace lightgrid
