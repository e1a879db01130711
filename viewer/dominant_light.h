#pragma once

#include <glm/glm.hpp>

#include <span>

namespace lightgrid {

/// Light at a point as one distant light and an even rest: what a contact shadow needs to know.
struct DominantLight {
    glm::vec3 direction{0, 1, 0};  // towards the light, unit length; +Y where there is none
    glm::vec3 illuminance{0};      // of the light, on a surface that faces it: lux, not negative
    glm::vec3 ambient{0};          // radiance of the rest, the same from everywhere: cd/m^2, not negative
    float share = 0;               // of the light's luminance in all that passes the point, [0, 1]
};

/// The least-squares fit of c delta(w - d) + a to the light's SH, colour by colour. d is where the linear band of the
/// luminance points. Bands above 0 see only the light: with L_i = c Y_i(d) and sum over them of Y_i(d)^2 =
/// (bands^2 - 1) / (4 pi),
///
///   c = 4 pi / (bands^2 - 1) sum_(i > 0) L_i Y_i(d),   a = (L_0 - c Y_0) / (2 sqrt(pi)),
///
/// c kept within what makes neither negative.
///
/// Source: the idea is that of Sloan, "Stupid Spherical Harmonics (SH) Tricks", 2008, who fits irradiance.
///
/// radiance  bands^2 coefficients of incident radiance; with one band all light is ambient
[[nodiscard]] DominantLight dominant_light(std::span<const glm::vec3> radiance);

/// How dark the shadow of the dominant light is on a surface that faces `normal`: its share of the irradiance there,
/// c cos / (c cos + pi a) by luminance, [0, 1].
[[nodiscard]] float shadow_strength(const DominantLight& light, glm::vec3 normal) noexcept;

}  // namespace lightgrid
