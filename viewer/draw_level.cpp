#include "viewer/draw_level.h"

#include "viewer/blend_order.h"

#include <algorithm>
#include <cstddef>
#include <numbers>
#include <string>
#include <utility>

namespace lightgrid {
namespace {

void bind(const Gl& gl, int unit, GLenum target, GLuint texture) {
    gl.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    gl.BindTexture(target, texture);
}

std::vector<const LevelDraw*> pointers_to(std::span<const LevelDraw> draws) {
    std::vector<const LevelDraw*> pointers;
    for (const LevelDraw& draw : draws) pointers.push_back(&draw);
    return pointers;
}

enum Unit : int { base_color_unit, emission_unit, transmission_unit, instances_unit, light_unit, volume_unit };

}  // namespace

LevelDrawing::LevelDrawing(const Gl& gl, const ShaderSources& shaders, const Scene& scene, LevelMesh mesh,
                           const std::vector<bool>& outlines)
    : gl_(gl),
      mesh_(std::move(mesh)),
      textures_(gl, scene.name),
      programs_(gl, shaders, "level.vert", "level.frag"),
      vertex_array_(make_vertex_array(gl)),
      vertices_(make_buffer(gl)),
      indices_(make_buffer(gl)),
      streamed_indices_(make_buffer(gl)) {
    for (const Material& material : scene.materials) {
        Surface surface;
        surface.material = material;
        surface.base_color = textures_.use(scene.textures, material.base_color_texture, Encoding::srgb);
        surface.emission = textures_.use(scene.textures, material.emission_texture, Encoding::srgb);
        surface.transmission = textures_.use(scene.textures, material.transmission_texture, Encoding::linear);
        surface.front_only = outlines[surfaces_.size()];
        surfaces_.push_back(std::move(surface));
    }

    for (std::size_t i = 0; i < mesh_.draws.size(); ++i) {
        const Material& material = surfaces_[static_cast<std::size_t>(mesh_.draws[i].material)].material;
        if (!material.passes_light()) {
            opaque_.push_back(i);
        } else if (material.alpha_mode == AlphaMode::mask && material.transmission == 0) {
            cut_out_.push_back(i);
        } else {
            blended_.push_back(i);
        }
    }
    for (std::vector<std::size_t>* draws : {&opaque_, &cut_out_}) {
        std::stable_sort(draws->begin(), draws->end(), [&](std::size_t a, std::size_t b) {
            return mesh_.draws[a].material < mesh_.draws[b].material;
        });
    }

    gl.BindVertexArray(vertex_array_.name());
    gl.BindBuffer(GL_ARRAY_BUFFER, vertices_.name());
    gl.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(mesh_.vertices.size() * sizeof(LevelVertex)),
                  mesh_.vertices.data(), GL_STATIC_DRAW);
    gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_.name());
    gl.BufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(mesh_.indices.size() * sizeof(std::uint32_t)),
                  mesh_.indices.data(), GL_STATIC_DRAW);
    const auto attribute = [&](GLuint location, GLint size, GLenum type, GLboolean normalised, std::size_t offset) {
        gl.EnableVertexAttribArray(location);
        gl.VertexAttribPointer(location, size, type, normalised, sizeof(LevelVertex),
                               reinterpret_cast<const void*>(offset));  // NOLINT(performance-no-int-to-ptr)
    };
    attribute(0, 3, GL_FLOAT, GL_FALSE, offsetof(LevelVertex, position));
    attribute(1, 3, GL_SHORT, GL_TRUE, offsetof(LevelVertex, normal));
    attribute(2, 2, GL_FLOAT, GL_FALSE, offsetof(LevelVertex, base_color_uv));
    attribute(3, 2, GL_FLOAT, GL_FALSE, offsetof(LevelVertex, emission_uv));
    attribute(4, 2, GL_FLOAT, GL_FALSE, offsetof(LevelVertex, transmission_uv));
    attribute(5, 4, GL_UNSIGNED_SHORT, GL_TRUE, offsetof(LevelVertex, color));
    gl.BindVertexArray(0);

    std::vector<glm::vec4> rows;
    for (const glm::mat4x3& to_level : mesh_.instances) {
        const glm::mat3x4 transposed = glm::transpose(to_level);
        for (int row = 0; row < 3; ++row) rows.push_back(transposed[row]);
    }
    instances_ = make_texel_buffer(gl, rows, scene.name);
    check_gl(gl, "uploading the level");
}

