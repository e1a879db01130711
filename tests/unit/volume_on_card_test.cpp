// lightgrid.glsl in a real OpenGL against the Sampler: what an engine's pixels get.

#include "viewer/volume_on_card.h"

#include "core/sampling.h"
#include "core/sh.h"
#include "probes/bake.h"
#include "probes/half_storage.h"
#include "probes/sampler.h"
#include "tests/scene_builder.h"
#include "tests/unit/random_volume.h"
#include "viewer/headless.h"
#include "viewer/shader.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace lightgrid {
namespace {

constexpr int count = 10000;
constexpr glm::ivec2 picture(100, 100);

/// Every point is a pixel of its own.
const std::string point_shader = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
flat out vec3 at;
flat out vec3 facing;
void main() {
    at = position;
    facing = normal;
    vec2 pixel = vec2(gl_VertexID % 100, gl_VertexID / 100) + 0.5;
    gl_Position = vec4(pixel / 50.0 - 1.0, 0.0, 1.0);
}
)";

std::string pixel_shader(int bands, const std::string& light) {
    return fmt::format(R"(#version 330 core
#define LIGHTGRID_BANDS {}
#include "lightgrid.glsl"
flat in vec3 at;
flat in vec3 facing;
out vec4 color;
void main() {{
    LightgridLight light = {}(at);
    color = vec4(lightgrid_irradiance(light, facing), light.known);
}}
)",
                       bands, light);
}

/// Irradiance and known share at all points, as the card has them.
class Card {
  public:
    Card() {
        const Gl& gl = surface_.gl();
        vertex_array_ = make_vertex_array(gl);
        vertices_ = make_buffer(gl);
        picture_ = make_texture(gl);
        gl.BindTexture(GL_TEXTURE_2D, picture_.name());
        gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, picture.x, picture.y, 0, GL_RGBA, GL_FLOAT, nullptr);
        framebuffer_ = make_framebuffer(gl);
        gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
        gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, picture_.name(), 0);
        EXPECT_EQ(gl.CheckFramebufferStatus(GL_FRAMEBUFFER), static_cast<GLenum>(GL_FRAMEBUFFER_COMPLETE));
        gl.Viewport(0, 0, picture.x, picture.y);
    }

    template <typename Textures>
    std::vector<glm::vec4> light(const Textures& textures, const std::vector<Query>& queries) {
        const Gl& gl = surface_.gl();
        const bool exact = std::is_same_v<Textures, VolumeTextures>;
        ShaderSources sources = built_in_shaders();
        sources["points.vert"] = point_shader;
        sources["points.frag"] = pixel_shader(textures.bands, exact ? "lightgrid_light" : "lightgrid_filtered_light");
        const Program program = compile_program(gl, sources, "points.vert", "points.frag");
        gl.UseProgram(program.name());
        const auto volume = upload(gl, textures);
        bind(gl, volume, Uniforms(gl, program), 2);

        gl.BindVertexArray(vertex_array_.name());
        gl.BindBuffer(GL_ARRAY_BUFFER, vertices_.name());
        gl.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(queries.size() * sizeof(Query)), queries.data(),
                      GL_STATIC_DRAW);
        for (const GLuint i : {0U, 1U}) {
            gl.EnableVertexAttribArray(i);
            gl.VertexAttribPointer(
                i, 3, GL_FLOAT, GL_FALSE, sizeof(Query),
                reinterpret_cast<const void*>(i * sizeof(glm::vec3)));  // NOLINT(performance-no-int-to-ptr)
        }
        gl.ClearColor(-1, -1, -1, -1);
        gl.Clear(GL_COLOR_BUFFER_BIT);
        gl.DrawArrays(GL_POINTS, 0, static_cast<GLsizei>(queries.size()));
        std::vector<glm::vec4> pixels(static_cast<std::size_t>(picture.x) * picture.y);
        gl.ReadPixels(0, 0, picture.x, picture.y, GL_RGBA, GL_FLOAT, pixels.data());
        check_gl(gl, "lighting points");
        return pixels;
    }

  private:
    Headless surface_;
    VertexArray vertex_array_;
    Buffer vertices_;
    GlTexture picture_;
    Framebuffer framebuffer_;
};

/// |difference of irradiance| over the mean irradiance at the point, or of what is known where that is more, all points,
/// increasing.
template <typename Textures>
std::vector<double> differences(Card& card, const Volume& volume, const Textures& textures,
                                const std::vector<Query>& queries) {
    const std::vector<glm::vec4> got = card.light(textures, queries);
    const Sampler sampler(volume);
    std::vector<double> result;
    for (std::size_t i = 0; i < queries.size(); ++i) {
        const Sample sample = sampler.sample(textures.origin + glm::dvec3(queries[i].position));
        const glm::dvec3 wanted = irradiance_from_sh(sample.sh, queries[i].normal);
        const double local = glm::length(glm::dvec3(sample.sh[0])) * std::sqrt(std::acos(-1.0)) / 2;
        const double difference = glm::distance(glm::dvec3(got[i]), wanted);
        const bool exact = std::is_same_v<Textures, VolumeTextures>;
        const double of_known = exact ? std::abs(got[i].w - sample.weight) : 0;
        result.push_back(std::max(local > 0 ? difference / local : difference, of_known));
    }
    std::sort(result.begin(), result.end());
    return result;
}
template <typename Textures>
std::vector<double> differences(Card& card, const Volume& volume, const Textures& textures) {
    return differences(card, volume, textures, random_queries(volume, textures.origin, count));
}

