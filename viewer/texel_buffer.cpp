#include "viewer/texel_buffer.h"

#include "core/error.h"

#include <fmt/format.h>

namespace lightgrid {

TexelBuffer make_texel_buffer(const Gl& gl, std::span<const glm::vec4> texels, const std::string& where) {
    GLint most = 0;
    gl.GetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &most);
    if (texels.size() > static_cast<std::size_t>(most)) {
        throw Error(fmt::format("needs a table of {} texels; this OpenGL takes {}", texels.size(), most), where,
                    "Use another driver, such as Mesa's llvmpipe (LIBGL_ALWAYS_SOFTWARE=1)");
    }
    TexelBuffer result{make_buffer(gl), make_texture(gl)};
    gl.BindBuffer(GL_TEXTURE_BUFFER, result.buffer.name());
    gl.BufferData(GL_TEXTURE_BUFFER, static_cast<GLsizeiptr>(texels.size_bytes()), texels.data(), GL_STATIC_DRAW);
    gl.BindTexture(GL_TEXTURE_BUFFER, result.texture.name());
    gl.TexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, result.buffer.name());
    return result;
}

}  // namespace lightgrid
