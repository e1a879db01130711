#pragma once

#include "core/environment.h"

#include <glm/glm.hpp>

namespace lightgrid {

/// A clear to hazy daylight sky with its sun, in absolute units.
struct SunSky {
    float elevation_deg = 45;       // of the sun's centre above the horizon, [0, 90]
    float azimuth_deg = 180;        // compass bearing: 0 is north, -Z; 90 east, +X; 180 south, +Z; any
    float turbidity = 3;            // haze, [1.7, 10]: 2 clear, 3 a usual fine day, 6 and more hazy
    glm::vec3 ground_albedo{0.2F};  // Lambertian ground seen below the horizon, [0, 1]; 0: black
};

/// Towards the centre of the sun, unit length.
[[nodiscard]] glm::vec3 sun_direction(const SunSky& sun_sky);

/// Luminance of the sky at `direction` (above the horizon) in cd/m^2, as linear Rec.709 that may leave the gamut: a
/// component may be negative.
///
/// Source:  Preetham, Shirley, Smits, "A Practical Analytic Model for Daylight", 1999: Perez' five-parameter function
///          for luminance and chromaticity, fitted to simulated atmospheres. It is up to twice as bright as measured clear
///          skies (turbidity 2, the sun at 45 degrees: 25 klx on the ground; IESNA's clear sky has 14), and below
///          turbidity 2 its horizon is far too bright.
[[nodiscard]] glm::dvec3 sky_radiance(const SunSky& sun_sky, glm::dvec3 direction);

/// Illuminance of the direct sun on a surface that faces it, lux, linear Rec.709.
///
/// A black body of 5778 K (the sun's effective temperature), scaled to a luminous solar constant of 133.3 klx (Darula,
/// Kittler, Gueymard, "Reference Luminous Solar Constant and Solar Luminance for Illuminance Calculations", 2005),
/// through the atmosphere of Preetham et al., appendix A.1: Rayleigh scattering, aerosol by Angstrom's law of
/// turbidity, ozone (0.35 cm) along Kasten's optical air mass. Water vapour and mixed gases absorb beyond 690 nm only
/// and are left out.
[[nodiscard]] glm::dvec3 sun_illuminance(const SunSky& sun_sky);

/// Sky, sun and ground as an environment: 512 x 256 pixels and a sun disc 0.533 degrees across. Below the horizon is
/// the ground, lit by the whole sky and the sun. Components outside of the gamut are set to 0.
///
/// rotation_deg, scale  as Environment::from_image
/// Throws Error where a parameter is out of range: the model knows no night.
[[nodiscard]] Environment make_sun_sky(const SunSky& sun_sky, float rotation_deg = 0, float scale = 1);

}  // namespace lightgrid
