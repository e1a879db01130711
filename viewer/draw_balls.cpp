#include "viewer/draw_balls.h"

#include "viewer/pixel_light.h"

#include <array>
#include <numbers>
#include <vector>

namespace lightgrid {
namespace {

constexpr float albedo = 0.8F;

}  // namespace

BallDrawing::BallDrawing(const Gl& gl, const ShaderSources& shaders)
    : gl_(gl), program_(compile_program(gl, shaders, "ball.vert", "ball.frag")), vertex_array_(make_vertex_array(gl)) {}

BallTable BallDrawing::upload(std::span<const Ball> balls) const {
    std::vector<glm::vec4> texels;
    texels.reserve(9 * balls.size());
    for (const Ball& ball : balls) {
        texels.emplace_back(ball.center, ball.radius);
        texels.emplace_back(ball.rim, 0);
        std::array<float, 28> numbers{};
        for (std::size_t i = 0; i < 27; ++i) numbers[i] = ball.radiance[i / 3][static_cast<int>(i % 3)];
        for (std::size_t i = 0; i < numbers.size(); i += 4) {
            texels.emplace_back(numbers[i], numbers[i + 1], numbers[i + 2], numbers[i + 3]);
        }
    }
    return {make_texel_buffer(gl_, texels, "the probes"), static_cast<int>(balls.size())};
}

void BallDrawing::draw(const Eye& eye, const BallTable& table, const BallLook& look) const {
    if (table.count == 0) return;
    gl_.UseProgram(program_.name());
    const Uniforms uniforms(gl_, program_);
    uniforms.set("clip_from_level", eye.clip_from_level);
    uniforms.set("ray", eye.ray);
    uniforms.set("before_all", look.before_all ? 1 : 0);
    uniforms.set("rim_from", look.rims ? 0.8F : 2.0F);
    uniforms.set("band_factors", irradiance_factors(look.bands));
    uniforms.set("light_scale", albedo * eye.exposure * look.gain * std::numbers::inv_pi_v<float>);
    uniforms.set("tone", static_cast<int>(look.tone));
    uniforms.set("balls", 0);
    gl_.ActiveTexture(GL_TEXTURE0);
    gl_.BindTexture(GL_TEXTURE_BUFFER, table.texels.texture.name());
    gl_.BindVertexArray(vertex_array_.name());
    gl_.DrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, table.count);
    gl_.BindVertexArray(0);
}

}  // namespace lightgrid
