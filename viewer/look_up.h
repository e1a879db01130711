#pragma once

#include "probes/sampler.h"
#include "viewer/settings.h"

#include <glm/glm.hpp>

#include <array>
#include <vector>

/// Light from a volume as the viewer's settings want it.
namespace lightgrid {

/// A volume that is looked at, with what is worth knowing of it once.
struct LitVolume {
    /// Throws Error for a probe list, which has no cells.
    explicit LitVolume(Volume of);
    LitVolume(const LitVolume&) = delete;
    LitVolume& operator=(const LitVolume&) = delete;

    Volume volume;
    Sampler sampler;
    double spacing = 1;  // the finest between two probes along an axis, metres
    glm::vec3 usual_light{
        0};  // irradiance, mean over directions: that of three quarters of the lit probes is less, lux
};

/// How light is looked up.
struct LookUp {
    const LitVolume* volume = nullptr;
    float normal_bias = 0;  // metres that surfaces of the level look it up away from themselves
    Filter filter = Filter::trilinear;
    int bands = 3;  // at most; not more than 3 are used
};

/// A third of a cell: clear of the probes behind a wall, and still in the room.
inline constexpr double bias_in_cells = 0.3;

[[nodiscard]] LookUp look_up(const LitVolume& volume, const Settings& settings);

/// Coefficients of three bands; those of bands that are not used are zero.
using Sh9 = std::array<glm::vec3, 9>;

/// Of the radiance that arrives at `position`.
[[nodiscard]] Sh9 radiance_sh(const LookUp& from, glm::dvec3 position);

/// Of the irradiance that an object at `position` gets as a whole: E(n) = sum_i values_i Y_i(n).
///
/// dering  windowed so that no normal gets negative light (dering_sh)
[[nodiscard]] Sh9 irradiance_sh(const LookUp& from, glm::dvec3 position, bool dering);

/// Irradiance on a surface, lux, not negative, looked up `normal_bias` away from it.
[[nodiscard]] glm::vec3 surface_irradiance(const LookUp& from, glm::dvec3 position, glm::vec3 normal);

/// Mean of the irradiance over all normals: a quarter of the scalar irradiance, lux.
[[nodiscard]] glm::vec3 mean_irradiance_at(const LookUp& from, glm::dvec3 position);

}  // namespace lightgrid
