#pragma once

#include "viewer/eye.h"
#include "viewer/gl_objects.h"
#include "viewer/look_up.h"
#include "viewer/object.h"
#include "viewer/shader.h"

#include <glm/glm.hpp>

namespace lightgrid {

/// Where an object is and how large.
struct ObjectPlace {
    glm::dvec3 position{0};  // of its centre, level coordinates
    glm::mat3 rotation{1};
    float size = 1;  // of its longest side, metres
};

/// An object of white clay, lit as a whole by one look-up.
class ObjectDrawing {
  public:
    ObjectDrawing(const Gl& gl, const ShaderSources& shaders, const ObjectMesh& mesh);

    /// irradiance  see irradiance_sh(); times gain
    void draw(const Eye& eye, const ObjectPlace& place, const Sh9& irradiance) const;

  private:
    const Gl& gl_;
    Program program_;
    VertexArray vertex_array_;
    Buffer vertices_;
    Buffer indices_;
    int index_count_ = 0;
};

}  // namespace lightgrid
