#include "viewer/look_up.h"

#include "core/parallel.h"
#include "core/sampling.h"
#include "core/sh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace lightgrid {
namespace {

/// Of the volume's usual light: errors are no larger a share of darker places' light than of this.
constexpr float darkest_share = 0.01F;

double finest_spacing_of(const Volume& volume) {
    double finest = std::numeric_limits<double>::infinity();
    for (const Grid& grid : volume.grids) {
        for (int axis = 0; axis < 3; ++axis) {
            if (grid.counts[axis] > 1) finest = std::min(finest, grid.spacing[axis]);
        }
    }
    return std::isfinite(finest) ? finest : 1;
}

/// Of all bands only the first has a mean over the sphere: A_0 L_0 Y_00 = sqrt(pi) / 2 L_0.
glm::vec3 mean_of(glm::vec3 first_coefficient) {
    return 0.5F * std::sqrt(std::numbers::pi_v<float>) * first_coefficient;
}

glm::vec3 usual_light_of(const Volume& volume) {
    std::vector<glm::vec3> light;
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        const glm::vec3 mean = is_valid(volume.states[slot]) ? mean_of(volume.sh(slot)[0]) : glm::vec3(0);
        if (luminance(mean) > 0) light.push_back(mean);
    }
    if (light.empty()) return glm::vec3(0);
    const auto usual = light.begin() + static_cast<std::ptrdiff_t>(light.size() * 3 / 4);
    std::nth_element(light.begin(), usual, light.end(),
                     [](glm::vec3 a, glm::vec3 b) { return luminance(a) < luminance(b); });
    return *usual;
}

template <std::size_t Size>
std::array<glm::vec3, Size> radiance_of_size(const LookUp& from, glm::dvec3 position) {
    const Volume& volume = from.volume->volume;
    const Sampler::Corners corners = corners_of(from, position);
    std::array<glm::vec3, Size> sh{};
    const std::size_t used = std::min(Size, static_cast<std::size_t>(sh_size(std::min(from.bands, volume.bands))));
    for (int c = 0; c < corners.count; ++c) {
        const std::span<const glm::vec3> probe = volume.sh(corners.slots[static_cast<std::size_t>(c)]);
        const float weight = corners.weights[static_cast<std::size_t>(c)];
        for (std::size_t i = 0; i < used; ++i) sh[i] += weight * probe[i];
    }
    return sh;
}

}  // namespace

LitVolume::LitVolume(Volume of)
    : volume(std::move(of)), sampler(volume), spacing(finest_spacing_of(volume)), usual_light(usual_light_of(volume)) {}

LookUp look_up(const LitVolume& volume, const Settings& settings) {
    return {.volume = &volume,
            .normal_bias = static_cast<float>(bias_in_cells * volume.spacing),
            .filter = settings.filter,
            .bands = settings.bands};
}

Sampler::Corners corners_of(const LookUp& from, glm::dvec3 position) {
    Sampler::Corners corners = from.volume->sampler.corners(position);
    if (from.filter == Filter::nearest && corners.count > 0) {
        const auto nearest = std::max_element(corners.weights.begin(), corners.weights.begin() + corners.count);
        corners.slots[0] = corners.slots[static_cast<std::size_t>(nearest - corners.weights.begin())];
        corners.weights[0] = 1;
        corners.count = 1;
    }
    return corners;
}

Sh9 radiance_sh(const LookUp& from, glm::dvec3 position) {
    return radiance_of_size<std::tuple_size_v<Sh9>>(from, position);
}

Sh36 all_radiance_sh(const LookUp& from, glm::dvec3 position) {
    return radiance_of_size<std::tuple_size_v<Sh36>>(from, position);
}

Sh36 deringed(const Sh36& radiance) {
    Sh36 sh = radiance;
    // It costs as the cube of the bands.
    dering_sh(std::span(sh).first(static_cast<std::size_t>(sh_size(used_bands(sh)))));
    return sh;
}

Volume deringed(Volume volume, int bands) {
    volume.layers.clear();
    const std::size_t size = volume.sh_size();
    const std::size_t used = std::min(size, static_cast<std::size_t>(sh_size(bands)));
    for_each_index(volume.slots(), [&](std::size_t slot) {
        const std::span sh = std::span(volume.coefficients).subspan(slot * size, size);
        std::ranges::fill(sh.subspan(used), glm::vec3(0));
        dering_sh(sh.first(used));
    });
    return volume;
}

int used_bands(const Sh36& sh) {
    const auto last = std::find_if(sh.rbegin(), sh.rend(), [](glm::vec3 c) { return c != glm::vec3(0); });
    return std::max(sh_bands(static_cast<std::size_t>(sh.rend() - last)), 1);
}

glm::vec3 surface_irradiance(const LookUp& from, glm::dvec3 position, glm::vec3 normal) {
    const glm::dvec3 off = position + static_cast<double>(from.normal_bias) * glm::dvec3(normal);
    return glm::max(irradiance_from_sh(radiance_sh(from, off), normal), 0.0F);
}

float surface_error(const LookUp& from, glm::dvec3 position, glm::vec3 normal) {
    const Volume& volume = from.volume->volume;
    const glm::dvec3 off = position + static_cast<double>(from.normal_bias) * glm::dvec3(normal);
    const Sampler::Corners corners = corners_of(from, off);
    double variance = 0;
    float mean = 0;
    for (int c = 0; c < corners.count; ++c) {
        const std::size_t slot = corners.slots[static_cast<std::size_t>(c)];
        const auto weight = static_cast<double>(corners.weights[static_cast<std::size_t>(c)]);
        mean += static_cast<float>(weight) * luminance(mean_of(volume.sh(slot)[0]));
        for (std::size_t axis = 0; axis < axis_normals.size(); ++axis) {
            const auto cosine = static_cast<double>(std::max(glm::dot(axis_normals[axis], normal), 0.0F));
            const auto error = static_cast<double>(luminance(volume.axis_errors[axis_normals.size() * slot + axis]));
            variance += weight * weight * cosine * cosine * error * error;
        }
    }
    const float light = std::max(mean, darkest_share * luminance(from.volume->usual_light));
    return light > 0 ? static_cast<float>(std::sqrt(variance)) / light : 0.0F;
}

glm::vec3 mean_irradiance_at(const LookUp& from, glm::dvec3 position) {
    return mean_of(radiance_sh(from, position)[0]);
}

}  // namespace lightgrid
