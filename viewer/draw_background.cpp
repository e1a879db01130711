#include "viewer/draw_background.h"

#include <cmath>
#include <numbers>
#include <vector>

namespace lightgrid {
namespace {

constexpr int width = 1024;  // of the picture of an environment, pixels
constexpr int height = width / 2;

/// The direction of the centre of a pixel; see Environment.
glm::vec3 direction_of(int x, int y) {
    const double azimuth = 2 * std::numbers::pi * ((x + 0.5) / width - 0.5);
    const double polar = std::numbers::pi * (y + 0.5) / height;
    return {std::sin(polar) * std::cos(azimuth), std::cos(polar), std::sin(polar) * std::sin(azimuth)};
}

}  // namespace

BackgroundDrawing::BackgroundDrawing(const Gl& gl, const ShaderSources& shaders)
    : gl_(gl),
      program_(compile_program(gl, shaders, "background.vert", "background.frag")),
      vertex_array_(make_vertex_array(gl)) {}

void BackgroundDrawing::set_environment(const Environment& environment) {
    environment_ = {};
    if (environment.is_black()) return;
    const glm::ivec2 size = environment.is_uniform() ? glm::ivec2(1) : glm::ivec2(width, height);
    std::vector<glm::vec3> pixels;
    for (int y = 0; y < size.y; ++y) {
        for (int x = 0; x < size.x; ++x) pixels.push_back(environment.radiance(direction_of(x, y)));
    }
    environment_ = make_texture(gl_);
    gl_.BindTexture(GL_TEXTURE_2D, environment_.name());
    gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_RGB32F, size.x, size.y, 0, GL_RGB, GL_FLOAT, pixels.data());
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_REPEAT);
    gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

void BackgroundDrawing::draw(const Eye& eye, bool picture, const glm::mat3& turn, const Sh36& radiance) const {
    gl_.UseProgram(program_.name());
    const Uniforms uniforms(gl_, program_);
    const bool environment = picture && has_environment();
    uniforms.set("ray", environment ? glm::transpose(turn) * eye.ray : eye.ray);
    uniforms.set("exposure", eye.exposure);
    uniforms.set("has_environment", environment ? 1 : 0);
    uniforms.set("environment", 0);
    uniforms.set("bands", used_bands(radiance));
    uniforms.set("radiance", radiance.data(), static_cast<int>(radiance.size()));
    gl_.ActiveTexture(GL_TEXTURE0);
    gl_.BindTexture(GL_TEXTURE_2D, environment_.name());
    gl_.BindVertexArray(vertex_array_.name());
    gl_.DepthMask(GL_FALSE);
    gl_.DepthFunc(GL_LEQUAL);
    gl_.DrawArrays(GL_TRIANGLES, 0, 3);
    gl_.DepthFunc(GL_LESS);
    gl_.DepthMask(GL_TRUE);
    gl_.BindVertexArray(0);
}

}  // namespace lightgrid
