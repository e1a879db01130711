#include "core/sun_sky.h"

#include "core/error.h"
#include "core/sampling.h"

#include <gtest/gtest.h>

#include "sphere_projection.h"
#include <cmath>
#include <numbers>

namespace lightgrid {
namespace {

constexpr double pi = std::numbers::pi;

double luminance_of(glm::dvec3 color) {
    return 0.2126 * color.r + 0.7152 * color.g + 0.0722 * color.b;
}

SunSky sun_at(float elevation_deg, float turbidity = 3, float azimuth_deg = 180) {
    SunSky sun_sky;
    sun_sky.elevation_deg = elevation_deg;
    sun_sky.azimuth_deg = azimuth_deg;
    sun_sky.turbidity = turbidity;
    return sun_sky;
}

void expect_direction(glm::vec3 got, glm::vec3 wanted) {
    EXPECT_LT(glm::length(got - wanted), 1e-6F) << got.x << ", " << got.y << ", " << got.z;
}

TEST(SunSky, AzimuthIsACompassBearing) {
    expect_direction(sun_direction(sun_at(0, 3, 0)), {0, 0, -1});
    expect_direction(sun_direction(sun_at(0, 3, 90)), {1, 0, 0});
    expect_direction(sun_direction(sun_at(0, 3, 180)), {0, 0, 1});
    expect_direction(sun_direction(sun_at(0, 3, -90)), {-1, 0, 0});
    expect_direction(sun_direction(sun_at(90, 3, 123)), {0, 1, 0});
    expect_direction(sun_direction(sun_at(30, 3, 90)), {std::sqrt(0.75F), 0.5F, 0});
}

TEST(SunSky, DirectSunIsAsBrightAsPublished) {
    // IESNA Lighting Handbook, clear sky: 128 klx exp(-0.21 / sin h). Turbidity 2 is such a sky.
    for (const float elevation : {15.0F, 30.0F, 45.0F, 60.0F, 90.0F}) {
        const double published = 128000 * std::exp(-0.21 / std::sin(elevation * pi / 180));
        EXPECT_NEAR(luminance_of(sun_illuminance(sun_at(elevation, 2))), published, 0.05 * published) << elevation;
    }
}

TEST(SunSky, ZenithIsAsBrightAsPublished) {
    // CIE clear sky, Krochmann 1970, h in degrees; measured skies spread by about a factor of two around it.
    for (const double h : {30.0, 45.0, 60.0}) {
        const double published = 100 + 63 * h + h * (h - 30) * std::exp(0.0346 * (h - 68));
        const double ratio = luminance_of(sky_radiance(sun_at(static_cast<float>(h), 2), {0, 1, 0})) / published;
        EXPECT_GT(ratio, 0.5) << h;
        EXPECT_LT(ratio, 2) << h;
    }
}

TEST(SunSky, ZenithFollowsTheFormula) {
    // Preetham's appendix by hand for turbidity 3 and 60 degrees: chi = 0.419444 x 2.094395, tan chi = 1.205933.
    EXPECT_NEAR(luminance_of(sky_radiance(sun_at(60, 3), {0, 1, 0})), 10413.1, 1);
}

TEST(SunSky, ColoursAreThoseOfADay) {
    const glm::dvec3 zenith = sky_radiance(sun_at(45, 2.5F), {0, 1, 0});
    EXPECT_GT(zenith.b, 1.5 * zenith.r);
    EXPECT_GT(zenith.r, 0);
    const glm::dvec3 high = sun_illuminance(sun_at(80));
    const glm::dvec3 low = sun_illuminance(sun_at(5));
    EXPECT_LT(high.r / high.b, 2);
    EXPECT_GT(low.r / low.b, 5);
    EXPECT_LT(luminance_of(low), 0.1 * luminance_of(high));
}

TEST(SunSky, SkyIsBrightestAtTheSun) {
    const SunSky sun_sky = sun_at(40, 3, 70);
    const glm::dvec3 sun(sun_direction(sun_sky));
    const double at_sun = luminance_of(sky_radiance(sun_sky, sun));
    over_sphere(64, 32, [&](glm::dvec3 d, double) {
        if (d.y <= 0.1) return;
        EXPECT_LE(luminance_of(sky_radiance(sun_sky, d)), at_sun * 1.001);
    });
}

TEST(SunSky, TheDiscHoldsTheIlluminanceOfTheSun) {
    const SunSky sun_sky = sun_at(35, 4, 200);
    const Environment sky = make_sun_sky(sun_sky);
    const glm::vec3 centre = sun_direction(sun_sky);
    // Behind the disc is the sky, half a pixel of which is all that the disc covers.
    const glm::dvec3 disc = glm::dvec3(sky.radiance(centre)) - sky_radiance(sun_sky, centre);
    const double radius = 0.5 * 0.533 * pi / 180;
    const glm::dvec3 wanted = sun_illuminance(sun_sky);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(disc[c] * 2 * pi * (1 - std::cos(radius)), wanted[c], 1e-3 * wanted[c]);
    // Its rim is where it should be, to 1 % of the radius.
    const glm::vec3 aside = glm::normalize(glm::cross(centre, glm::vec3(0, 1, 0)));
    const auto beside = [&](double angle) {
        return sky.radiance(static_cast<float>(std::cos(angle)) * centre + static_cast<float>(std::sin(angle)) * aside);
    };
    EXPECT_GT(beside(0.99 * radius).r, 1e6F);
    EXPECT_LT(beside(1.01 * radius).r, 1e6F);
}

TEST(SunSky, IrradianceFromAboveIsSkyPlusSun) {
    const SunSky sun_sky = sun_at(35, 3, 200);
    const Environment sky = make_sun_sky(sun_sky);
    glm::dvec3 wanted = sun_illuminance(sun_sky) * std::sin(35 * pi / 180);
    over_sphere(1024, 512, [&](glm::dvec3 d, double weight) {
        if (d.y > 0) wanted += sky_radiance(sun_sky, d) * (d.y * weight);
    });
    glm::dvec3 got(0);
    constexpr int count = 65536;
    RandomStream random(6);
    for (std::uint32_t i = 0; i < count; ++i) {
        const Environment::Sample sample = sky.sample({random.next(), sobol_point(i, 77)});
        got += glm::dvec3(sample.radiance) * (std::max(sample.direction.y, 0.0F) / sample.pdf / double{count});
    }
    // The choice between sky and sun is random: at most half the range of E/p, 1/(2 x 256), twice for 3 sigma.
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(got[c], wanted[c], 0.01 * wanted[c]);
}

TEST(SunSky, GroundReflectsWhatFallsOnIt) {
    SunSky sun_sky = sun_at(50);
    sun_sky.ground_albedo = {0.1F, 0.2F, 0.4F};
    const Environment sky = make_sun_sky(sun_sky);
    glm::dvec3 falling = sun_illuminance(sun_sky) * std::sin(50 * pi / 180);
    over_sphere(1024, 512, [&](glm::dvec3 d, double weight) {
        if (d.y > 0) falling += sky_radiance(sun_sky, d) * (d.y * weight);
    });
    const glm::vec3 ground = sky.radiance({0, -1, 0});
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(ground[c], falling[c] * sun_sky.ground_albedo[c] / pi, 1e-3 * ground[c]) << c;
    sun_sky.ground_albedo = glm::vec3(0);
    EXPECT_EQ(make_sun_sky(sun_sky).radiance({0, -1, 0}), glm::vec3(0));
}

TEST(SunSky, TurnsAndScalesAsAWhole) {
    const SunSky sun_sky = sun_at(30, 3, 90);  // at +X
    const Environment turned = make_sun_sky(sun_sky, 90, 0.5F);
    const Environment direct = make_sun_sky(sun_at(30, 3, 0));  // at -Z
    const glm::vec3 sun = sun_direction(sun_at(30, 3, 0));
    for (const glm::vec3 d : {sun, glm::vec3(0, 1, 0), glm::normalize(glm::vec3(1, 1, 1)), glm::vec3(0, -1, 0)}) {
        const glm::vec3 a = turned.radiance(d);
        const glm::vec3 b = 0.5F * direct.radiance(d);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], 1e-3F * b[c]);
    }
}

