#pragma once

#include "viewer/gl_objects.h"

#include <glm/glm.hpp>

#include <span>
#include <string>

namespace lightgrid {

/// A buffer that shaders read texel by texel.
struct TexelBuffer {
    Buffer buffer;
    GlTexture texture;
};

/// Of RGBA floats.
///
/// where  whose they are, for the message
///
/// Throws Error for more than the card takes.
[[nodiscard]] TexelBuffer make_texel_buffer(const Gl& gl, std::span<const glm::vec4> texels, const std::string& where);

}  // namespace lightgrid
