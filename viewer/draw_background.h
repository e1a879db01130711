#pragma once

#include "core/environment.h"
#include "viewer/eye.h"
#include "viewer/gl_objects.h"
#include "viewer/look_up.h"
#include "viewer/shader.h"

namespace lightgrid {

/// What is seen where the level ends: the environment that it was baked with; where nobody named one, or where it is asked
/// for, the radiance that the volume says arrives at the eye.
class BackgroundDrawing {
  public:
    BackgroundDrawing(const Gl& gl, const ShaderSources& shaders);

    /// Black environments count as not named.
    void set_environment(const Environment& environment);
    [[nodiscard]] bool has_environment() const noexcept { return static_cast<bool>(environment_); }

    /// Fills what has no depth yet.
    ///
    /// picture   the environment, where there is one; else and otherwise the radiance that the coefficients stand for
    /// turn      of the environment, from its own axes to the level's
    void draw(const Eye& eye, bool picture, const glm::mat3& turn, const Sh36& radiance) const;

  private:
    const Gl& gl_;
    Program program_;
    VertexArray vertex_array_;  // without attributes: the shader makes its triangle up
    GlTexture environment_;
};

}  // namespace lightgrid
