#include "core/sun_sky.h"

#include "core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace lightgrid {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double sun_angular_radius = 0.5 * 0.533 * pi / 180;

double radians(double degrees) {
    return degrees * pi / 180;
}

/// CIE XYZ to linear Rec.709 with its white point D65 (ITU-R BT.709; IEC 61966-2-1).
glm::dvec3 rec709_from_xyz(glm::dvec3 xyz) {
    return {3.2404542 * xyz.x - 1.5371385 * xyz.y - 0.4985314 * xyz.z,
            -0.9692660 * xyz.x + 1.8760108 * xyz.y + 0.0415560 * xyz.z,
            0.0556434 * xyz.x - 0.2040259 * xyz.y + 1.0572252 * xyz.z};
}

// ---- Sky

/// Perez' function of the angle from the zenith and the angle from the sun.
struct Perez {
    double a, b, c, d, e;

    [[nodiscard]] double operator()(double cos_zenith, double cos_sun) const {
        const double from_sun = std::acos(std::clamp(cos_sun, -1.0, 1.0));
        return (1 + a * std::exp(b / cos_zenith)) * (1 + c * std::exp(d * from_sun) + e * cos_sun * cos_sun);
    }
};

/// Preetham et al., appendix A.2.
Perez luminance_distribution(double t) {
    return {0.1787 * t - 1.4630, -0.3554 * t + 0.4275, -0.0227 * t + 5.3251, 0.1206 * t - 2.5771, -0.0670 * t + 0.3703};
}
Perez x_distribution(double t) {
    return {-0.0193 * t - 0.2592, -0.0665 * t + 0.0008, -0.0004 * t + 0.2125, -0.0641 * t - 0.8989,
            -0.0033 * t + 0.0452};
}
Perez y_distribution(double t) {
    return {-0.0167 * t - 0.2608, -0.0950 * t + 0.0092, -0.0079 * t + 0.2102, -0.0441 * t - 1.6537,
            -0.0109 * t + 0.0529};
}

/// cd/m^2; s is the sun's angle from the zenith.
double zenith_luminance(double t, double s) {
    const double chi = (4.0 / 9 - t / 120) * (pi - 2 * s);
    return 1000 * ((4.0453 * t - 4.9710) * std::tan(chi) - 0.2155 * t + 2.4192);
}
double zenith_x(double t, double s) {
    return ((0.00166 * s - 0.00375) * s + 0.00209) * s * t * t +
           (((-0.02903 * s + 0.06377) * s - 0.03202) * s + 0.00394) * t +
           (((0.11693 * s - 0.21196) * s + 0.06052) * s + 0.25886);
}
double zenith_y(double t, double s) {
    return ((0.00275 * s - 0.00610) * s + 0.00317) * s * t * t +
           (((-0.04214 * s + 0.08970) * s - 0.04153) * s + 0.00516) * t +
           (((0.15346 * s - 0.26756) * s + 0.06670) * s + 0.26688);
}

// ---- Sun

/// The 1931 colour matching functions within their own measurement noise: Wyman, Sloan, Shirley, "Simple Analytic
/// Approximations to the CIE XYZ Color Matching Functions", 2013, multi-lobe fit. Wavelength in nm.
glm::dvec3 color_matching(double wavelength) {
    const auto lobe = [&](double peak, double below, double above) {
        const double x = (wavelength - peak) / (wavelength < peak ? below : above);
        return std::exp(-0.5 * x * x);
    };
    return {1.056 * lobe(599.8, 37.9, 31.0) + 0.362 * lobe(442.0, 16.0, 26.7) - 0.065 * lobe(501.1, 20.4, 26.2),
            0.821 * lobe(568.8, 46.9, 40.5) + 0.286 * lobe(530.9, 16.3, 31.1),
            1.217 * lobe(437.0, 11.8, 36.0) + 0.681 * lobe(459.0, 26.0, 13.8)};
}

/// Planck's law up to a factor.
double black_body(double wavelength_nm, double kelvin) {
    constexpr double second_radiation_constant = 1.438777e7;  // nm K
    return std::pow(wavelength_nm, -5) / std::expm1(second_radiation_constant / (wavelength_nm * kelvin));
}

/// 1/cm, every 10 nm from 450 nm (Leckner, "The Spectral Distribution of Solar Radiation at the Earth's Surface",
/// 1978).
constexpr std::array ozone_absorption{0.003, 0.006, 0.009, 0.014, 0.021, 0.030, 0.040, 0.048, 0.063, 0.075,
                                      0.085, 0.103, 0.120, 0.120, 0.115, 0.125, 0.120, 0.105, 0.090, 0.079,
                                      0.067, 0.057, 0.048, 0.036, 0.028, 0.023, 0.018, 0.014};

/// Relative length of the way through the air (Kasten 1965).
double air_mass(double elevation_deg) {
    return 1 / (std::sin(radians(elevation_deg)) + 0.15 * std::pow(3.885 + elevation_deg, -1.253));
}

