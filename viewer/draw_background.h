#pragma once

#include "core/environment.h"
#include "viewer/eye.h"
#include "viewer/gl_objects.h"
#include "viewer/look_up.h"
#include "viewer/shader.h"

#include <span>

namespace lightgrid {

/// What is seen where the level ends: the environment that it was baked with; where nobody named one, the radiance that
/// the volume says arrives at the eye.
class BackgroundDrawing {
  public:
    BackgroundDrawing(const Gl& gl, const ShaderSources& shaders);

    /// Black environments count as not named.
    void set_environment(const Environment& environment);
    [[nodiscard]] bool has_environment() const noexcept { return static_cast<bool>(environment_); }

    /// Fills what has no depth yet.
    ///
    /// radiance  9 coefficients, read where there is no environment
    void draw(const Eye& eye, std::span<const glm::vec3> radiance) const;

  private:
    const Gl& gl_;
    Program program_;
    VertexArray vertex_array_;  // without attributes: the shader makes its triangle up
    GlTexture environment_;
};

}  // namespace lightgrid