std::string spread(const std::vector<double>& sorted) {
    return fmt::format("median {:.2g}, 95 % {:.2g}, 99 % {:.2g}, largest {:.2g}", sorted[sorted.size() / 2],
                       sorted[sorted.size() * 95 / 100], sorted[sorted.size() * 99 / 100], sorted.back());
}

/// A room of 4 m with a lamp, a crate and a thin wall, in probes half a metre apart; a few of them are inside the crate.
Volume baked_room() {
    Scene room;
    const int wall = add_grey(room, 0.5F);
    const int lamp = add_grey(room, 0, 10);
    add_box(room, wall, {0, 0, 0}, {4, 4, 4}, Facing::inward);
    add_box(room, wall, {2.3F, 0, 2.2F}, {3.8F, 1.2F, 3.7F}, Facing::outward);
    add_box(room, wall, {1.2F, 0, 0}, {1.3F, 2.5F, 4}, Facing::outward);
    add_quad(room, lamp, {2, 3.9F, 1.5F}, {1, 0, 0}, {0, 0, 1});
    const Tracer tracer(room);
    const Environment dark;
    const PathTracer paths(tracer, dark);
    BakeOptions options;
    options.placement.spacing = 0.5;
    options.target.samples = 256;
    options.measure_error = false;
    return run_bake(paths, plan_bake(paths, options), options).volume;
}

TEST(VolumeOnCard, AnswersAsTheSamplerDoes) {
    Card card;
    for (int bands = 1; bands <= 3; ++bands) {
        Volume small = random_volume({coarse_grid, fine_grid}, bands, any_state);
        EXPECT_LT(differences(card, small, pack_volume(small)).back(), 1e-3) << bands << " bands, dense";
        thin_out(small);
        EXPECT_LT(differences(card, small, pack_volume(small)).back(), 1e-3) << bands << " bands, sparse";
    }
}

TEST(VolumeOnCard, AnswersOutsideAsTheSamplerDoes) {
    Card card;
    for (unsigned seed = 0; seed < 4; ++seed) {
        const Volume volume = random_sparse_volume(seed, 3);
        const VolumeTextures textures = pack_volume(volume);
        const std::vector<Query> queries = queries_around(volume, textures.origin, count);
        const std::vector<double> sorted = differences(card, volume, textures, queries);
        // Light jumps between cells whose common corners are all missing, and float may see a point on the other side.
        EXPECT_LT(sorted[sorted.size() - 2], 1e-3) << "volume " << seed;
    }
}

TEST(VolumeOnCard, AnswersAsTheSamplerDoesInALevel) {
    Card card;
    const Grid wide{{12345.6, -20, 54321.7}, {0.5, 0.7, 0.6}, {130, 9, 110}};
    const Volume level = random_volume({wide}, 3, mostly_valid);
    const std::vector<double> exact = differences(card, level, pack_volume(level));
    fmt::print("128,700 probes: {}\n", spread(exact));
    EXPECT_LT(exact.back(), 1e-3);
    const std::vector<double> half = differences(card, level, pack_volume(level, {.half = true}));
    fmt::print("as half: {}\n", spread(half));
    EXPECT_LT(half.back(), 5 * 0x1p-11);
}

TEST(VolumeOnCard, FilteredByHardwareIsNearWhereAllIsKnown) {
    Card card;
    const Volume volume = random_volume({fine_grid}, 3, all_valid);
    const std::vector<double> filtered = differences(card, volume, pack_filtered(volume));
    fmt::print("filtered by hardware, all valid, noise for light: {}\n", spread(filtered));
    // Weights may be rounded to 8 bits, off by 2^-9 along each axis; neighbours differ by their own size and more.
    EXPECT_LT(filtered[filtered.size() / 2], 3 * 0x1p-8);
    EXPECT_LT(filtered[filtered.size() * 99 / 100], 3 * 0x1p-5);
}

TEST(VolumeOnCard, FilteredByHardwareLeaksThroughWhatIsFilled) {
    Card card;
    const Volume room = baked_room();
    ASSERT_TRUE(is_dense(room));
    const std::vector<double> exact = differences(card, room, pack_volume(room));
    const std::vector<double> filtered = differences(card, room, pack_filtered(room));
    fmt::print("a baked room, exact: {}\n", spread(exact));
    fmt::print("a baked room, filtered by hardware: {}\n", spread(filtered));
    EXPECT_LT(exact.back(), 1e-3);
    EXPECT_LT(filtered[filtered.size() / 2], 0.01) << "most points have valid probes only around them";
    EXPECT_GT(filtered.back(), 0.01) << "else nothing is measured here";
}

}  // namespace
}  // namespace lightgrid
