#include "core/environment.h"

#include "core/error.h"
#include "core/sampling.h"

#include <gtest/gtest.h>

#include "sphere_projection.h"
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

namespace lightgrid {
namespace {

constexpr double pi = std::numbers::pi;
constexpr float last_below_one = 0x1.fffffep-1F;

RadianceImage filled(int width, int height, glm::vec3 value) {
    return {width, height, std::vector<glm::vec3>(static_cast<std::size_t>(width) * height, value)};
}

RadianceImage noise(int width, int height, std::uint64_t seed) {
    RadianceImage image = filled(width, height, {});
    RandomStream random(seed);
    for (glm::vec3& pixel : image.pixels) pixel = {random.next(), random.next(), random.next()};
    return image;
}

/// One pixel of 1e6 in a sky of about 1.
RadianceImage bright_pixel(int width, int height, int x, int y) {
    RadianceImage image = noise(width, height, 7);
    image.at(x, y) = glm::vec3(1e6F);
    return image;
}

glm::vec3 direction_of_pixel(const RadianceImage& image, int x, int y) {
    return equirectangular_direction((x + 0.5) / image.width, (y + 0.5) / image.height);
}

/// Bilinear by the words of the header, in double.
glm::dvec3 expected_radiance(const RadianceImage& image, glm::dvec3 direction) {
    const double u = std::atan2(direction.z, direction.x) / (2 * pi) + 0.5;
    const double v = std::acos(std::clamp(direction.y, -1.0, 1.0)) / pi;
    const double x = u * image.width - 0.5;
    const double y = std::clamp(v * image.height - 0.5, 0.0, image.height - 1.0);
    const int left = static_cast<int>(std::floor(x));
    const int above = std::min(static_cast<int>(y), std::max(image.height - 2, 0));
    const auto pixel = [&](int i, int j) {
        return glm::dvec3(image.at((i + image.width) % image.width, std::min(j, image.height - 1)));
    };
    return glm::mix(glm::mix(pixel(left, above), pixel(left + 1, above), x - left),
                    glm::mix(pixel(left, above + 1), pixel(left + 1, above + 1), x - left), y - above);
}

struct Case {
    const char* name;
    Environment environment;
};

std::vector<Case> difficult_environments() {
    const SunDisc sun{glm::normalize(glm::vec3(1, 2, -1)), 0.00465F, glm::vec3(1e9F, 9e8F, 8e8F)};
    RadianceImage lone = filled(16, 8, glm::vec3(0));
    lone.at(3, 5) = {0, 0, 1};
    RadianceImage ramp = filled(64, 32, glm::vec3(0));
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 64; ++x) ramp.at(x, y) = glm::vec3(std::exp2(0.25F * x - 0.5F * y));
    return {{"uniform", Environment::uniform({1, 2, 3})},
            {"noise", Environment::from_image(noise(32, 16, 1), 77)},
            {"one bright pixel", Environment::from_image(bright_pixel(64, 32, 40, 12), -20)},
            {"bright pixel at the pole", Environment::from_image(bright_pixel(64, 32, 5, 0), 0)},
            {"bright pixel at the seam", Environment::from_image(bright_pixel(64, 32, 63, 31), 180)},
            {"one blue pixel in the dark", Environment::from_image(lone)},
            {"twenty powers of two", Environment::from_image(ramp, 10)},
            {"odd size", Environment::from_image(noise(5, 3, 2))},
            {"single column", Environment::from_image(noise(1, 9, 3), 45)},
            {"single row", Environment::from_image(noise(9, 1, 4), 45)},
            {"sun in a dim sky", Environment::from_image(noise(32, 16, 5), 30, 1, sun)},
            {"sun alone", Environment::from_image(filled(2, 1, glm::vec3(0)), 30, 1, sun)},
            {"very faint", Environment::from_image(bright_pixel(32, 16, 9, 9), 0, 1e-14F)},
            {"very bright", Environment::from_image(bright_pixel(32, 16, 9, 9), 0, 1e14F)}};
}

// ---- What is where

TEST(Environment, BlackHasNothingToSample) {
    const Environment black;
    EXPECT_TRUE(black.is_black());
    EXPECT_TRUE(black.is_uniform());
    EXPECT_EQ(black.radiance({0, 1, 0}), glm::vec3(0));
    EXPECT_EQ(black.sample({0.5F, 0.5F, 0.5F}).pdf, 0);
    EXPECT_EQ(black.pdf({0, 1, 0}), 0);
    EXPECT_TRUE(Environment::from_image(filled(4, 2, glm::vec3(0))).is_black());
    EXPECT_TRUE(Environment::from_image(noise(4, 2, 1), 0, 0).is_black());
}

TEST(Environment, AnImageOfOneColourIsUniform) {
    const Environment sky = Environment::from_image(filled(8, 4, {1, 2, 3}), 20, 2);
    EXPECT_TRUE(sky.is_uniform());
    EXPECT_FALSE(sky.is_black());
    EXPECT_EQ(sky.radiance({0, 0, 1}), glm::vec3(2, 4, 6));
    EXPECT_FALSE(Environment::from_image(noise(8, 4, 1)).is_uniform());
}

TEST(Environment, AxesAreWhereTheConventionSays) {
    // Pixel centres on the axes: 4 columns turned by half a pixel (45 degrees), 3 rows, and the poles.
    RadianceImage image = filled(4, 3, glm::vec3(0));
    const std::vector<float> columns{1, 2, 3, 4};  // centres at -135, -45, +45, +135 degrees from +X towards +Z
    for (int x = 0; x < 4; ++x) image.at(x, 1) = glm::vec3(columns[x]);
    for (int x = 0; x < 4; ++x) image.at(x, 0) = glm::vec3(10);
    for (int x = 0; x < 4; ++x) image.at(x, 2) = glm::vec3(20);
    const Environment unturned = Environment::from_image(image);
    EXPECT_FLOAT_EQ(unturned.radiance({1, 0, 0}).r, 2.5F);   // between columns 1 and 2: the centre
    EXPECT_FLOAT_EQ(unturned.radiance({0, 0, 1}).r, 3.5F);   // u grows towards +Z
    EXPECT_FLOAT_EQ(unturned.radiance({-1, 0, 0}).r, 2.5F);  // the seam, between 3 and 0
    EXPECT_FLOAT_EQ(unturned.radiance({0, 0, -1}).r, 1.5F);
    EXPECT_FLOAT_EQ(unturned.radiance({0, 1, 0}).r, 10);
    EXPECT_FLOAT_EQ(unturned.radiance({0, -1, 0}).r, 20);
}

TEST(Environment, EveryPixelIsSeenInItsDirection) {
    const RadianceImage image = noise(24, 12, 3);
    const Environment sky = Environment::from_image(image);
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const glm::vec3 seen = sky.radiance(direction_of_pixel(image, x, y));
            for (int c = 0; c < 3; ++c) EXPECT_NEAR(seen[c], image.at(x, y)[c], 1e-5F) << x << ", " << y;
        }
    }
}

