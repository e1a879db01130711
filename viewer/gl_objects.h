#pragma once

#include "viewer/gl.h"

#include <glm/glm.hpp>

#include <utility>

/// OpenGL's objects as values that own what they name: move-only, deleted with their owner. The context they were made
/// in must be current when they die.
namespace lightgrid {

/// The name of an object and how to delete it.
template <typename Deleter>
class GlObject {
  public:
    GlObject() = default;
    GlObject(const Gl& gl, GLuint name) : gl_(&gl), name_(name) {}
    ~GlObject() { reset(); }
    GlObject(GlObject&& other) noexcept : gl_(other.gl_), name_(std::exchange(other.name_, 0)) {}
    GlObject& operator=(GlObject&& other) noexcept {
        if (this != &other) {
            reset();
            gl_ = other.gl_;
            name_ = std::exchange(other.name_, 0);
        }
        return *this;
    }
    GlObject(const GlObject&) = delete;
    GlObject& operator=(const GlObject&) = delete;

    [[nodiscard]] GLuint name() const noexcept { return name_; }
    [[nodiscard]] explicit operator bool() const noexcept { return name_ != 0; }

  private:
    void reset() noexcept {
        if (name_ != 0) Deleter()(*gl_, name_);
        name_ = 0;
    }

    const Gl* gl_ = nullptr;
    GLuint name_ = 0;
};

struct DeleteBuffer {
    void operator()(const Gl& gl, GLuint name) const { gl.DeleteBuffers(1, &name); }
};
struct DeleteVertexArray {
    void operator()(const Gl& gl, GLuint name) const { gl.DeleteVertexArrays(1, &name); }
};
struct DeleteTexture {
    void operator()(const Gl& gl, GLuint name) const { gl.DeleteTextures(1, &name); }
};
struct DeleteFramebuffer {
    void operator()(const Gl& gl, GLuint name) const { gl.DeleteFramebuffers(1, &name); }
};
struct DeleteShader {
    void operator()(const Gl& gl, GLuint name) const { gl.DeleteShader(name); }
};
struct DeleteProgram {
    void operator()(const Gl& gl, GLuint name) const { gl.DeleteProgram(name); }
};

using Buffer = GlObject<DeleteBuffer>;
using VertexArray = GlObject<DeleteVertexArray>;
using GlTexture = GlObject<DeleteTexture>;
using Framebuffer = GlObject<DeleteFramebuffer>;
using Shader = GlObject<DeleteShader>;
using Program = GlObject<DeleteProgram>;

[[nodiscard]] Buffer make_buffer(const Gl& gl);
[[nodiscard]] VertexArray make_vertex_array(const Gl& gl);
[[nodiscard]] GlTexture make_texture(const Gl& gl);
[[nodiscard]] Framebuffer make_framebuffer(const Gl& gl);

/// Sets uniforms of the program in use by name; a name that the compiler found unused, or that is not there, is
/// ignored, as OpenGL does.
class Uniforms {
  public:
    Uniforms(const Gl& gl, const Program& program) : gl_(&gl), program_(program.name()) {}

    void set(const char* name, int value) const;
    void set(const char* name, float value) const;
    void set(const char* name, glm::vec3 value) const;
    void set(const char* name, glm::vec4 value) const;
    void set(const char* name, const glm::mat3& value) const;
    void set(const char* name, const glm::mat4& value) const;
    /// An array of `count` vectors.
    void set(const char* name, const glm::vec3* values, int count) const;

  private:
    const Gl* gl_;
    GLuint program_;
};

}  // namespace lightgrid
