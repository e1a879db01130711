#include "viewer/volume_on_card.h"

#include "core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

namespace lightgrid {
namespace {

struct GlFormat {
    GLint internal;
    GLenum format;
    GLenum type;
};

GlFormat gl_format(TexelFormat format) {
    switch (format) {
        case TexelFormat::rgba32f:
            return {GL_RGBA32F, GL_RGBA, GL_FLOAT};
        case TexelFormat::rgba16f:
            return {GL_RGBA16F, GL_RGBA, GL_HALF_FLOAT};
        case TexelFormat::rgba16ui:
            break;
    }
    return {GL_RGBA16UI, GL_RGBA_INTEGER, GL_UNSIGNED_SHORT};
}

/// target  GL_TEXTURE_2D or GL_TEXTURE_3D
/// filter  GL_NEAREST or GL_LINEAR
GlTexture upload(const Gl& gl, const TextureImage& image, GLenum target, GLint filter) {
    GLint most = 0;
    gl.GetIntegerv(target == GL_TEXTURE_3D ? GL_MAX_3D_TEXTURE_SIZE : GL_MAX_TEXTURE_SIZE, &most);
    const glm::ivec3 size = image.size;
    if (std::max({size.x, size.y, size.z}) > most) {
        throw Error(fmt::format("a texture of {} x {} x {} for the volume, but this OpenGL takes {} along each axis",
                                size.x, size.y, size.z, most),
                    {}, "Bake with a wider --spacing, or light without textures.");
    }
    GlTexture texture = make_texture(gl);
    gl.BindTexture(target, texture.name());
    const GlFormat as = gl_format(image.format);
    if (target == GL_TEXTURE_3D) {
        gl.TexImage3D(target, 0, as.internal, size.x, size.y, size.z, 0, as.format, as.type, image.texels.data());
    } else {
        gl.TexImage2D(target, 0, as.internal, size.x, size.y, 0, as.format, as.type, image.texels.data());
    }
    gl.TexParameteri(target, GL_TEXTURE_MIN_FILTER, filter);
    gl.TexParameteri(target, GL_TEXTURE_MAG_FILTER, filter);
    for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R}) {
        gl.TexParameteri(target, axis, GL_CLAMP_TO_EDGE);
    }
    return texture;
}

void bind(const Gl& gl, const GlTexture& texture, GLenum target, const Uniforms& uniforms, const char* name, int unit) {
    gl.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    gl.BindTexture(target, texture.name());
    uniforms.set(name, unit);
}

}  // namespace

VolumeOnCard upload(const Gl& gl, const VolumeTextures& textures) {
    return {upload(gl, textures.grids, GL_TEXTURE_2D, GL_NEAREST),
            upload(gl, textures.index, GL_TEXTURE_2D, GL_NEAREST), upload(gl, textures.tree, GL_TEXTURE_2D, GL_NEAREST),
            upload(gl, textures.atlas, GL_TEXTURE_3D, GL_NEAREST),
            textures.grids.texels.size() + textures.index.texels.size() + textures.tree.texels.size() +
                textures.atlas.texels.size()};
}

FilteredVolumeOnCard upload(const Gl& gl, const FilteredTextures& textures) {
    FilteredVolumeOnCard result;
    for (const TextureImage& image : textures.probes) {
        result.probes.push_back(upload(gl, image, GL_TEXTURE_3D, GL_LINEAR));
    }
    result.scale = textures.scale;
    result.offset = textures.offset;
    result.gain = textures.gain;
    return result;
}

void bind(const Gl& gl, const VolumeOnCard& volume, const Uniforms& uniforms, int first_unit) {
    bind(gl, volume.grids, GL_TEXTURE_2D, uniforms, "lightgrid_grids", first_unit);
    bind(gl, volume.index, GL_TEXTURE_2D, uniforms, "lightgrid_index", first_unit + 1);
    bind(gl, volume.tree, GL_TEXTURE_2D, uniforms, "lightgrid_tree", first_unit + 2);
    bind(gl, volume.atlas, GL_TEXTURE_3D, uniforms, "lightgrid_atlas", first_unit + 3);
    gl.ActiveTexture(GL_TEXTURE0);
}

void bind(const Gl& gl, const FilteredVolumeOnCard& volume, const Uniforms& uniforms, int first_unit) {
    for (std::size_t t = 0; t < volume.probes.size(); ++t) {
        const std::string name = fmt::format("lightgrid_filtered[{}]", t);
        bind(gl, volume.probes[t], GL_TEXTURE_3D, uniforms, name.c_str(), first_unit + static_cast<int>(t));
    }
    uniforms.set("lightgrid_filtered_scale", volume.scale);
    uniforms.set("lightgrid_filtered_offset", volume.offset);
    uniforms.set("lightgrid_filtered_gain", volume.gain);
    gl.ActiveTexture(GL_TEXTURE0);
}

}  // namespace lightgrid
