#include "probes/volume_textures.h"

#include "core/error.h"
#include "core/sh.h"
#include "probes/half_storage.h"
#include "probes/sampler.h"
#include "tests/unit/glsl_on_cpu.h"
#include "tests/unit/random_volume.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

namespace one_band {
#define LIGHTGRID_BANDS 1
#include "tests/unit/glsl_program.inl"
}  // namespace one_band
namespace two_bands {
#define LIGHTGRID_BANDS 2
#include "tests/unit/glsl_program.inl"
}  // namespace two_bands
namespace three_bands {
#define LIGHTGRID_BANDS 3
#include "tests/unit/glsl_program.inl"
}  // namespace three_bands

namespace lightgrid {
namespace {

glsl::Shader shader_of(int bands) {
    return bands == 1 ? one_band::program() : bands == 2 ? two_bands::program() : three_bands::program();
}

/// The largest difference of irradiance from the Sampler's, relative to the mean irradiance at the point.
struct Difference {
    double largest = 0;
    double mean = 0;
};
Difference compare(const Volume& volume, glm::dvec3 origin, glm::vec3 (*shader)(glm::vec3, glm::vec3),
                   int bands = max_texture_bands) {
    const Sampler sampler(volume);
    const std::vector<Query> queries = random_queries(volume, origin, 10000);
    Difference result;
    for (const Query& query : queries) {
        std::vector<glm::vec3> sh = sampler.sample(origin + glm::dvec3(query.position)).sh;
        sh.resize(std::min<std::size_t>(sh.size(), sh_size(bands)));
        const glm::vec3 wanted = irradiance_from_sh(sh, query.normal);
        const glm::vec3 got = shader(query.position, query.normal);
        const double local = glm::length(glm::dvec3(sh[0])) * std::sqrt(std::acos(-1.0)) / 2;
        const double difference = glm::distance(glm::dvec3(got), glm::dvec3(wanted));
        const double relative = local > 0 ? difference / local : difference;
        EXPECT_FALSE(std::isnan(relative));
        result.largest = std::max(result.largest, relative);
        result.mean += relative / static_cast<double>(queries.size());
    }
    return result;
}

TEST(VolumeTextures, AnswerAsTheSamplerDoes) {
    for (int bands = 1; bands <= 3; ++bands) {
        for (const bool sparse : {false, true}) {
            Volume volume = random_volume({coarse_grid, fine_grid}, bands, any_state);
            if (sparse) thin_out(volume);
            const glsl::Shader shader = shader_of(bands);
            const VolumeTextures textures = pack_volume(volume);
            EXPECT_EQ(textures.bands, bands);
            shader.bind(textures);
            EXPECT_LT(compare(volume, textures.origin, shader.irradiance).largest, 1e-3) << bands << " bands";
        }
    }
}

TEST(VolumeTextures, AnswerOutsideAsTheSamplerDoes) {
    const glsl::Shader shader = shader_of(1);
    int points = 0;
    int off = 0;
    for (unsigned seed = 0; seed < 40; ++seed) {
        const Volume volume = random_sparse_volume(seed, 1);
        const Sampler sampler(volume);
        const VolumeTextures textures = pack_volume(volume);
        shader.bind(textures);
        const SampleOptions fade{.outside = Outside::fade, .fade_distance = 2.5F};
        for (const Query& query : queries_around(volume, textures.origin, 1000)) {
            const glm::dvec3 position = textures.origin + glm::dvec3(query.position);
            const glm::vec3 wanted = sampler.irradiance(position, {0, 1, 0});
            const glm::vec3 got = shader.irradiance(query.position, {0, 1, 0});
            const glm::vec3 wanted_faded = sampler.irradiance(position, {0, 1, 0}, fade);
            const glm::vec3 faded = shader.faded_irradiance(query.position, {0, 1, 0}, fade.fade_distance);
            off += glm::distance(got, wanted) < 1e-3F && glm::distance(faded, wanted_faded) < 1e-3F ? 0 : 1;
            ++points;
        }
    }
    // Light jumps between cells whose common corners are all missing, and float may see a point on the other side.
    EXPECT_LE(off, points / 10000);
}

TEST(VolumeTextures, KnowNothingWhereNoCellDoes) {
    Volume volume = make_volume({fine_grid}, 1);
    for (ProbeState& state : volume.states) {
        if (state != ProbeState::absent) state = ProbeState::missing;
    }
    const glsl::Shader shader = shader_of(1);
    const VolumeTextures textures = pack_volume(volume);
    shader.bind(textures);
    for (const glm::vec3 position : {glm::vec3(0), glm::vec3(100)}) {
        EXPECT_EQ(shader.known(position), 0);
        EXPECT_EQ(shader.irradiance(position, {0, 1, 0}), glm::vec3(0));
        EXPECT_EQ(shader.faded_irradiance(position, {0, 1, 0}, 1), glm::vec3(0));
    }
}

TEST(VolumeTextures, KnowHowMuchOfTheLightIsKnown) {
    Volume volume = random_volume({coarse_grid, fine_grid}, 1, any_state);
    thin_out(volume);
    const glsl::Shader shader = shader_of(1);
    const VolumeTextures textures = pack_volume(volume);
    shader.bind(textures);
    const Sampler sampler(volume);
    int partly = 0;
    for (const Query& query : random_queries(volume, textures.origin, 1000)) {
        const float known = sampler.sample(textures.origin + glm::dvec3(query.position)).weight;
        EXPECT_NEAR(shader.known(query.position), known, 1e-4);
        partly += known > 0 && known < 1 ? 1 : 0;
    }
    EXPECT_GT(partly, 100);
}

TEST(VolumeTextures, AnswerAtProbesAndOnFarFaces) {
    // With spacings and origins that no float holds, positions of probes are off by rounding in the shader.
    Volume volume = random_volume({coarse_grid, fine_grid}, 1, any_state);
    thin_out(volume);
    const Sampler sampler(volume);
    const glsl::Shader shader = shader_of(1);
    const VolumeTextures textures = pack_volume(volume);
    shader.bind(textures);
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        if (volume.states[slot] == ProbeState::absent) continue;
        const glm::dvec3 place = lattice_position(volume, slot);
        const glm::vec3 wanted = sampler.irradiance(place, {0, 1, 0});
        const glm::vec3 got = shader.irradiance(glm::vec3(place - textures.origin), {0, 1, 0});
        EXPECT_NEAR(glm::distance(got, wanted), 0, 1e-3 * glm::length(wanted)) << "slot " << slot;
    }
}

TEST(VolumeTextures, HoldALargeLevelFarFromZero) {
    const Grid wide{{12345.6, -20, 54321.7}, {0.5, 0.7, 0.6}, {130, 9, 110}};
    const Volume volume = random_volume({wide}, 3, all_valid);
    const glsl::Shader shader = shader_of(3);
    const VolumeTextures textures = pack_volume(volume);
    shader.bind(textures);
    EXPECT_LT(compare(volume, textures.origin, shader.irradiance).largest, 1e-3);
    for (const TextureImage* image : {&textures.grids, &textures.index, &textures.atlas}) {
        EXPECT_TRUE(glm::all(glm::lessThanEqual(image->size, glm::ivec3(max_texture_size))));
        const std::size_t texels = std::size_t{1} * image->size.x * image->size.y * image->size.z;
        EXPECT_EQ(image->texels.size(), texel_bytes(image->format) * texels);
    }
    // A twentieth more than the bricks that are stored, at most.
    EXPECT_LE(textures.atlas.texels.size(), volume.bricks.size() * probes_per_brick * 7 * 16 * 21 / 20);
}

TEST(VolumeTextures, FindBricksBehindTheFirstRowOfTheIndex) {
    const Grid flat{{0, 0, 0}, {1, 1, 1}, {320, 5, 301}};  // 80 x 2 x 76 bricks
    Volume volume = make_volume({{{0, 0, 0}, {1000, 1, 1000}, {2, 2, 2}}, flat}, 1);
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        volume.coefficients[slot] = glm::vec3(lattice_position(volume, slot)) + 1.0F;
    }
    const glsl::Shader shader = shader_of(1);
    const VolumeTextures textures = pack_volume(volume, {.origin = glm::dvec3(0)});
    shader.bind(textures);
    for (const Query& query : random_queries(volume, {0, 0, 0}, 1000)) {
        const glm::vec3 inside = glm::clamp(query.position, glm::vec3(0), glm::vec3(319, 4, 300));
        if (inside != query.position) continue;
        const glm::vec3 got = shader.radiance(query.position, {0, 1, 0}) / 0.28209479F;
        EXPECT_NEAR(glm::distance(got, inside + 1.0F), 0, 1e-3);
    }
}

