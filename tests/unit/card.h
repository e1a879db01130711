#pragma once

#include "core/sh.h"
#include "probes/sampler.h"
#include "tests/unit/random_volume.h"
#include "viewer/headless.h"
#include "viewer/shader.h"
#include "viewer/volume_on_card.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <type_traits>
#include <vector>

/// lightgrid.glsl in a real OpenGL, and how far it is from the Sampler.
namespace lightgrid {

inline constexpr int card_points = 10000;  // at most
inline constexpr glm::ivec2 card_picture(100, 100);

/// Every point is a pixel of its own.
inline const std::string point_shader = R"(#version 330 core
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

inline std::string pixel_shader(int bands, const std::string& light) {
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
        gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, card_picture.x, card_picture.y, 0, GL_RGBA, GL_FLOAT, nullptr);
        framebuffer_ = make_framebuffer(gl);
        gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
        gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, picture_.name(), 0);
        EXPECT_EQ(gl.CheckFramebufferStatus(GL_FRAMEBUFFER), static_cast<GLenum>(GL_FRAMEBUFFER_COMPLETE));
        gl.Viewport(0, 0, card_picture.x, card_picture.y);
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
        std::vector<glm::vec4> pixels(static_cast<std::size_t>(card_picture.x) * card_picture.y);
        gl.ReadPixels(0, 0, card_picture.x, card_picture.y, GL_RGBA, GL_FLOAT, pixels.data());
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
    return differences(card, volume, textures, random_queries(volume, textures.origin, card_points));
}

inline std::string spread(const std::vector<double>& sorted) {
    return fmt::format("median {:.2g}, 95 % {:.2g}, 99 % {:.2g}, largest {:.2g}", sorted[sorted.size() / 2],
                       sorted[sorted.size() * 95 / 100], sorted[sorted.size() * 99 / 100], sorted.back());
}

}  // namespace lightgrid
