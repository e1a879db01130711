#include "viewer/headless.h"

#include "core/error.h"

#include <GL/osmesa.h>

#include <array>

namespace lightgrid {

struct Headless::Context {
    OSMesaContext context = nullptr;
    std::array<unsigned char, 4> surface{};
    Gl gl;

    Context() {
        // clang-format off
        constexpr std::array attributes{OSMESA_FORMAT, OSMESA_RGBA,
                                        OSMESA_DEPTH_BITS, 0,
                                        OSMESA_PROFILE, OSMESA_CORE_PROFILE,
                                        OSMESA_CONTEXT_MAJOR_VERSION, 3,
                                        OSMESA_CONTEXT_MINOR_VERSION, 3,
                                        0};
        // clang-format on
        context = OSMesaCreateContextAttribs(attributes.data(), nullptr);
        if (context == nullptr) {
            throw Error("cannot make a context of OpenGL 3.3", "OSMesa", "Install Mesa 11.2 or newer", Fault::work);
        }
        if (OSMesaMakeCurrent(context, surface.data(), GL_UNSIGNED_BYTE, 1, 1) == GL_FALSE) {
            OSMesaDestroyContext(context);
            throw Error("cannot make its context current", "OSMesa", {}, Fault::work);
        }
        try {
            gl = load_gl([](const char* name) { return reinterpret_cast<void*>(OSMesaGetProcAddress(name)); });
        } catch (...) {
            OSMesaDestroyContext(context);
            throw;
        }
    }
    ~Context() { OSMesaDestroyContext(context); }
    Context(const Context&) = delete;
    Context& operator=(const Context&) = delete;
};

Headless::Headless() : context_(std::make_unique<Context>()) {}
Headless::~Headless() = default;

const Gl& Headless::gl() const noexcept {
    return context_->gl;
}

}  // namespace lightgrid
