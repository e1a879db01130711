#pragma once

#include "viewer/gl.h"

#include <memory>

namespace lightgrid {

/// OpenGL without a display: a context of OSMesa, current on this thread while the object lives. Only framebuffer
/// objects are of use in it; its own surface is 1 x 1.
class Headless {
  public:
    /// Throws Error (Fault::work) where OSMesa cannot make a 3.3 core context.
    Headless();
    ~Headless();
    Headless(const Headless&) = delete;
    Headless& operator=(const Headless&) = delete;

    [[nodiscard]] const Gl& gl() const noexcept;

  private:
    struct Context;
    std::unique_ptr<Context> context_;
};

}  // namespace lightgrid
