#pragma once

#include "viewer/eye.h"
#include "viewer/gl_objects.h"
#include "viewer/look_up.h"
#include "viewer/material_textures.h"
#include "viewer/object.h"
#include "viewer/pixel_light.h"
#include "viewer/shader.h"

#include <glm/glm.hpp>

#include <optional>
#include <span>
#include <vector>

namespace lightgrid {

/// Where an object is and how large.
struct ObjectPlace {
    glm::dvec3 position{0};  // of its centre, level coordinates
    glm::mat3 rotation{1};
    float size = 1;  // of its longest side, metres
};

/// The light of an object.
struct ObjectLighting {
    Sh36 radiance{};  // at its centre, deringed where wanted: of the object as a whole; self-shadowing of three bands
    std::optional<PixelLight> pixel{};  // in its place
    bool self_shadowing = false;        // where its transfer is known
    float gain = 1;
};

/// An object with the colours of its materials. MASK cuts; BLEND and transmission are drawn as if opaque.
class ObjectDrawing {
  public:
    ObjectDrawing(const Gl& gl, const ShaderSources& shaders, const ObjectMesh& mesh);

    /// transfer  self_shadowed_transfer of the mesh, of three bands
    void set_transfer(std::span<const float> transfer);

    void draw(const Eye& eye, const ObjectPlace& place, const ObjectLighting& light);

  private:
    struct Part {
        ObjectDraw draw;
        Material material;
        GLuint base_color = 0;  // textures
        GLuint emission = 0;
    };

    const Gl& gl_;
    MaterialTextures textures_;
    std::vector<Part> parts_;
    ShaderVariants programs_;
    VertexArray vertex_array_;
    Buffer vertices_;
    Buffer indices_;
    Buffer transfer_;  // none: not known yet
};

}  // namespace lightgrid