TexelBuffer LevelDrawing::make_light_table(std::span<const VertexLight> light) const {
    static_assert(sizeof(VertexLight) == 2 * sizeof(glm::vec4));
    const std::span texels(reinterpret_cast<const glm::vec4*>(light.data()), 2 * light.size());
    return make_texel_buffer(gl_, texels, "the level's light");
}

void LevelDrawing::set_eye(const Uniforms& uniforms, const Eye& eye, const Light& light) const {
    uniforms.set("clip_from_level", eye.clip_from_level);
    uniforms.set("base_color_map", base_color_unit);
    uniforms.set("emission_map", emission_unit);
    uniforms.set("transmission_map", transmission_unit);
    uniforms.set("instances", instances_unit);
    uniforms.set("light_table", light_unit);
    const bool by_vertex = light.kind == LevelLight::vertex && light.table != nullptr;
    uniforms.set("lit_by_vertex", by_vertex ? 1 : 0);
    uniforms.set("constant_light", light.kind == LevelLight::none ? glm::vec3(0) : light.constant);
    uniforms.set("light_scale", eye.exposure * light.gain * std::numbers::inv_pi_v<float>);
    bind(gl_, instances_unit, GL_TEXTURE_BUFFER, instances_.texture.name());
    bind(gl_, light_unit, GL_TEXTURE_BUFFER, by_vertex ? light.table->texture.name() : instances_.texture.name());
    if (light.kind == LevelLight::pixel) set_pixel_light(gl_, uniforms, light.pixel, volume_unit);
    if (light.shadow) set_shadow(uniforms, *light.shadow);
    if (light.colors) set_false_colors(uniforms, *light.colors);
}

void LevelDrawing::set_material(const Uniforms& uniforms, const Surface& surface, glm::vec3 emission_scale) const {
    const Material& material = surface.material;
    bind(gl_, base_color_unit, GL_TEXTURE_2D, surface.base_color);
    bind(gl_, emission_unit, GL_TEXTURE_2D, surface.emission);
    bind(gl_, transmission_unit, GL_TEXTURE_2D, surface.transmission);
    uniforms.set("base_color", glm::vec4(material.base_color, material.alpha));
    uniforms.set("emission", material.emission * emission_scale);
    uniforms.set("emits", material.emits() ? 1 : 0);
    uniforms.set("double_sided", material.double_sided ? 1 : 0);
    uniforms.set("alpha_cutoff", material.alpha_mode == AlphaMode::mask ? material.alpha_cutoff : -1.0F);
    uniforms.set("blend", material.alpha_mode == AlphaMode::blend ? 1 : 0);
    uniforms.set("transmission", material.transmission);
}

const Program& LevelDrawing::program(Shader shader, const Light& light, bool with_shadow) {
    std::vector<std::string> defines;
    if (shader == Shader::see_through) defines.emplace_back("SEE_THROUGH");
    if (light.kind == LevelLight::pixel) {
        defines.emplace_back("PIXEL_LIGHT");
        if (light.pixel.filter == Filter::nearest) defines.emplace_back("NEAREST");
    }
    if (with_shadow) defines.emplace_back("SHADOW");
    if (light.colors) defines.emplace_back("FALSE_COLORS");
    return programs_.with(defines);
}

