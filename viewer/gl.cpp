#include "viewer/gl.h"

#include "core/error.h"

#include <fmt/format.h>

#include <vector>

namespace lightgrid {
namespace {

const char* error_name(GLenum error) {
    switch (error) {
        case GL_INVALID_ENUM:
            return "invalid enum";
        case GL_INVALID_VALUE:
            return "invalid value";
        case GL_INVALID_OPERATION:
            return "invalid operation";
        case GL_INVALID_FRAMEBUFFER_OPERATION:
            return "invalid framebuffer operation";
        case GL_OUT_OF_MEMORY:
            return "out of memory";
        default:
            return "unknown error";
    }
}

}  // namespace

Gl load_gl(const FindGlFunction& find) {
    Gl gl;
    std::vector<std::string> missing;
    const auto load = [&](auto& function, const char* name) {
        function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(find(name));
        if (function == nullptr) missing.emplace_back(name);
    };
#define LIGHTGRID_GL_LOAD(type, name) load(gl.name, "gl" #name);
    LIGHTGRID_GL_FUNCTIONS(LIGHTGRID_GL_LOAD)
#undef LIGHTGRID_GL_LOAD
    if (!missing.empty()) {
        throw Error(fmt::format("has no {}", fmt::join(missing, ", ")), "the OpenGL driver",
                    "OpenGL 3.3 is needed: update the driver, or use Mesa's llvmpipe (LIBGL_ALWAYS_SOFTWARE=1)");
    }
    return gl;
}

void check_gl(const Gl& gl, const std::string& doing) {
    const GLenum error = gl.GetError();
    if (error == GL_NO_ERROR) return;
    throw Error(fmt::format("{} while {}", error_name(error), doing), "OpenGL", {}, Fault::work);
}

bool is_software(const Gl& gl) {
    const std::string device = describe_gl(gl);
    const auto names = [&](const char* name) { return device.find(name) != std::string::npos; };
    return names("llvmpipe") || names("softpipe") || names("SwiftShader");
}

std::string describe_gl(const Gl& gl) {
    const auto text = [&](GLenum name) {
        const GLubyte* value = gl.GetString(name);
        return value == nullptr ? std::string("?") : std::string(reinterpret_cast<const char*>(value));
    };
    return fmt::format("OpenGL {}, {}", text(GL_VERSION), text(GL_RENDERER));
}

}  // namespace lightgrid