TEST(Environment, IsBilinearBetweenPixelCentres) {
    const RadianceImage image = noise(16, 8, 4);
    const Environment sky = Environment::from_image(image);
    for (std::uint32_t i = 0; i < 10000; ++i) {
        const glm::vec3 direction = sphere_direction(sobol_point(i, 5));
        const glm::dvec3 wanted = expected_radiance(image, direction);
        const glm::vec3 got = sky.radiance(direction);
        // Directions and angles are known to a few 1e-7 rad; a pixel is 0.4 rad, near the pole ever less of arc.
        const double tolerance = 3e-6 / std::max(0.01, std::sqrt(1.0 - direction.y * direction.y));
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(got[c], wanted[c], tolerance) << i;
    }
}

TEST(Environment, TurnsCounterClockwiseSeenFromAbove) {
    // Seen from above, +X to the right, +Z points down: a quarter turn counter-clockwise brings +X to -Z.
    RadianceImage image = filled(360, 180, glm::vec3(0.001F));
    for (const int x : {179, 180})
        for (const int y : {89, 90}) image.at(x, y) = glm::vec3(100);  // around +X
    const SunDisc sun{{1, 0, 0}, 0.01F, glm::vec3(1000)};
    const auto seen = [&](float rotation, glm::vec3 direction) {
        return Environment::from_image(image, rotation, 1, sun).radiance(direction).r;
    };
    EXPECT_NEAR(seen(0, {1, 0, 0}), 1100, 0.1);
    EXPECT_NEAR(seen(90, {0, 0, -1}), 1100, 0.1);
    EXPECT_NEAR(seen(90, {1, 0, 0}), 0.001, 1e-4);
    EXPECT_NEAR(seen(-90, {0, 0, 1}), 1100, 0.1);
    EXPECT_NEAR(seen(180, {-1, 0, 0}), 1100, 0.1);
    EXPECT_NEAR(seen(360, {1, 0, 0}), 1100, 0.1);
    EXPECT_NEAR(seen(3690, {0, 0, -1}), 1100, 0.1);
    EXPECT_NEAR(seen(30, {std::sqrt(0.75F), 0, -0.5F}), 1100, 0.5);
}

