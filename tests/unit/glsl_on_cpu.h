#pragma once

#include "probes/volume_textures.h"

#include <glm/glm.hpp>

#include <bit>
#include <cstdint>
#include <cstring>
#include <span>

/// What lightgrid.glsl asks of a graphics interface, so that a C++ compiler takes the file as it is and tests run it
/// without one. Everything else in it GLM has under the same names.
namespace glsl {

using namespace glm;
using lightgrid::TexelFormat;
using lightgrid::TextureImage;

inline float half_to_float(std::uint16_t bits) {
    const float magnitude = std::bit_cast<float>((bits & 0x7fffU) << 13U) * 0x1p112F;  // subnormals too
    return (bits & 0x8000U) != 0 ? -magnitude : magnitude;
}

template <typename T>
T stored(const TextureImage& image, std::size_t component) {
    T value;
    std::memcpy(&value, image.texels.data() + component * sizeof(T), sizeof(T));
    return value;
}

inline std::size_t first_component(const TextureImage& image, ivec3 at) {
    // As GL_KHR_robustness has it, reading beyond a texture is an error; here it ends the test.
    if (any(lessThan(at, ivec3(0))) || any(greaterThanEqual(at, image.size))) std::abort();
    return 4 * ((static_cast<std::size_t>(at.z) * image.size.y + at.y) * image.size.x + at.x);
}

inline vec4 color_at(const TextureImage& image, ivec3 at) {
    const std::size_t first = first_component(image, at);
    vec4 color;
    for (int c = 0; c < 4; ++c) {
        color[c] = image.format == TexelFormat::rgba32f ? stored<float>(image, first + c)
                                                        : half_to_float(stored<std::uint16_t>(image, first + c));
    }
    return color;
}

struct sampler2D {  // NOLINT: GLSL's name
    const TextureImage* image = nullptr;
};
struct usampler2D {  // NOLINT: GLSL's name
    const TextureImage* image = nullptr;
};
struct sampler3D {  // NOLINT: GLSL's name
    const TextureImage* image = nullptr;
};

inline vec4 texelFetch(sampler2D sampler, ivec2 at, int) {  // NOLINT: GLSL's name
    return color_at(*sampler.image, ivec3(at, 0));
}
inline vec4 texelFetch(sampler3D sampler, ivec3 at, int) {  // NOLINT: GLSL's name
    return color_at(*sampler.image, at);
}
inline uvec4 texelFetch(usampler2D sampler, ivec2 at, int) {  // NOLINT: GLSL's name
    const std::size_t first = first_component(*sampler.image, ivec3(at, 0));
    uvec4 value;
    for (int c = 0; c < 4; ++c) value[c] = stored<std::uint16_t>(*sampler.image, first + c);
    return value;
}
inline ivec2 textureSize(sampler2D sampler, int) {  // NOLINT: GLSL's name
    return ivec2(sampler.image->size);
}

/// GL_LINEAR and GL_CLAMP_TO_EDGE, with weights as exact as float has them.
inline vec4 texture(sampler3D sampler, vec3 at) {
    const TextureImage& image = *sampler.image;
    const vec3 place = at * vec3(image.size) - 0.5F;
    const ivec3 lower(floor(place));
    const vec3 share = place - vec3(lower);
    vec4 sum(0);
    for (int i = 0; i < 8; ++i) {
        const ivec3 upper(i & 1, (i >> 1) & 1, i >> 2);
        const vec3 weights = mix(1.0F - share, share, vec3(upper));
        sum += weights.x * weights.y * weights.z * color_at(image, clamp(lower + upper, ivec3(0), image.size - 1));
    }
    return sum;
}

/// A compiled lightgrid.glsl.
struct Shader {
    void (*bind)(const lightgrid::VolumeTextures&);
    void (*bind_filtered)(const lightgrid::FilteredTextures&);
    vec3 (*irradiance)(vec3 position, vec3 normal);
    vec3 (*filtered_irradiance)(vec3 position, vec3 normal);
    vec3 (*radiance)(vec3 position, vec3 direction);
    float (*known)(vec3 position);
    vec3 (*faded_irradiance)(vec3 position, vec3 normal, float fade_distance);  // to black
};

}  // namespace glsl