void LevelDrawing::draw(const Program& program, std::span<const LevelDraw* const> draws, const Buffer& indices,
                        const Eye& eye, const Light& light) const {
    gl_.UseProgram(program.name());
    gl_.BindVertexArray(vertex_array_.name());
    gl_.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices.name());
    const Uniforms uniforms(gl_, program);
    set_eye(uniforms, eye, light);
    int material = -1;
    for (const LevelDraw* draw : draws) {
        const LevelDraw& next = *draw;
        if (eye.misses(next.bounds)) continue;
        if (next.material != material) {
            material = next.material;
            const auto number = static_cast<std::size_t>(material);
            const glm::vec3 weight = light.emission_weights.empty() ? glm::vec3(1) : light.emission_weights[number];
            set_material(uniforms, surfaces_[number], eye.exposure * weight);
            if (surfaces_[static_cast<std::size_t>(material)].front_only) {
                gl_.Enable(GL_CULL_FACE);
            } else {
                gl_.Disable(GL_CULL_FACE);
            }
        }
        uniforms.set("first_instance", next.first_instance);
        uniforms.set("first_light", static_cast<int>(next.first_light) - static_cast<int>(next.first_vertex));
        uniforms.set("light_stride", static_cast<int>(next.light_stride));
        gl_.FrontFace(next.mirrored ? GL_CW : GL_CCW);
        const std::size_t offset = next.first_index * sizeof(std::uint32_t);
        gl_.DrawElementsInstanced(GL_TRIANGLES, static_cast<GLsizei>(next.index_count), GL_UNSIGNED_INT,
                                  reinterpret_cast<const void*>(offset),  // NOLINT(performance-no-int-to-ptr)
                                  next.instance_count);
    }
    gl_.Disable(GL_CULL_FACE);
    gl_.FrontFace(GL_CCW);
    gl_.BindVertexArray(0);
}

void LevelDrawing::stream(std::span<const std::uint32_t> indices) const {
    gl_.BindVertexArray(vertex_array_.name());
    gl_.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, streamed_indices_.name());
    gl_.BufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(indices.size_bytes()), indices.data(),
                   GL_STREAM_DRAW);
}

void LevelDrawing::draw_opaque(const Eye& eye, const Light& light) {
    for (const auto& [shader, draws] :
         {std::pair(Shader::opaque, &opaque_), std::pair(Shader::see_through, &cut_out_)}) {
        std::vector<const LevelDraw*> reached;
        std::vector<const LevelDraw*> others;
        for (const std::size_t i : *draws) {
            const LevelDraw& next = mesh_.draws[i];
            if (eye.misses(next.bounds)) continue;
            (light.shadow && light.shadow->reaches(next.bounds) ? reached : others).push_back(&next);
        }
        // Most of a level is spared the shadow's cost. What is near the object is rather in front of the rest: it comes
        // first, so that less is drawn twice.
        if (!reached.empty()) {
            const ShadowSplit split = split_by_shadow(mesh_, reached, *light.shadow);
            stream(split.indices);
            draw(program(shader, light, true), pointers_to(split.shaded), streamed_indices_, eye, light);
            draw(program(shader, light, false), pointers_to(split.others), streamed_indices_, eye, light);
        }
        if (!others.empty()) draw(program(shader, light, false), others, indices_, eye, light);
    }
}

void LevelDrawing::draw_blended(const Eye& eye, const Light& light) {
    const BlendOrder order = farthest_first(mesh_, blended_, eye);
    if (order.draws.empty()) return;
    stream(order.indices);
    gl_.Enable(GL_BLEND);
    gl_.BlendFunc(GL_ONE, GL_SRC1_COLOR);
    gl_.DepthMask(GL_FALSE);
    draw(program(Shader::see_through, light, light.shadow.has_value()), pointers_to(order.draws), streamed_indices_,
         eye, light);
    gl_.DepthMask(GL_TRUE);
    gl_.Disable(GL_BLEND);
}

}  // namespace lightgrid
