#pragma once

#include "viewer/eye.h"
#include "viewer/settings.h"
#include "viewer/shader.h"

#include <glm/glm.hpp>

#include <span>

namespace lightgrid {

struct LineEnd {
    glm::vec3 position{0};  // relative to Scene::origin
    glm::vec3 color{0};     // sRGB
};

/// Lines a pixel wide, before everything.
class LineDrawing {
  public:
    LineDrawing(const Gl& gl, const ShaderSources& shaders);

    /// ends  two a line
    /// tone  that the colours have to survive
    void draw(const Eye& eye, std::span<const LineEnd> ends, Tone tone) const;

  private:
    const Gl& gl_;
    Program program_;
    VertexArray vertex_array_;
    Buffer ends_;
};

}  // namespace lightgrid
