#pragma once

#include "probes/sampler.h"
#include "viewer/settings.h"

#include <glm/glm.hpp>

#include <array>
#include <tuple>
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
    int bands = 3;  // at most
};

/// A third of a cell: clear of the probes behind a wall, and still in the room.
inline constexpr double bias_in_cells = 0.3;

[[nodiscard]] LookUp look_up(const LitVolume& volume, const Settings& settings);

/// The probes that answer at `position`.
[[nodiscard]] Sampler::Corners corners_of(const LookUp& from, glm::dvec3 position);

/// Coefficients of three bands, or of as many as the viewer shows; those of bands that are not used are zero.
using Sh9 = std::array<glm::vec3, 9>;
using Sh36 = std::array<glm::vec3, 36>;
static_assert(std::tuple_size_v<Sh36> == most_bands * most_bands);

/// Of the radiance that arrives at `position`, three bands at most: what surfaces take.
[[nodiscard]] Sh9 radiance_sh(const LookUp& from, glm::dvec3 position);
/// The same with all bands.
[[nodiscard]] Sh36 all_radiance_sh(const LookUp& from, glm::dvec3 position);

/// Windowed so that no normal gets negative light (dering_sh).
[[nodiscard]] Sh36 deringed(const Sh36& radiance);

/// The same at every probe, of no more than so many bands: what lies between probes is a mean of these, so that no
/// normal gets negative light there either. Without layers. In parallel.
[[nodiscard]] Volume deringed(Volume volume, int bands);

/// Up to the last that is not zero; at least 1.
[[nodiscard]] int used_bands(const Sh36& sh);

/// Irradiance on a surface, lux, not negative, looked up `normal_bias` away from it.
[[nodiscard]] glm::vec3 surface_irradiance(const LookUp& from, glm::dvec3 position, glm::vec3 normal);

/// Standard error of surface_irradiance by luminance, as a share of the mean irradiance there (of 1 % of the volume's
/// usual light where that is more). Between the axes along which it is stored, variances are mixed by the squares of the
/// normal's components; probes err each on its own, colours together.
[[nodiscard]] float surface_error(const LookUp& from, glm::dvec3 position, glm::vec3 normal);

/// Mean of the irradiance over all normals: a quarter of the scalar irradiance, lux.
[[nodiscard]] glm::vec3 mean_irradiance_at(const LookUp& from, glm::dvec3 position);

}  // namespace lightgrid
