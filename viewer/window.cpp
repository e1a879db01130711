#include "viewer/window.h"

#include "core/error.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/format.h>

namespace lightgrid {
namespace {

static_assert(static_cast<int>(Key::comma) == GLFW_KEY_COMMA && static_cast<int>(Key::equal) == GLFW_KEY_EQUAL);
static_assert(static_cast<int>(Key::digit_4) == GLFW_KEY_4 && static_cast<int>(Key::z) == GLFW_KEY_Z);
static_assert(static_cast<int>(Key::left_bracket) == GLFW_KEY_LEFT_BRACKET &&
              static_cast<int>(Key::right_bracket) == GLFW_KEY_RIGHT_BRACKET);
static_assert(static_cast<int>(Key::escape) == GLFW_KEY_ESCAPE && static_cast<int>(Key::tab) == GLFW_KEY_TAB);
static_assert(static_cast<int>(Key::f1) == GLFW_KEY_F1 && static_cast<int>(Key::f12) == GLFW_KEY_F12);
static_assert(static_cast<int>(Key::left_shift) == GLFW_KEY_LEFT_SHIFT &&
              static_cast<int>(Key::right_shift) == GLFW_KEY_RIGHT_SHIFT);
static_assert(static_cast<int>(MouseButton::right) == GLFW_MOUSE_BUTTON_RIGHT);

std::string last_glfw_error() {
    const char* description = nullptr;
    return glfwGetError(&description) == GLFW_NO_ERROR || description == nullptr ? "no reason given" : description;
}

Error no_window(const std::string& what) {
    return Error(fmt::format("{}: {}", what, last_glfw_error()), "the display",
                 "Start it in a graphical session, or render without a display: --headless --out FOLDER");
}

}  // namespace

struct Window::State {
    static State& of(GLFWwindow* window) { return *static_cast<State*>(glfwGetWindowUserPointer(window)); }

    GLFWwindow* window = nullptr;
    Gl gl;
    Input next;  // gathered by the callbacks
    bool cursor_known = false;

    [[nodiscard]] glm::dvec2 to_pixels(double x, double y) const {
        int width = 1, height = 1;
        glm::ivec2 pixels(1);
        glfwGetWindowSize(window, &width, &height);
        glfwGetFramebufferSize(window, &pixels.x, &pixels.y);
        return glm::dvec2(x, y) * glm::dvec2(pixels) / glm::dvec2(glm::max(glm::ivec2(width, height), 1));
    }

    void move_cursor(glm::dvec2 to) {
        if (cursor_known) next.moved += to - next.cursor;
        next.cursor = to;
        cursor_known = true;
    }
};

Window::Window(const std::string& title, glm::ivec2 size) : state_(std::make_unique<State>()) {
    if (glfwInit() == GLFW_FALSE) throw no_window("there is none");
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    state_->window = glfwCreateWindow(size.x, size.y, title.c_str(), nullptr, nullptr);
    if (state_->window == nullptr) {
        const Error error = no_window("no window with OpenGL 3.3");
        glfwTerminate();
        throw error;
    }
    glfwMakeContextCurrent(state_->window);
    try {
        state_->gl = load_gl([](const char* name) { return reinterpret_cast<void*>(glfwGetProcAddress(name)); });
    } catch (...) {
        glfwDestroyWindow(state_->window);
        glfwTerminate();
        throw;
    }
    glfwSwapInterval(1);
    glfwSetWindowUserPointer(state_->window, state_.get());

    glfwSetKeyCallback(state_->window, [](GLFWwindow* window, int key, int, int action, int) {
        Input& next = State::of(window).next;
        if (action == GLFW_PRESS) next.pressed.push_back(Key{key});
        if (action == GLFW_PRESS) next.held.insert(Key{key});
        if (action == GLFW_RELEASE) next.held.erase(Key{key});
    });
    glfwSetMouseButtonCallback(state_->window, [](GLFWwindow* window, int button, int action, int) {
        Input& next = State::of(window).next;
        if (action == GLFW_PRESS) next.clicked.push_back(MouseButton{button});
        if (action == GLFW_PRESS) next.buttons.insert(MouseButton{button});
        if (action == GLFW_RELEASE) next.buttons.erase(MouseButton{button});
    });
    glfwSetCursorPosCallback(state_->window, [](GLFWwindow* window, double x, double y) {
        State& state = State::of(window);
        state.move_cursor(state.to_pixels(x, y));
    });
    glfwSetScrollCallback(state_->window,
                          [](GLFWwindow* window, double, double notches) { State::of(window).next.wheel += notches; });
    glfwSetDropCallback(state_->window, [](GLFWwindow* window, int count, const char** paths) {
        std::vector<std::string>& dropped = State::of(window).next.dropped;
        dropped.insert(dropped.end(), paths, paths + count);
    });
    // A window that loses the focus sees no key go up.
    glfwSetWindowFocusCallback(state_->window, [](GLFWwindow* window, int focused) {
        if (focused == GLFW_TRUE) return;
        State::of(window).next.held.clear();
        State::of(window).next.buttons.clear();
    });
}

Window::~Window() {
    glfwDestroyWindow(state_->window);
    glfwTerminate();
}

const Gl& Window::gl() const noexcept {
    return state_->gl;
}

glm::ivec2 Window::size() const {
    glm::ivec2 size(0);
    glfwGetFramebufferSize(state_->window, &size.x, &size.y);
    return size;
}

bool Window::should_close() const {
    return glfwWindowShouldClose(state_->window) == GLFW_TRUE;
}

void Window::close() {
    glfwSetWindowShouldClose(state_->window, GLFW_TRUE);
}

void Window::set_title(const std::string& title) {
    glfwSetWindowTitle(state_->window, title.c_str());
}

Input Window::poll() {
    const glm::ivec2 visible = size();
    if (visible.x > 0 && visible.y > 0) {
        glfwPollEvents();
    } else {
        glfwWaitEvents();
    }
    Input input = state_->next;
    state_->next.pressed.clear();
    state_->next.clicked.clear();
    state_->next.moved = glm::dvec2(0);
    state_->next.wheel = 0;
    state_->next.dropped.clear();
    return input;
}

void Window::swap() {
    glfwSwapBuffers(state_->window);
}

GLFWwindow* Window::handle() const noexcept {
    return state_->window;
}

}  // namespace lightgrid
