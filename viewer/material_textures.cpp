#include "viewer/material_textures.h"

#include "core/error.h"

#include <fmt/format.h>

namespace lightgrid {
namespace {

GLint wrap_mode(Wrap wrap) {
    switch (wrap) {
        case Wrap::mirror:
            return GL_MIRRORED_REPEAT;
        case Wrap::clamp:
            return GL_CLAMP_TO_EDGE;
        case Wrap::repeat:
            break;
    }
    return GL_REPEAT;
}

GlTexture upload(const Gl& gl, const Texture& texture, Encoding encoding, const std::string& where) {
    GLint most = 0;
    gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
    const ByteImage& image = texture.image;
    if (image.width > most || image.height > most) {
        throw Error(fmt::format("a texture of {} x {} pixels; this OpenGL takes {}", image.width, image.height, most),
                    where, "Make it smaller");
    }
    GlTexture result = make_texture(gl);
    gl.BindTexture(GL_TEXTURE_2D, result.name());
    gl.PixelStorei(GL_UNPACK_ALIGNMENT, 4);
    gl.TexImage2D(GL_TEXTURE_2D, 0, encoding == Encoding::srgb ? GL_SRGB8_ALPHA8 : GL_RGBA8, image.width, image.height,
                  0, GL_RGBA, GL_UNSIGNED_BYTE, image.pixels.data());
    gl.GenerateMipmap(GL_TEXTURE_2D);
    const GLint near = texture.nearest ? GL_NEAREST : GL_LINEAR;
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, near);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, wrap_mode(texture.wrap_u));
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, wrap_mode(texture.wrap_v));
    return result;
}

}  // namespace

MaterialTextures::MaterialTextures(const Gl& gl, std::string where) : gl_(gl), where_(std::move(where)) {
    Texture white;
    white.image = {1, 1, {glm::u8vec4(255)}};
    white_ = upload(gl, white, Encoding::linear, where_);
}

GLuint MaterialTextures::use(const std::vector<Texture>& textures, const TextureUse& use, Encoding encoding) {
    if (!use.used()) return white_.name();
    GlTexture& texture = uploaded_[{use.texture, encoding}];
    if (!texture) {
        texture = upload(gl_, textures[static_cast<std::size_t>(use.texture)], encoding,
                         fmt::format("{}: texture {}", where_, use.texture));
    }
    return texture.name();
}

}  // namespace lightgrid