TEST(VolumeTextures, AsHalfAreAsGoodAsHalfIs) {
    Volume volume = random_volume({coarse_grid, fine_grid}, 3, any_state);
    // Sunlight in one brick and starlight in another: beyond the range of half without a scale each.
    for (std::size_t i = 0; i < volume.coefficients.size(); ++i) {
        const std::size_t brick = i / 9 / probes_per_brick;
        volume.coefficients[i] *= brick % 2 == 0 ? 1e6F : 1e-6F;
    }
    const glsl::Shader shader = shader_of(3);
    const VolumeTextures textures = pack_volume(volume, {.half = true});
    EXPECT_EQ(textures.atlas.format, TexelFormat::rgba16f);
    shader.bind(textures);
    // 2^-11 of each of nine coefficients: sum_i A_i |Y_i| |L_i| / E_mean <= (1 + 2 + 2) E_mean at most here.
    EXPECT_LT(compare(volume, textures.origin, shader.irradiance).largest, 5 * 0x1p-11);
    // What was rounded to half before is the same in both, to the bit: scales are powers of two.
    store_as_half(volume);
    const VolumeTextures in_half = pack_volume(volume, {.half = true});
    const VolumeTextures in_float = pack_volume(volume);
    for (const Query& query : random_queries(volume, textures.origin, 1000)) {
        shader.bind(in_half);
        const glm::vec3 got = shader.irradiance(query.position, query.normal);
        shader.bind(in_float);
        EXPECT_EQ(got, shader.irradiance(query.position, query.normal));
    }
}

