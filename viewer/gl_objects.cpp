#include "viewer/gl_objects.h"

#include <glm/gtc/type_ptr.hpp>

namespace lightgrid {

Buffer make_buffer(const Gl& gl) {
    GLuint name = 0;
    gl.GenBuffers(1, &name);
    return {gl, name};
}

VertexArray make_vertex_array(const Gl& gl) {
    GLuint name = 0;
    gl.GenVertexArrays(1, &name);
    return {gl, name};
}

GlTexture make_texture(const Gl& gl) {
    GLuint name = 0;
    gl.GenTextures(1, &name);
    return {gl, name};
}

Framebuffer make_framebuffer(const Gl& gl) {
    GLuint name = 0;
    gl.GenFramebuffers(1, &name);
    return {gl, name};
}

void Uniforms::set(const char* name, int value) const {
    gl_->Uniform1i(gl_->GetUniformLocation(program_, name), value);
}
void Uniforms::set(const char* name, float value) const {
    gl_->Uniform1f(gl_->GetUniformLocation(program_, name), value);
}
void Uniforms::set(const char* name, glm::vec3 value) const {
    set(name, &value, 1);
}
void Uniforms::set(const char* name, glm::vec4 value) const {
    gl_->Uniform4fv(gl_->GetUniformLocation(program_, name), 1, glm::value_ptr(value));
}
void Uniforms::set(const char* name, const glm::mat3& value) const {
    gl_->UniformMatrix3fv(gl_->GetUniformLocation(program_, name), 1, GL_FALSE, glm::value_ptr(value));
}
void Uniforms::set(const char* name, const glm::mat4& value) const {
    gl_->UniformMatrix4fv(gl_->GetUniformLocation(program_, name), 1, GL_FALSE, glm::value_ptr(value));
}
void Uniforms::set(const char* name, const glm::vec3* values, int count) const {
    gl_->Uniform3fv(gl_->GetUniformLocation(program_, name), count, glm::value_ptr(values[0]));
}

}  // namespace lightgrid
