#include "viewer/draw_object.h"

#include <numbers>

namespace lightgrid {
namespace {

constexpr float albedo = 0.8F;

struct Vertex {
    glm::vec3 position;
    glm::vec3 normal;
};

}  // namespace

ObjectDrawing::ObjectDrawing(const Gl& gl, const ShaderSources& shaders, const ObjectMesh& mesh)
    : gl_(gl),
      program_(compile_program(gl, shaders, "object.vert", "object.frag")),
      vertex_array_(make_vertex_array(gl)),
      vertices_(make_buffer(gl)),
      indices_(make_buffer(gl)),
      index_count_(static_cast<int>(3 * mesh.triangles.size())) {
    std::vector<Vertex> vertices;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) vertices.push_back({mesh.positions[i], mesh.normals[i]});
    gl.BindVertexArray(vertex_array_.name());
    gl.BindBuffer(GL_ARRAY_BUFFER, vertices_.name());
    gl.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(Vertex)), vertices.data(),
                  GL_STATIC_DRAW);
    gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_.name());
    gl.BufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(mesh.triangles.size() * sizeof(glm::uvec3)),
                  mesh.triangles.data(), GL_STATIC_DRAW);
    for (const GLuint location : {0U, 1U}) {
        gl.EnableVertexAttribArray(location);
        gl.VertexAttribPointer(
            location, 3, GL_FLOAT, GL_FALSE, sizeof(Vertex),
            reinterpret_cast<const void*>(location * sizeof(glm::vec3)));  // NOLINT(performance-no-int-to-ptr)
    }
    gl.BindVertexArray(0);
    check_gl(gl, "uploading the object");
}

void ObjectDrawing::draw(const Eye& eye, const ObjectPlace& place, const Sh9& irradiance) const {
    gl_.UseProgram(program_.name());
    const Uniforms uniforms(gl_, program_);
    uniforms.set("clip_from_level", eye.clip_from_level);
    uniforms.set("rotation", place.rotation);
    uniforms.set("size", place.size);
    uniforms.set("center", glm::vec3(place.position - eye.origin));
    uniforms.set("irradiance", irradiance.data(), static_cast<int>(irradiance.size()));
    uniforms.set("light_scale", glm::vec3(eye.exposure * albedo * std::numbers::inv_pi_v<float>));
    gl_.BindVertexArray(vertex_array_.name());
    gl_.DrawElements(GL_TRIANGLES, index_count_, GL_UNSIGNED_INT, nullptr);
    gl_.BindVertexArray(0);
}

}  // namespace lightgrid