TEST(VolumeTextures, LeaveHigherBandsOut) {
    const Volume volume = random_volume({fine_grid}, 5, all_valid);
    for (int bands = 1; bands <= 3; ++bands) {
        const glsl::Shader shader = shader_of(bands);
        const VolumeTextures textures = pack_volume(volume, {.bands = bands});
        EXPECT_EQ(textures.bands, bands);
        shader.bind(textures);
        EXPECT_LT(compare(volume, textures.origin, shader.irradiance, bands).largest, 1e-3) << bands << " bands";
    }
}

TEST(VolumeTextures, GiveRadianceToo) {
    const Volume volume = random_volume({fine_grid}, 3, all_valid);
    const glsl::Shader shader = shader_of(3);
    const VolumeTextures textures = pack_volume(volume);
    shader.bind(textures);
    const Sampler sampler(volume);
    for (const Query& query : random_queries(volume, textures.origin, 100)) {
        const Sample sample = sampler.sample(textures.origin + glm::dvec3(query.position));
        const glm::vec3 wanted = evaluate_sh(sample.sh, query.normal);
        EXPECT_NEAR(glm::distance(shader.radiance(query.position, query.normal), wanted), 0,
                    1e-3 * glm::length(sample.sh[0]));
    }
}

TEST(VolumeTextures, RefuseAProbeList) {
    const Volume list = make_probe_list({{0, 0, 0}}, 3);
    EXPECT_THROW(static_cast<void>(pack_volume(list)), Error);
    EXPECT_THROW(static_cast<void>(pack_filtered(list)), Error);
}

TEST(FilteredTextures, AnswerAsTheSamplerDoesWhereAllProbesAreValid) {
    for (int bands = 1; bands <= 3; ++bands) {
        const Volume volume = random_volume({fine_grid}, bands, all_valid);
        const glsl::Shader shader = shader_of(bands);
        for (const bool half : {false, true}) {
            const FilteredTextures textures = pack_filtered(volume, {.half = half});
            ASSERT_EQ(textures.probes.size(), static_cast<std::size_t>(texels_per_probe(bands)));
            EXPECT_EQ(textures.probes[0].size, fine_grid.counts);
            shader.bind_filtered(textures);
            EXPECT_LT(compare(volume, textures.origin, shader.filtered_irradiance).largest, half ? 5 * 0x1p-11 : 1e-3)
                << bands << " bands";
        }
    }
}

TEST(FilteredTextures, TakeFilledProbesForLight) {
    Volume volume = make_volume({{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}}, 1);
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        if (volume.states[slot] == ProbeState::absent) continue;
        const bool upper = lattice_index(volume, slot).y == 1;
        volume.states[slot] = upper ? ProbeState::filled : ProbeState::valid;
        volume.coefficients[slot] = glm::vec3(upper ? 3 : 1);
    }
    const glsl::Shader shader = shader_of(1);
    const FilteredTextures textures = pack_filtered(volume, {.origin = glm::dvec3(0)});
    shader.bind_filtered(textures);
    const glm::vec3 got = shader.filtered_irradiance({0.5F, 0.25F, 0.5F}, {0, 1, 0});
    EXPECT_NEAR(got.r, 1.5 * std::sqrt(std::acos(-1.0)) / 2, 1e-5);
}

TEST(FilteredTextures, RefuseWhatIsNoSingleDenseGrid) {
    EXPECT_THROW(static_cast<void>(pack_filtered(random_volume({coarse_grid, fine_grid}, 1, all_valid))), Error);
    Volume sparse = random_volume({fine_grid}, 1, all_valid);
    EXPECT_TRUE(is_dense(sparse));
    thin_out(sparse);
    EXPECT_FALSE(is_dense(sparse));
    EXPECT_THROW(static_cast<void>(pack_filtered(sparse)), Error);
}

}  // namespace
}  // namespace lightgrid
