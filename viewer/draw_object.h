#pragma once

#include "viewer/eye.h"
#include "viewer/gl_objects.h"
#include "viewer/look_up.h"
#include "viewer/material_textures.h"
#include "viewer/object.h"
#include "viewer/shader.h"

#include <glm/glm.hpp>

#include <vector>

namespace lightgrid {

/// Where an object is and how large.
struct ObjectPlace {
    glm::dvec3 position{0};  // of its centre, level coordinates
    glm::mat3 rotation{1};
    float size = 1;  // of its longest side, metres
};

/// An object with the colours of its materials, lit as a whole by one look-up. MASK cuts; BLEND and transmission are
/// drawn as if opaque.
class ObjectDrawing {
  public:
    ObjectDrawing(const Gl& gl, const ShaderSources& shaders, const ObjectMesh& mesh);

    /// irradiance  see irradiance_sh(); times gain
    void draw(const Eye& eye, const ObjectPlace& place, const Sh36& irradiance) const;

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
    Program program_;
    VertexArray vertex_array_;
    Buffer vertices_;
    Buffer indices_;
};

}  // namespace lightgrid
