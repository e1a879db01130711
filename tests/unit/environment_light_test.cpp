#include "viewer/environment_light.h"

#include "core/sh.h"
#include "tests/gltf_builder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace lightgrid {
namespace {

/// A dim sky that is brighter above, and a small sun of 10,000 times its radiance at +X.
Environment sunny() {
    RadianceImage image{64, 32, {}};
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) image.pixels.emplace_back(y < 16 ? 2 : 1);
    }
    image.at(32, 15) = image.at(31, 15) = glm::vec3(10'000, 8'000, 6'000);
    return Environment::from_image(image);
}

TEST(EnvironmentLight, AUniformSkyIsExactFromTheFewestSamples) {
    const Sh36 sh = sample_environment(Environment::uniform({1, 2, 3}), fewest_environment_samples,
                                       EnvironmentSampling::by_brightness);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(sh[0][c], (c + 1) * 2 * std::sqrt(std::numbers::pi), 1e-5);
    EXPECT_EQ(sample_environment(Environment(), 10, EnvironmentSampling::by_brightness), Sh36{});
}

TEST(EnvironmentLight, MoreSamplesBringItToTheReference) {
    const Environment sky = sunny();
    const Sh36 reference = reference_environment(sky);
    // The same by another way: pixel by pixel, in double.
    const std::vector<glm::vec3> exact =
        project_to_sh(most_bands, std::function([&](glm::dvec3 d) { return sky.radiance(glm::vec3(d)); }), 1 << 21);
    Sh36 same{};
    std::copy(exact.begin(), exact.end(), same.begin());
    EXPECT_LT(irradiance_difference(reference, same), 2e-3);
    const auto error = [&](int samples, EnvironmentSampling sampling) {
        return irradiance_difference(sample_environment(sky, samples, sampling), reference);
    };
    EXPECT_LT(error(100, EnvironmentSampling::by_brightness), 0.2);
    EXPECT_LT(error(10'000, EnvironmentSampling::by_brightness), 0.01);
    EXPECT_LT(error(most_environment_samples, EnvironmentSampling::by_brightness), 2e-3);
    EXPECT_GT(error(100, EnvironmentSampling::evenly), 0.5) << "an even set of 100 has no business finding the sun";
    EXPECT_LT(error(most_environment_samples, EnvironmentSampling::evenly), 0.1);
}

TEST(EnvironmentLight, TurnsCounterClockwiseSeenFromAbove) {
    const Sh36 sh = reference_environment(sunny());
    const auto along = [](const Sh36& light, glm::vec3 direction) {
        return irradiance_from_sh(std::span(light), direction).g;
    };
    const Sh36 quarter = turned(sh, 90);
    EXPECT_NEAR(along(quarter, {0, 0, -1}), along(sh, {1, 0, 0}), 1e-3F * along(sh, {1, 0, 0}));
    EXPECT_NEAR(along(quarter, {0, 1, 0}), along(sh, {0, 1, 0}), 1e-3F * along(sh, {1, 0, 0}));
    EXPECT_GT(along(sh, {1, 0, 0}), 2 * along(sh, {0, 0, -1}));
}

TEST(EnvironmentLight, ItsVolumeIsTheSameEverywhere) {
    const Sh36 sh = reference_environment(sunny());
    const auto volume = volume_of(sh);
    LookUp from = look_up(*volume, Settings{});
    from.bands = most_bands;
    for (const glm::dvec3 position : {glm::dvec3(0), glm::dvec3(0.3, -0.9, 0.5), glm::dvec3(1e3, -2e4, 7)}) {
        const Sh36 here = all_radiance_sh(from, position);
        for (std::size_t i = 0; i < sh.size(); ++i) EXPECT_NEAR(here[i].r, sh[i].r, 1e-6F * sh[0].r) << i;
    }
}

TEST(EnvironmentLight, TheNextFileOfAFolderComesByNameAndTheFirstAfterTheLast) {
    const TemporaryFolder folder;
    const auto path = [&](const char* name) { return folder.path() / name; };
    write_bytes(path("b.hdr"), "");
    EXPECT_FALSE(next_environment(path("b.hdr"))) << "there is no other";
    write_bytes(path("a.exr"), "");
    write_bytes(path("c.HDR"), "");
    write_bytes(path("d.txt"), "");
    EXPECT_EQ(next_environment(path("a.exr")), path("b.hdr"));
    EXPECT_EQ(next_environment(path("b.hdr")), path("c.HDR"));
    EXPECT_EQ(next_environment(path("c.HDR")), path("a.exr"));
    EXPECT_EQ(next_environment(path("bb.hdr")), path("c.HDR")) << "one that has gone";
    EXPECT_FALSE(next_environment("/gone/a.hdr"));
}

}  // namespace
}  // namespace lightgrid
