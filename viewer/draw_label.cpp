#include "viewer/draw_label.h"

namespace lightgrid {

LabelDrawing::LabelDrawing(const Gl& gl, const ShaderSources& shaders, const Canvas& canvas)
    : gl_(gl),
      size_(canvas.width, canvas.height),
      program_(compile_program(gl, shaders, "develop.vert", "label.frag")),
      vertex_array_(make_vertex_array(gl)),
      texture_(make_texture(gl)) {
    gl.ActiveTexture(GL_TEXTURE0);
    gl.BindTexture(GL_TEXTURE_2D, texture_.name());
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGB32F, size_.x, size_.y, 0, GL_RGB, GL_FLOAT, canvas.pixels.data());
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
}

void LabelDrawing::draw(const Rectangle& part) const {
    const glm::ivec2 room = glm::min(size_, part.size);
    const glm::ivec2 upper_right = part.corner + part.size;
    gl_.Viewport(upper_right.x - room.x, upper_right.y - room.y, room.x, room.y);
    gl_.Disable(GL_DEPTH_TEST);
    gl_.UseProgram(program_.name());
    const Uniforms uniforms(gl_, program_);
    uniforms.set("label", 0);
    uniforms.set("upper_right", glm::vec3(upper_right, 0));
    gl_.ActiveTexture(GL_TEXTURE0);
    gl_.BindTexture(GL_TEXTURE_2D, texture_.name());
    gl_.BindVertexArray(vertex_array_.name());
    gl_.DrawArrays(GL_TRIANGLES, 0, 3);
    gl_.BindVertexArray(0);
    gl_.Enable(GL_DEPTH_TEST);
}

}  // namespace lightgrid
