#include "viewer/draw_object.h"

#include <cstddef>
#include <numbers>

namespace lightgrid {
namespace {

struct Vertex {
    glm::vec3 position;
    glm::vec3 normal;
    glm::vec2 base_color_uv;
    glm::vec2 emission_uv;
    glm::vec4 color;
};

}  // namespace

ObjectDrawing::ObjectDrawing(const Gl& gl, const ShaderSources& shaders, const ObjectMesh& mesh)
    : gl_(gl),
      textures_(gl, mesh.name),
      program_(compile_program(gl, shaders, "object.vert", "object.frag")),
      vertex_array_(make_vertex_array(gl)),
      vertices_(make_buffer(gl)),
      indices_(make_buffer(gl)) {
    for (const ObjectDraw& draw : mesh.draws) {
        const Material& material = mesh.materials[static_cast<std::size_t>(draw.material)];
        parts_.push_back({draw, material, textures_.use(mesh.textures, material.base_color_texture, Encoding::srgb),
                          textures_.use(mesh.textures, material.emission_texture, Encoding::srgb)});
    }
    std::vector<Vertex> vertices;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        vertices.push_back({mesh.positions[i], mesh.normals[i], mesh.uvs[i], mesh.emission_uvs[i], mesh.colors[i]});
    }
    gl.BindVertexArray(vertex_array_.name());
    gl.BindBuffer(GL_ARRAY_BUFFER, vertices_.name());
    gl.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(Vertex)), vertices.data(),
                  GL_STATIC_DRAW);
    gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_.name());
    gl.BufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(mesh.triangles.size() * sizeof(glm::uvec3)),
                  mesh.triangles.data(), GL_STATIC_DRAW);
    const auto attribute = [&](GLuint location, GLint size, std::size_t offset) {
        gl.EnableVertexAttribArray(location);
        gl.VertexAttribPointer(location, size, GL_FLOAT, GL_FALSE, sizeof(Vertex),
                               reinterpret_cast<const void*>(offset));  // NOLINT(performance-no-int-to-ptr)
    };
    attribute(0, 3, offsetof(Vertex, position));
    attribute(1, 3, offsetof(Vertex, normal));
    attribute(2, 2, offsetof(Vertex, base_color_uv));
    attribute(3, 2, offsetof(Vertex, emission_uv));
    attribute(4, 4, offsetof(Vertex, color));
    gl.BindVertexArray(0);
    check_gl(gl, "uploading the object");
}

void ObjectDrawing::draw(const Eye& eye, const ObjectPlace& place, const Sh36& irradiance) const {
    gl_.UseProgram(program_.name());
    const Uniforms uniforms(gl_, program_);
    uniforms.set("clip_from_level", eye.clip_from_level);
    uniforms.set("rotation", place.rotation);
    uniforms.set("size", place.size);
    uniforms.set("center", glm::vec3(place.position - eye.origin));
    uniforms.set("bands", used_bands(irradiance));
    uniforms.set("irradiance", irradiance.data(), static_cast<int>(irradiance.size()));
    uniforms.set("light_scale", eye.exposure * std::numbers::inv_pi_v<float>);
    uniforms.set("base_color_map", 0);
    uniforms.set("emission_map", 1);
    gl_.BindVertexArray(vertex_array_.name());
    for (const Part& part : parts_) {
        const Material& material = part.material;
        gl_.ActiveTexture(GL_TEXTURE0);
        gl_.BindTexture(GL_TEXTURE_2D, part.base_color);
        gl_.ActiveTexture(GL_TEXTURE1);
        gl_.BindTexture(GL_TEXTURE_2D, part.emission);
        uniforms.set("base_color", glm::vec4(material.base_color, material.alpha));
        uniforms.set("emission", material.emission * eye.exposure);
        uniforms.set("alpha_cutoff", material.alpha_mode == AlphaMode::mask ? material.alpha_cutoff : -1.0F);
        const std::size_t offset = part.draw.first_triangle * sizeof(glm::uvec3);
        gl_.DrawElements(GL_TRIANGLES, static_cast<GLsizei>(3 * part.draw.triangle_count), GL_UNSIGNED_INT,
                         reinterpret_cast<const void*>(offset));  // NOLINT(performance-no-int-to-ptr)
    }
    gl_.BindVertexArray(0);
}

}  // namespace lightgrid
