#pragma once

#include "tools/canvas.h"
#include "viewer/picture_target.h"

namespace lightgrid {

/// A small picture that is laid over the developed one.
class LabelDrawing {
  public:
    LabelDrawing(const Gl& gl, const ShaderSources& shaders, const Canvas& canvas);

    /// Into the upper right corner of a part of the picture, as much of it as has room; after develop().
    void draw(const Rectangle& part) const;

  private:
    const Gl& gl_;
    glm::ivec2 size_;
    Program program_;
    VertexArray vertex_array_;
    GlTexture texture_;
};

}  // namespace lightgrid