TEST(Environment, ScalesImageAndSun) {
    const SunDisc sun{{0, 1, 0}, 0.1F, glm::vec3(10)};
    const RadianceImage image = noise(8, 4, 9);
    const Environment plain = Environment::from_image(image, 15, 1, sun);
    const Environment scaled = Environment::from_image(image, 15, 8, sun);
    for (std::uint32_t i = 0; i < 100; ++i) {
        const glm::vec3 direction = sphere_direction(sobol_point(i, 1));
        EXPECT_EQ(scaled.radiance(direction), 8.0F * plain.radiance(direction));
    }
}

// ---- Sampling

TEST(Environment, DensityOfASampleIsTheDensityOfItsDirection) {
    for (const Case& c : difficult_environments()) {
        RandomStream random(11);
        for (int i = 0; i < 20000; ++i) {
            const Environment::Sample sample = c.environment.sample({random.next(), random.next(), random.next()});
            ASSERT_NEAR(glm::length(sample.direction), 1, 1e-6) << c.name;
            ASSERT_EQ(sample.pdf, c.environment.pdf(sample.direction)) << c.name;
            ASSERT_EQ(sample.radiance, c.environment.radiance(sample.direction)) << c.name;
            ASSERT_TRUE(std::isfinite(sample.pdf)) << c.name;
        }
    }
}

TEST(Environment, EndsOfTheUnitCubeAreSampledToo) {
    for (const Case& c : difficult_environments()) {
        for (const float x : {0.0F, 0.5F, last_below_one})
            for (const float y : {0.0F, 0.5F, last_below_one})
                for (const float z : {0.0F, 0.5F, last_below_one}) {
                    const Environment::Sample sample = c.environment.sample({x, y, z});
                    EXPECT_TRUE(std::isfinite(sample.pdf) && sample.pdf >= 0) << c.name << x << " " << y << " " << z;
                    EXPECT_NEAR(glm::length(sample.direction), 1, 1e-6) << c.name;
                }
    }
}

TEST(Environment, DensityIsPositiveWhereverThereIsLight) {
    for (const Case& c : difficult_environments()) {
        for (std::uint32_t i = 0; i < 20000; ++i) {
            const glm::vec3 direction = sphere_direction(sobol_point(i, 2));
            if (c.environment.radiance(direction) == glm::vec3(0)) continue;
            ASSERT_GT(c.environment.pdf(direction), 0) << c.name;
        }
    }
}

TEST(Environment, DensityIntegratesToOne) {
    for (const Case& c : difficult_environments()) {
        if (std::string(c.name).find("sun") != std::string::npos) continue;  // too small for a grid: see the next
        double sum = 0;
        over_sphere(1024, 1024, [&](glm::dvec3 direction, double solid_angle) {
            sum += c.environment.pdf(direction) * solid_angle;
        });
        // Midpoint rule on 16 x 32 points a pixel or more: 1/(12 x 32^2) of its second difference, mostly at one pixel.
        EXPECT_NEAR(sum, 1, 2e-3) << c.name;
    }
}

TEST(Environment, SunHasItsShareOfTheDensity) {
    const glm::vec3 centre = glm::normalize(glm::vec3(1, 2, -1));
    const SunDisc sun{centre, 0.00465F, glm::vec3(1e6F)};
    const RadianceImage image = filled(2, 1, glm::vec3(3));
    const Environment sky = Environment::from_image(image, 0, 1, sun);
    const double sun_power = 1e6 * pi * 0.00465 * 0.00465;  // of a small disc
    const double share = sun_power / (sun_power + 4 * pi * 3);
    int in_disc = 0;
    constexpr int count = 100000;
    RandomStream random(3);
    for (int i = 0; i < count; ++i) {
        const Environment::Sample sample = sky.sample({random.next(), random.next(), random.next()});
        in_disc += sample.radiance.r > 10 ? 1 : 0;
    }
    const double error = std::sqrt(share * (1 - share) / count);
    EXPECT_NEAR(static_cast<double>(in_disc) / count, share, 4 * error);
    EXPECT_NEAR(sky.pdf(centre), share / (pi * 0.00465 * 0.00465), 1e-3 * sky.pdf(centre));
}

