#pragma once

#include "core/scene.h"
#include "viewer/eye.h"
#include "viewer/false_colors.h"
#include "viewer/gl_objects.h"
#include "viewer/level_mesh.h"
#include "viewer/material_textures.h"
#include "viewer/object_shadow.h"
#include "viewer/pixel_light.h"
#include "viewer/settings.h"
#include "viewer/shader.h"
#include "viewer/texel_buffer.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace lightgrid {

/// The level on the card: base colour, alpha, transmission and emission, lit by a table of light at its vertices.
class LevelDrawing {
  public:
    /// Keeps nothing of the scene.
    ///
    /// outlines  materials that are seen from their front only, for each of the scene's; see find_outlines()
    ///
    /// Throws Error for what the card cannot hold.
    LevelDrawing(const Gl& gl, const ShaderSources& shaders, const Scene& scene, LevelMesh mesh,
                 const std::vector<bool>& outlines);

    [[nodiscard]] const LevelMesh& mesh() const noexcept { return mesh_; }

    /// A table of light for draw(); see light_level().
    [[nodiscard]] TexelBuffer make_light_table(std::span<const VertexLight> light) const;

    struct Light {
        LevelLight kind = LevelLight::none;
        glm::vec3 constant{0};               // lux, for LevelLight::constant
        const TexelBuffer* table = nullptr;  // for LevelLight::vertex
        PixelLight pixel{};                  // for LevelLight::pixel
        float gain = 1;
        std::span<const glm::vec3> emission_weights{};  // by material, of what it emits; none: 1
        std::optional<ObjectShadow> shadow{};
        std::optional<FalseColors> colors{};  // in the place of what is lit
    };
    /// What hides what is behind it, but where MASK cuts it away; writes depth.
    void draw_opaque(const Eye& eye, const Light& light);
    /// What lets light through, over what has been drawn; see farthest_first().
    void draw_blended(const Eye& eye, const Light& light);

  private:
    struct Surface {
        Material material;
        GLuint base_color = 0;  // textures
        GLuint emission = 0;
        GLuint transmission = 0;
        bool front_only = false;
    };

    enum class Shader : std::uint8_t { opaque, see_through };
    /// The program for this light, with the shadow or without.
    [[nodiscard]] const Program& program(Shader shader, const Light& light, bool with_shadow);
    void draw(const Program& program, std::span<const LevelDraw* const> draws, const Buffer& indices, const Eye& eye,
              const Light& light) const;
    /// Puts indices where draw() may read them from.
    void stream(std::span<const std::uint32_t> indices) const;
    void set_eye(const Uniforms& uniforms, const Eye& eye, const Light& light) const;
    /// emission_scale  of its factor, exposure included
    void set_material(const Uniforms& uniforms, const Surface& surface, glm::vec3 emission_scale) const;

    const Gl& gl_;
    LevelMesh mesh_;
    MaterialTextures textures_;
    std::vector<Surface> surfaces_;
    std::vector<std::size_t> opaque_;   // of the mesh's draws, by material
    std::vector<std::size_t> cut_out_;  // likewise: MASK
    std::vector<std::size_t> blended_;  // BLEND and transmission
    ShaderVariants programs_;
    VertexArray vertex_array_;
    Buffer vertices_;
    Buffer indices_;
    Buffer streamed_indices_;  // of what is drawn in another order than the mesh's
    TexelBuffer instances_;
};

}  // namespace lightgrid