TEST(SunSky, EverySkyInRangeIsUsable) {
    for (const float turbidity : {1.7F, 2.0F, 3.0F, 6.0F, 10.0F})
        for (const float elevation : {0.0F, 0.5F, 10.0F, 45.0F, 89.0F, 90.0F}) {
            const Environment sky = make_sun_sky(sun_at(elevation, turbidity, 10));
            EXPECT_FALSE(sky.is_black());
            EXPECT_GT(sky.sample({0.99F, 0.5F, 0.5F}).pdf, 0);
        }
}

TEST(SunSky, RefusesWhatTheModelDoesNotKnow) {
    EXPECT_THROW((void)make_sun_sky(sun_at(-1)), Error);
    EXPECT_THROW((void)make_sun_sky(sun_at(91)), Error);
    EXPECT_THROW((void)make_sun_sky(sun_at(45, 1)), Error);
    EXPECT_THROW((void)make_sun_sky(sun_at(45, 11)), Error);
    EXPECT_THROW((void)make_sun_sky(sun_at(NAN)), Error);
    EXPECT_THROW((void)make_sun_sky(sun_at(45, 3, NAN)), Error);
    SunSky bright = sun_at(45);
    bright.ground_albedo.g = 1.5F;
    EXPECT_THROW((void)make_sun_sky(bright), Error);
}

}  // namespace
}  // namespace lightgrid
