#include "viewer/draw_object.h"

#include "core/sh.h"

#include <algorithm>
#include <cstddef>
#include <numbers>
#include <string>

namespace lightgrid {
namespace {

struct Vertex {
    glm::vec3 position;
    glm::vec3 normal;
    glm::vec2 base_color_uv;
    glm::vec2 emission_uv;
    glm::vec4 color;
};

enum Unit : int { base_color_unit, emission_unit, volume_unit };

void enable_attribute(const Gl& gl, GLuint location, GLint size, std::size_t stride, std::size_t offset) {
    gl.EnableVertexAttribArray(location);
    gl.VertexAttribPointer(location, size, GL_FLOAT, GL_FALSE, static_cast<GLsizei>(stride),
                           reinterpret_cast<const void*>(offset));  // NOLINT(performance-no-int-to-ptr)
}

}  // namespace

ObjectDrawing::ObjectDrawing(const Gl& gl, const ShaderSources& shaders, const ObjectMesh& mesh)
    : gl_(gl),
      textures_(gl, mesh.name),
      programs_(gl, shaders, "object.vert", "object.frag"),
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
    enable_attribute(gl, 0, 3, sizeof(Vertex), offsetof(Vertex, position));
    enable_attribute(gl, 1, 3, sizeof(Vertex), offsetof(Vertex, normal));
    enable_attribute(gl, 2, 2, sizeof(Vertex), offsetof(Vertex, base_color_uv));
    enable_attribute(gl, 3, 2, sizeof(Vertex), offsetof(Vertex, emission_uv));
    enable_attribute(gl, 4, 4, sizeof(Vertex), offsetof(Vertex, color));
    gl.BindVertexArray(0);
    check_gl(gl, "uploading the object");
}

void ObjectDrawing::set_transfer(std::span<const float> transfer) {
    transfer_ = make_buffer(gl_);
    gl_.BindVertexArray(vertex_array_.name());
    gl_.BindBuffer(GL_ARRAY_BUFFER, transfer_.name());
    gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(transfer.size_bytes()), transfer.data(), GL_STATIC_DRAW);
    for (std::size_t third = 0; third < 3; ++third) {
        enable_attribute(gl_, static_cast<GLuint>(5 + third), 3, 9 * sizeof(float), 3 * third * sizeof(float));
    }
    gl_.BindVertexArray(0);
}

void ObjectDrawing::draw(const Eye& eye, const ObjectPlace& place, const ObjectLighting& light) {
    std::vector<std::string> defines;
    if (light.pixel) defines.emplace_back("PIXEL_LIGHT");
    if (light.pixel && light.pixel->filter == Filter::nearest) defines.emplace_back("NEAREST");
    const bool self_shadowing = light.self_shadowing && transfer_;
    if (self_shadowing) defines.emplace_back("SELF_SHADOWING");
    const Program& program = programs_.with(defines);
    gl_.UseProgram(program.name());
    const Uniforms uniforms(gl_, program);
    uniforms.set("clip_from_level", eye.clip_from_level);
    uniforms.set("rotation", place.rotation);
    uniforms.set("size", place.size);
    uniforms.set("center", glm::vec3(place.position - eye.origin));
    if (self_shadowing) {
        Sh9 turned{};
        std::copy_n(light.radiance.begin(), turned.size(), turned.begin());
        ShRotation(3, glm::dmat3(glm::transpose(place.rotation))).apply(turned);
        uniforms.set("turned_radiance", turned.data(), static_cast<int>(turned.size()));
    }
    Sh36 irradiance = light.radiance;
    convolve_with_cosine(irradiance);
    uniforms.set("bands", used_bands(irradiance));
    uniforms.set("irradiance", irradiance.data(), static_cast<int>(irradiance.size()));
    uniforms.set("light_scale", eye.exposure * light.gain * std::numbers::inv_pi_v<float>);
    if (light.pixel) set_pixel_light(gl_, uniforms, *light.pixel, volume_unit);
    uniforms.set("base_color_map", base_color_unit);
    uniforms.set("emission_map", emission_unit);
    gl_.BindVertexArray(vertex_array_.name());
    for (const Part& part : parts_) {
        const Material& material = part.material;
        gl_.ActiveTexture(GL_TEXTURE0 + base_color_unit);
        gl_.BindTexture(GL_TEXTURE_2D, part.base_color);
        gl_.ActiveTexture(GL_TEXTURE0 + emission_unit);
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