TEST(Environment, SamplesFallAsTheDensitySays) {
    // Pearson's chi-square over bins of equal solid angle; the expected counts by quadrature of the density.
    constexpr int bands = 16, sectors = 32, count = 200000, fine = 48;
    for (const Case& c : difficult_environments()) {
        if (std::string(c.name).find("sun") != std::string::npos) continue;
        std::vector<double> expected(bands * sectors), seen(bands * sectors);
        for (int j = 0; j < bands * fine; ++j) {
            const double y = 1 - 2 * (j + 0.5) / (bands * fine);
            for (int i = 0; i < sectors * fine; ++i) {
                const double azimuth = 2 * pi * (i + 0.5) / (sectors * fine);
                const double r = std::sqrt(1 - y * y);
                expected[j / fine * sectors + i / fine] +=
                    c.environment.pdf({r * std::cos(azimuth), y, r * std::sin(azimuth)}) * 4 * pi /
                    (bands * sectors * fine * fine) * count;
            }
        }
        RandomStream random(5);
        for (int i = 0; i < count; ++i) {
            const glm::vec3 d = c.environment.sample({random.next(), random.next(), random.next()}).direction;
            const int band = std::min(static_cast<int>((1 - d.y) / 2 * bands), bands - 1);
            const double turn = std::atan2(d.z, d.x) / (2 * pi);
            seen[band * sectors + static_cast<int>((turn - std::floor(turn)) * sectors) % sectors] += 1;
        }
        double chi_square = 0;
        int degrees = -1;
        double rare_expected = 0, rare_seen = 0;
        for (int i = 0; i < bands * sectors; ++i) {
            if (expected[i] < 10) {
                rare_expected += expected[i];
                rare_seen += seen[i];
                continue;
            }
            chi_square += (seen[i] - expected[i]) * (seen[i] - expected[i]) / expected[i];
            ++degrees;
        }
        if (rare_expected > 10) {
            chi_square += (rare_seen - rare_expected) * (rare_seen - rare_expected) / rare_expected;
            ++degrees;
        } else {
            EXPECT_LT(rare_seen, 40) << c.name;
        }
        if (degrees < 1) continue;
        // Wilson and Hilferty 1931: the cube root is nearly normal. 4.5 sigma, and quadrature adds a little.
        const double k = degrees;
        const double z = (std::cbrt(chi_square / k) - (1 - 2 / (9 * k))) / std::sqrt(2 / (9 * k));
        EXPECT_LT(z, 4.5) << c.name << ": chi-square " << chi_square << " of " << degrees;
    }
}

TEST(Environment, WeightOfASampleIsBounded) {
    // A grey sky: radiance / pdf is the power but for the difference between polar angle and depth at the poles.
    RadianceImage image = noise(64, 32, 8);
    for (glm::vec3& pixel : image.pixels) pixel = glm::vec3(pixel.r);
    image.at(10, 0) = image.at(11, 16) = glm::vec3(1e6F);
    image.at(12, 1) = image.at(20, 16) = glm::vec3(0);
    const Environment sky = Environment::from_image(image);
    double power = 0;
    over_sphere(1024, 512, [&](glm::dvec3 d, double angle) { power += sky.radiance(d).r * angle; });
    RandomStream random(1);
    for (int i = 0; i < 100000; ++i) {
        const Environment::Sample sample = sky.sample({random.next(), random.next(), random.next()});
        const double weight = sample.radiance.r / sample.pdf / power;
        ASSERT_GT(weight, 0.6);
        ASSERT_LT(weight, 2.1);
    }
}

TEST(Environment, SamplingIntegratesLikeQuadrature) {
    struct Sky {
        const char* name;
        RadianceImage image;
    };
    RadianceImage dark = filled(64, 32, glm::vec3(0.01F));
    dark.at(40, 9) = glm::vec3(1e6F, 5e5F, 2e5F);
    for (const Sky& c :
         {Sky{"noise", noise(64, 32, 2)}, Sky{"one pixel", dark}, Sky{"pole", bright_pixel(64, 32, 3, 0)}}) {
        const Environment sky = Environment::from_image(c.image);
        const Sh9 exact = project(1024, 1024, [&](glm::dvec3 d) { return expected_radiance(c.image, d); });
        constexpr int count = 100000;
        Sh9 mean{}, square{};
        RandomStream random(9);
        for (int i = 0; i < count; ++i) {
            const Environment::Sample sample = sky.sample({random.next(), random.next(), random.next()});
            const std::array<double, 9> basis = sh9_basis(sample.direction);
            for (int k = 0; k < 9; ++k) {
                const glm::dvec3 value = glm::dvec3(sample.radiance) * (basis[k] / sample.pdf);
                mean[k] += value / double{count};
                square[k] += value * value / double{count};
            }
        }
        for (int k = 0; k < 9; ++k) {
            for (int channel = 0; channel < 3; ++channel) {
                const double variance = square[k][channel] - mean[k][channel] * mean[k][channel];
                const double error = std::sqrt(std::max(variance, 0.0) / count);
                // 4.5 standard errors, and 1e-4 of the quadrature.
                EXPECT_NEAR(mean[k][channel], exact[k][channel], 4.5 * error + 1e-4 * exact[0][channel])
                    << c.name << " coefficient " << k;
                EXPECT_LT(error, 0.01 * exact[0][channel]) << c.name;
            }
        }
    }
}

