#include "viewer/draw_lines.h"

#include <cstddef>

namespace lightgrid {

LineDrawing::LineDrawing(const Gl& gl, const ShaderSources& shaders)
    : gl_(gl),
      program_(compile_program(gl, shaders, "line.vert", "line.frag")),
      vertex_array_(make_vertex_array(gl)),
      ends_(make_buffer(gl)) {
    gl.BindVertexArray(vertex_array_.name());
    gl.BindBuffer(GL_ARRAY_BUFFER, ends_.name());
    gl.EnableVertexAttribArray(0);
    gl.VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(LineEnd), nullptr);
    gl.EnableVertexAttribArray(1);
    gl.VertexAttribPointer(
        1, 3, GL_FLOAT, GL_FALSE, sizeof(LineEnd),
        reinterpret_cast<const void*>(offsetof(LineEnd, color)));  // NOLINT(performance-no-int-to-ptr)
    gl.BindVertexArray(0);
}

void LineDrawing::draw(const Eye& eye, std::span<const LineEnd> ends, Tone tone) const {
    gl_.UseProgram(program_.name());
    const Uniforms uniforms(gl_, program_);
    uniforms.set("clip_from_level", eye.clip_from_level);
    uniforms.set("tone", static_cast<int>(tone));
    gl_.BindVertexArray(vertex_array_.name());
    gl_.BindBuffer(GL_ARRAY_BUFFER, ends_.name());
    gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(ends.size_bytes()), ends.data(), GL_STATIC_DRAW);
    gl_.DrawArrays(GL_LINES, 0, static_cast<GLsizei>(ends.size()));
    gl_.BindVertexArray(0);
}

}  // namespace lightgrid
