#include "probes/sky_light.h"

#include "core/sampling.h"

#include <glm/gtc/constants.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace lightgrid {
namespace {

constexpr double pi = glm::pi<double>();

/// Dim and blue above, brown below, and one pixel of a sun.
Environment outdoors(float sun) {
    RadianceImage image{128, 64, {}};
    for (int y = 0; y < 64; ++y) {
        for (int x = 0; x < 128; ++x)
            image.pixels.push_back(y < 32 ? glm::vec3(0.4F, 0.6F, 1) : glm::vec3(0.2F, 0.1F, 0));
    }
    image.at(17, 12) = glm::vec3(sun);
    return Environment::from_image(std::move(image));
}

/// Irradiance on a surface facing `normal`, by rays and by samples.
struct Halves {
    glm::dvec3 rays{0};
    glm::dvec3 samples{0};
};

Halves irradiance(const SkyLight& sky, glm::vec3 normal) {
    Halves sum;
    constexpr std::uint32_t rays = 1U << 18;
    for (const glm::vec3& direction : even_directions(rays)) {
        const float cosine = glm::dot(normal, direction);
        if (cosine > 0) sum.rays += glm::dvec3(sky.along(direction)) * (4 * pi * cosine / rays);
    }
    for (const SkyLight::Sample& sample : sky.samples(0, SkyLight::samples_drawn)) {
        const float cosine = glm::dot(normal, sample.direction);
        if (cosine > 0) sum.samples += glm::dvec3(sample.radiance) * (double{cosine} / SkyLight::samples_drawn);
    }
    return sum;
}

glm::dvec3 exact_irradiance(const Environment& environment, glm::vec3 normal) {
    glm::dvec3 sum(0);
    constexpr std::uint32_t rays = 1U << 20;
    for (const glm::vec3& direction : even_directions(rays)) {
        const float cosine = glm::dot(normal, direction);
        if (cosine > 0) sum += glm::dvec3(environment.radiance(direction)) * (4 * pi * cosine / rays);
    }
    return sum;
}

TEST(SkyLight, RaysAndSamplesAddUpToTheEnvironment) {
    for (const float sun : {1.0F, 1e3F, 1e6F}) {
        const Environment environment = outdoors(sun);
        for (const float samples_per_ray : {0.25F, 1.0F}) {
            const SkyLight sky(environment, samples_per_ray, 1);
            for (const glm::vec3 normal : {glm::vec3(0, 1, 0), glm::vec3(0, -1, 0), glm::vec3(0.6F, 0, 0.8F)}) {
                const Halves ours = irradiance(sky, normal);
                const glm::dvec3 exact = exact_irradiance(environment, normal);
                const double brightest = std::max({exact.x, exact.y, exact.z});
                for (int c = 0; c < 3; ++c) {
                    // Texels average over the cosine: 1.6 degrees at the horizon; 65,536 samples of a net.
                    EXPECT_NEAR(ours.rays[c] + ours.samples[c], exact[c], 0.003 * brightest) << sun << " colour " << c;
                }
            }
        }
    }
}

TEST(SkyLight, ASunIsLeftToTheSamples) {
    const Environment environment = outdoors(1e6F);
    const SkyLight sky(environment, 0.25F, 1);
    const Halves up = irradiance(sky, {0, 1, 0});
    EXPECT_GT(up.samples.x, 0.99 * (up.samples.x + up.rays.x));
    float brightest = 0;
    for (const glm::vec3& direction : even_directions(1U << 16))
        brightest = std::max(brightest, sky.along(direction).x);
    // L w < p / s times the luminance of the whole sky, the colours' own share aside.
    const double whole = exact_irradiance(environment, {0, 1, 0}).x * 4;
    EXPECT_LT(brightest, whole / (4 * pi) / 0.25);
}

TEST(SkyLight, EverySetOfSamplesIsFairByItself) {
    const SkyLight sky(outdoors(100), 0.25F, 3);
    double all = 0;
    double squares = 0;
    constexpr std::uint32_t count = 16;
    constexpr std::uint32_t sets = SkyLight::samples_drawn / count;
    for (std::uint32_t i = 0; i < sets; ++i) {
        double sum = 0;
        for (const SkyLight::Sample& sample : sky.samples(i, count)) {
            sum += sample.radiance.y * std::max(0.0F, sample.direction.y) / count;
        }
        all += sum / sets;
        squares += sum * sum / sets;
    }
    const double expected = irradiance(sky, {0, 1, 0}).samples.y;
    EXPECT_NEAR(all, expected, 1e-4 * expected);
    EXPECT_LT(std::sqrt(squares - all * all), 0.25 * expected) << "stratified: independent ones would leave as much";
}

TEST(SkyLight, UniformAndBlackSkiesHaveNoSamples) {
    const SkyLight uniform(Environment::uniform({1, 2, 3}), 0.25F, 0);
    EXPECT_FALSE(uniform.has_samples());
    EXPECT_EQ(uniform.along({0, -1, 0}), glm::vec3(1, 2, 3));
    const SkyLight black(Environment(), 0.25F, 0);
    EXPECT_TRUE(black.is_black());
    EXPECT_EQ(black.along({0, -1, 0}), glm::vec3(0));
}

}  // namespace
}  // namespace lightgrid
