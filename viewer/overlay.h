#pragma once

#include "viewer/facts.h"
#include "viewer/gl.h"
#include "viewer/session.h"

#include <glm/glm.hpp>

#include <memory>
#include <string>

namespace lightgrid {

class Window;

/// Controls, numbers and help beside and over the picture. One at a time: the library behind it has one current context.
class Overlay {
  public:
    /// Keeps a reference; the window's context must be current. Takes part in its input.
    explicit Overlay(Window& window);
    ~Overlay();
    Overlay(const Overlay&) = delete;
    Overlay& operator=(const Overlay&) = delete;

    /// Where things go, pixels: the panel stands on the left and the picture beside it, so that neither hides the other.
    struct Layout {
        int panel = 0;  // its width; 0: none, as asked or for lack of room
        glm::ivec2 picture{0};
    };
    /// Starts a frame.
    ///
    /// size  of the window's framebuffer, at least 1 x 1
    [[nodiscard]] Layout begin(const Session& session, glm::ivec2 size);
    /// The input without what is meant for the overlay, its cursor from the picture's corner.
    [[nodiscard]] Input what_is_left(Input input, const Layout& layout) const;
    /// Takes what a person sets.
    ///
    /// spheres  texture with a SpherePair's picture, for the light that was clicked at; 0: none yet
    void lay_out(Session& session, const Facts& facts, const Layout& layout, GLuint spheres, Requests& requests);
    /// Over what the window's framebuffer shows. Ends the frame.
    void draw();

    /// Shows a message for some seconds.
    void tell(const std::string& text);

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace lightgrid