double transmittance(double wavelength_nm, double turbidity, double mass) {
    const double micrometres = 1e-3 * wavelength_nm;
    const double rayleigh = 0.008735 * std::pow(micrometres, -4.08);
    const double aerosol = (0.04608 * turbidity - 0.04586) * std::pow(micrometres, -1.3);
    const auto band = static_cast<int>(std::lround((wavelength_nm - 450) / 10));
    const bool absorbs = band >= 0 && band < static_cast<int>(ozone_absorption.size());
    const double ozone = absorbs ? 0.35 * ozone_absorption[band] : 0;
    return std::exp(-(rayleigh + aerosol + ozone) * mass);
}

void check(const SunSky& sun_sky) {
    const auto check_range = [](const char* what, float value, float low, float high, const char* remedy) {
        if (!(value >= low && value <= high))
            throw Error(fmt::format("{} {} is not between {} and {}", what, value, low, high), "sun and sky", remedy);
    };
    check_range("elevation", sun_sky.elevation_deg, 0, 90, "The model knows no night: keep the sun above the horizon.");
    check_range("turbidity", sun_sky.turbidity, 1.7F, 10, "2 is clear, 3 usual, 6 hazy.");
    for (int i = 0; i < 3; ++i) check_range("ground albedo", sun_sky.ground_albedo[i], 0, 1, "");
    if (!std::isfinite(sun_sky.azimuth_deg)) throw Error("azimuth is not finite", "sun and sky");
}

glm::vec3 in_gamut(glm::dvec3 color) {
    return glm::vec3(glm::max(color, glm::dvec3(0)));
}

}  // namespace

glm::vec3 sun_direction(const SunSky& sun_sky) {
    const double elevation = radians(sun_sky.elevation_deg);
    const double azimuth = radians(sun_sky.azimuth_deg);
    return glm::vec3(std::cos(elevation) * std::sin(azimuth), std::sin(elevation),
                     -std::cos(elevation) * std::cos(azimuth));
}

glm::dvec3 sky_radiance(const SunSky& sun_sky, glm::dvec3 direction) {
    const double t = sun_sky.turbidity;
    const double from_zenith = 0.5 * pi - radians(sun_sky.elevation_deg);
    const double cos_sun = glm::dot(direction, glm::dvec3(sun_direction(sun_sky)));
    const auto value = [&](double at_zenith, const Perez& perez) {
        return at_zenith * perez(direction.y, cos_sun) / perez(1, std::cos(from_zenith));
    };
    const double luminance = value(zenith_luminance(t, from_zenith), luminance_distribution(t));
    const double x = value(zenith_x(t, from_zenith), x_distribution(t));
    const double y = value(zenith_y(t, from_zenith), y_distribution(t));
    return rec709_from_xyz(luminance * glm::dvec3(x / y, 1, (1 - x - y) / y));
}

glm::dvec3 sun_illuminance(const SunSky& sun_sky) {
    constexpr double solar_constant_lux = 133300;
    constexpr double solar_temperature = 5778;
    const double mass = air_mass(sun_sky.elevation_deg);
    glm::dvec3 arriving(0);
    double outside = 0;
    for (int wavelength = 380; wavelength <= 780; wavelength += 10) {
        const glm::dvec3 power = black_body(wavelength, solar_temperature) * color_matching(wavelength);
        arriving += transmittance(wavelength, sun_sky.turbidity, mass) * power;
        outside += power.y;
    }
    return rec709_from_xyz(arriving * (solar_constant_lux / outside));
}

Environment make_sun_sky(const SunSky& sun_sky, float rotation_deg, float scale) {
    check(sun_sky);
    constexpr int width = 512;
    constexpr int height = 256;
    RadianceImage image{width, height, std::vector<glm::vec3>(static_cast<std::size_t>(width) * height)};
    glm::dvec3 on_ground = sun_illuminance(sun_sky) * std::sin(radians(sun_sky.elevation_deg));
    for (int y = 0; y < height / 2; ++y) {
        const double polar_angle = pi * (y + 0.5) / height;
        const double row_weight = 2 * pi / width * pi / height * std::sin(polar_angle) * std::cos(polar_angle);
        for (int x = 0; x < width; ++x) {
            const double azimuth = 2 * pi * ((x + 0.5) / width - 0.5);
            const glm::dvec3 direction(std::sin(polar_angle) * std::cos(azimuth), std::cos(polar_angle),
                                       std::sin(polar_angle) * std::sin(azimuth));
            image.at(x, y) = in_gamut(sky_radiance(sun_sky, direction));
            on_ground += row_weight * glm::dvec3(image.at(x, y));
        }
    }
    const glm::vec3 ground = in_gamut(glm::dvec3(sun_sky.ground_albedo) * on_ground / pi);
    std::fill(image.pixels.begin() + width * (height / 2), image.pixels.end(), ground);

    SunDisc sun{sun_direction(sun_sky), static_cast<float>(sun_angular_radius), {}};
    sun.radiance = in_gamut(sun_illuminance(sun_sky) / sun.solid_angle());
    return Environment::from_image(std::move(image), rotation_deg, scale, sun);
}

}  // namespace lightgrid