TEST(Environment, EnergyOfTheSunIsRadianceTimesSolidAngle) {
    for (const float radius : {0.00465F, 0.1F, 1.5F}) {
        const SunDisc sun{glm::normalize(glm::vec3(-1, 0.3F, 2)), radius, glm::vec3(3, 2, 1)};
        const Environment sky = Environment::from_image(filled(2, 1, glm::vec3(0)), 130, 1, sun);
        const double solid_angle = 2 * pi * (1 - std::cos(static_cast<double>(radius)));
        EXPECT_NEAR(sun.solid_angle(), solid_angle, 1e-6 * solid_angle);
        glm::dvec3 sum(0);
        constexpr int count = 10000;
        for (std::uint32_t i = 0; i < count; ++i) {
            const Environment::Sample sample = sky.sample({0.5F, sobol_point(i, 4)});
            if (sample.pdf > 0) sum += glm::dvec3(sample.radiance / sample.pdf) / double{count};
        }
        // The sky is constant over the disc: each sample has the exact answer; a few at the rim may fall just outside.
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c], sun.radiance[c] * solid_angle, 1e-3 * sum[c]) << radius;
    }
}

TEST(Environment, StratifiedPointsConvergeFasterThanRandomOnes) {
    // 1024 points on a smooth sky: random ones give 1/32 = 3 % standard error, a net about a hundredth of that.
    RadianceImage image = filled(128, 64, {});
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 128; ++x) {
            const glm::vec3 d = direction_of_pixel(image, x, y);
            image.at(x, y) = glm::vec3(std::exp(3 * glm::dot(d, glm::normalize(glm::vec3(1, 2, 3)))));
        }
    const Environment sky = Environment::from_image(image);
    const double exact = project(512, 256, [&](glm::dvec3 d) { return glm::dvec3(sky.radiance(d)); })[1].r;
    double worst = 0;
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        double sum = 0;
        for (std::uint32_t i = 0; i < 1024; ++i) {
            const Environment::Sample sample = sky.sample({0.5F, sobol_point(i, seed * 0x9e3779b97f4a7c15U)});
            sum += sample.radiance.r * sh9_basis(sample.direction)[1] / sample.pdf / 1024;
        }
        worst = std::max(worst, std::abs(sum / exact - 1));
    }
    EXPECT_LT(worst, 0.003);
}

// ---- Errors

std::string message_of(const std::function<void()>& action) {
    try {
        action();
    } catch (const Error& error) {
        return error.what();
    }
    return "";
}

TEST(Environment, NamesThePixelThatIsNoRadiance) {
    for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -1.0F}) {
        RadianceImage image = noise(8, 4, 1);
        image.at(5, 2).g = bad;
        const std::string message = message_of([&] { (void)Environment::from_image(image); });
        EXPECT_NE(message.find("pixel 5, 2"), std::string::npos) << message;
    }
    EXPECT_NE(message_of([] { (void)Environment::uniform({0, -1, 0}); }), "");
}

TEST(Environment, RefusesWhatItCannotComputeWith) {
    const auto fails = [](const std::function<void()>& action) { return !message_of(action).empty(); };
    EXPECT_TRUE(fails([] { (void)Environment::from_image({}); }));
    EXPECT_TRUE(fails([] { (void)Environment::from_image({4, 2, std::vector<glm::vec3>(7)}); }));
    EXPECT_TRUE(fails([] { (void)Environment::from_image(noise(4, 2, 1), 0, -1); }));
    EXPECT_TRUE(fails([] { (void)Environment::from_image(noise(4, 2, 1), NAN); }));
    EXPECT_TRUE(fails([] { (void)Environment::from_image(noise(4, 2, 1), 0, 1e30F); }));
    EXPECT_TRUE(fails([] { (void)Environment::from_image(noise(4, 2, 1), 0, 1, SunDisc{{0, 1, 0}, 0, {1, 1, 1}}); }));
    EXPECT_TRUE(fails([] { (void)Environment::from_image(noise(4, 2, 1), 0, 1, SunDisc{{0, 1, 0}, 1, {1, -1, 1}}); }));
}

}  // namespace
}  // namespace lightgrid
