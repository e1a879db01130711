#include "probes/emitters.h"

#include "core/sampling.h"
#include "tests/polygon_light.h"
#include "tests/scene_builder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace lightgrid {
namespace {

constexpr std::uint32_t samples = 1U << 14;

TEST(Emitters, ATriangleIsSampledWithTheDensityStatedNearAndFar) {
    Scene scene;
    const std::vector<glm::vec3> corners = {{0, 2, 0}, {1, 2, 0}, {0, 2, 1.5F}};
    add_triangle(scene, add_grey(scene, 0, 3), corners[0], corners[1], corners[2]);
    const Tracer tracer(scene);
    const Emitters emitters(tracer);
    const std::vector<glm::dvec3> polygon(corners.begin(), corners.end());
    for (const glm::vec3 place : {glm::vec3(0.2F, 1.999F, 0.3F), glm::vec3(0.3F, 1.7F, 0.4F), glm::vec3(-1, 1, -1),
                                  glm::vec3(4, -6, 3), glm::vec3(2, 1.99F, 2)}) {
        const Receiver probe{place, {}};
        double solid_angle = 0;
        for (std::uint32_t i = 0; i < samples; ++i) {
            const Emitters::Sample sample = emitters.sample(probe, 0.5, sobol_point(i, 7));
            ASSERT_EQ(sample.radiance.x, 3);
            const glm::vec3 towards = sample.position - place;
            solid_angle += 1.0 / sample.pdf / samples;
            const Hit hit = tracer.closest_hit(place, towards);
            if (!hit.found() || i % 16 != 0) continue;  // rays may miss what lies on an edge
            EXPECT_NEAR(emitters.pdf(probe, hit, tracer.surface(hit, towards)), sample.pdf, 2e-3 * sample.pdf)
                << place.x << ' ' << place.y << ' ' << place.z;
        }
        // Far away, where it is sampled by area, 1 / pdf varies; two per thousand is three times the error of the net.
        const double exact = polygon_solid_angle(polygon, glm::dvec3(place));
        EXPECT_NEAR(solid_angle, exact, 2e-3 * exact) << place.x << ' ' << place.y << ' ' << place.z;
    }
}

TEST(Emitters, OfATexturedTriangleWhatIsLitIsSampledWithTheDensityStated) {
    Scene scene;
    Material material;
    material.emission = glm::vec3(3);
    material.emission_texture.texture = 0;
    Texture texture;
    texture.image = {256, 256, std::vector<glm::u8vec4>(256 * 256, glm::u8vec4(0, 0, 0, 255))};
    texture.nearest = true;
    for (int i = 0; i < 64; ++i) texture.image.at(80 + i % 8, 40 + i / 8) = glm::u8vec4(255);
    scene.textures.push_back(texture);
    const glm::dvec3 a(0, 2, 0), b(1, 2, 0), c(0, 2, 1.5);
    const int mesh = add_triangle(scene, add_material(scene, material), a, b, c);
    scene.meshes[mesh].uv_sets = {{{0, 0}, {1, 0}, {0, 1}}};
    const Tracer tracer(scene);
    const Emitters emitters(tracer);
    std::vector<glm::dvec3> patch;
    for (const glm::dvec2 texel : {glm::dvec2(80, 40), {88, 40}, {88, 48}, {80, 48}})
        patch.push_back(a + texel.x / 256 * (b - a) + texel.y / 256 * (c - a));
    for (const glm::vec3 place : {glm::vec3(0.32F, 1.99F, 0.26F), glm::vec3(0.3F, 1.7F, 0.4F), glm::vec3(4, -6, 3)}) {
        const EmitterCut cut = emitters.open({place}, samples);
        const Receiver probe{place, {}, &cut};
        double solid_angle = 0;
        std::uint32_t lit = 0;
        RandomStream random(9);
        for (std::uint32_t i = 0; i < samples; ++i) {
            const Emitters::Sample sample = emitters.sample(probe, random.next_double(), sobol_point(i, 7));
            if (sample.radiance == glm::vec3(0)) continue;
            ++lit;
            const glm::vec3 towards = sample.position - place;
            solid_angle += 1.0 / sample.pdf / samples;
            if (i % 16 != 0) continue;
            const Hit hit = tracer.closest_hit(place, towards);
            const float pdf = hit.found() ? emitters.pdf(probe, hit, tracer.surface(hit, towards)) : 0;
            if (pdf == 0) continue;
            EXPECT_LT(std::abs(pdf / sample.pdf - 1), 2) << "a part, or by rounding the next";
        }
        const double exact = polygon_solid_angle(patch, glm::dvec3(place));
        EXPECT_NEAR(solid_angle, exact, 0.02 * exact) << place.x << ' ' << place.y << ' ' << place.z;
        EXPECT_GT(lit, samples * 8 / 10) << "most samples are of what is lit";
    }
    const Hit beside{{SurfaceId::none, 0, 0}, 1, {0.1F, 0.1F}};
    EXPECT_EQ(emitters.pdf({{0, 0, 0}}, beside, tracer.surface(beside, {0, 1, 0})), 0);
    EXPECT_TRUE(emitters.emits(beside, true)) << "what is met there by chance counts in full";
}

TEST(Emitters, ASurfaceWhoseTextureIsDarkWhereItIsReadDoesNotEmit) {
    Scene scene;
    Material material;
    material.emission = glm::vec3(1);
    material.emission_texture.texture = 0;
    Texture texture;
    texture.image = {8, 8, std::vector<glm::u8vec4>(64, glm::u8vec4(0, 0, 0, 255))};
    texture.image.at(7, 7) = glm::u8vec4(255);
    scene.textures.push_back(texture);
    const int mesh = add_triangle(scene, add_material(scene, material), {0, 0, 0}, {1, 0, 0}, {0, 0, 1});
    scene.meshes[mesh].uv_sets = {{{0.2F, 0.2F}, {0.6F, 0.2F}, {0.2F, 0.6F}}};
    const Tracer tracer(scene);
    EXPECT_TRUE(Emitters(tracer).empty());
    scene.meshes[mesh].uv_sets = {{{0.2F, 0.2F}, {1, 0.2F}, {0.9F, 0.9F}}};
    EXPECT_FALSE(Emitters(tracer).empty());
}

TEST(Emitters, ATriangleBringsNothingToItsOwnSurface) {
    Scene scene;  // crooked, so that its points are rounded off its plane
    add_triangle(scene, add_grey(scene, 0.5F, 1), {3.1F, 0.7F, -2.3F}, {2.2F, 1.9F, -2.9F}, {4.7F, 2.3F, -1.1F});
    const Tracer tracer(scene);
    const Emitters emitters(tracer);
    double brought = 0;
    for (std::uint32_t i = 0; i < samples; ++i) {
        const Surface surface = tracer.surface({{SurfaceId::none, 0, 0}, 0, triangle_point(sobol_point(i, 1))}, {});
        const Emitters::Sample sample = emitters.sample({surface.position, surface.normal}, 0.5, sobol_point(i, 2));
        if (sample.radiance == glm::vec3(0)) continue;
        const float cosine = glm::dot(surface.normal, glm::normalize(sample.position - surface.position));
        brought += std::max(0.0F, cosine) / sample.pdf / samples;
    }
    EXPECT_LT(brought, 1e-4) << "of an irradiance of pi, were it all around";
}

}  // namespace
}  // namespace lightgrid
