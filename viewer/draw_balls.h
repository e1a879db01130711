#pragma once

#include "viewer/eye.h"
#include "viewer/look_up.h"
#include "viewer/shader.h"
#include "viewer/texel_buffer.h"

#include <glm/glm.hpp>

#include <span>

namespace lightgrid {

/// A white sphere under light of its own, with a coloured rim.
struct Ball {
    glm::vec3 center{0};  // relative to Scene::origin
    float radius = 0;     // metres
    glm::vec3 rim{0};     // sRGB
    Sh9 radiance{};
};

/// Balls on the card.
struct BallTable {
    TexelBuffer texels;
    int count = 0;
};

/// How balls and lines are shown.
struct BallLook {
    int bands = 3;  // of their light that are used
    float gain = 1;
    Tone tone = Tone::film;   // that the colours of the rims have to survive
    bool before_all = false;  // through walls
    bool rims = true;
};

/// Draws any number of balls in one call, each as a square that a circle is cut out of.
class BallDrawing {
  public:
    BallDrawing(const Gl& gl, const ShaderSources& shaders);

    /// Throws Error for more than the card holds.
    [[nodiscard]] BallTable upload(std::span<const Ball> balls) const;
    void draw(const Eye& eye, const BallTable& table, const BallLook& look) const;

  private:
    const Gl& gl_;
    Program program_;
    VertexArray vertex_array_;
};

}  // namespace lightgrid
