#pragma once

#include "viewer/camera.h"
#include "viewer/draw_object.h"
#include "viewer/look_up.h"
#include "viewer/picture_target.h"

namespace lightgrid {

/// A small picture of two white spheres side by side, each under a light of its own.
class SpherePair {
  public:
    static constexpr glm::ivec2 size{192, 96};

    SpherePair(const Gl& gl, const ShaderSources& shaders);

    /// left, right  radiance
    /// pose         seen from the same side as all else
    /// exposure     times gain
    void draw(const Sh36& left, const Sh36& right, const Pose& pose, float exposure, Tone tone);

    /// The picture, its first row at the bottom.
    [[nodiscard]] GLuint texture() const noexcept { return target_.picture(); }

  private:
    const Gl& gl_;
    PictureTarget target_;
    ObjectDrawing sphere_;
};

}  // namespace lightgrid
