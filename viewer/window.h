#pragma once

#include "viewer/gl.h"
#include "viewer/input.h"

#include <glm/glm.hpp>

#include <memory>
#include <string>

struct GLFWwindow;

namespace lightgrid {

/// A window with an OpenGL 3.3 core context, current on the thread that made it while the object lives.
class Window {
  public:
    /// Throws Error: no display (it tells of --headless), or no OpenGL 3.3.
    Window(const std::string& title, glm::ivec2 size);
    ~Window();
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    [[nodiscard]] const Gl& gl() const noexcept;
    /// Of the framebuffer, pixels; (0, 0) while the window is minimised.
    [[nodiscard]] glm::ivec2 size() const;
    [[nodiscard]] bool should_close() const;
    void close();
    void set_title(const std::string& title);

    /// Handles what happened since the last call and tells it. Waits for something to happen where nothing is to be
    /// seen of the window.
    [[nodiscard]] Input poll();
    /// Shows what has been drawn.
    void swap();

    /// For the overlay's back end.
    [[nodiscard]] GLFWwindow* handle() const noexcept;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace lightgrid
