#pragma once

#include "core/scene.h"
#include "viewer/eye.h"
#include "viewer/gl_objects.h"
#include "viewer/level_mesh.h"
#include "viewer/material_textures.h"
#include "viewer/settings.h"
#include "viewer/shader.h"

#include <glm/glm.hpp>

#include <span>
#include <vector>

namespace lightgrid {

/// A buffer that shaders read texel by texel.
struct TexelBuffer {
    Buffer buffer;
    GlTexture texture;
};

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
        const TexelBuffer* table = nullptr;  // for LevelLight::vertex
        glm::vec3 constant{0};               // lux, for LevelLight::constant
        LevelLight kind = LevelLight::none;
        float gain = 1;
    };
    /// What hides what is behind it, but where MASK cuts it away; writes depth.
    void draw_opaque(const Eye& eye, const Light& light) const;
    /// What lets light through, over what has been drawn, the farthest first.
    void draw_blended(const Eye& eye, const Light& light) const;

  private:
    struct Surface {
        Material material;
        GLuint base_color = 0;  // textures
        GLuint emission = 0;
        GLuint transmission = 0;
        bool front_only = false;
    };

    void draw(const Program& program, std::span<const std::size_t> draws, const Eye& eye, const Light& light) const;
    void set_eye(const Uniforms& uniforms, const Eye& eye, const Light& light) const;
    void set_material(const Uniforms& uniforms, const Surface& surface, float exposure) const;

    const Gl& gl_;
    LevelMesh mesh_;
    MaterialTextures textures_;
    std::vector<Surface> surfaces_;
    std::vector<std::size_t> opaque_;   // of the mesh's draws, by material
    std::vector<std::size_t> cut_out_;  // likewise: MASK
    std::vector<std::size_t> blended_;  // BLEND and transmission
    Program opaque_program_;
    Program see_through_program_;
    VertexArray vertex_array_;
    Buffer vertices_;
    Buffer indices_;
    TexelBuffer instances_;
};

}  // namespace lightgrid
