#pragma once

#include "probes/volume.h"

#include <glm/glm.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

/// A volume as textures for lightgrid.glsl: plain arrays, ready for glTexImage2D and glTexImage3D, and no word of any
/// graphics interface. README.md beside this file shows how to upload them.
namespace lightgrid {

/// Internal format, format and type for glTexImage:
///   rgba32f   GL_RGBA32F   GL_RGBA          GL_FLOAT
///   rgba16f   GL_RGBA16F   GL_RGBA          GL_HALF_FLOAT
///   rgba16ui  GL_RGBA16UI  GL_RGBA_INTEGER  GL_UNSIGNED_SHORT
enum class TexelFormat : std::uint8_t { rgba32f, rgba16f, rgba16ui };
[[nodiscard]] constexpr std::size_t texel_bytes(TexelFormat format) {
    return format == TexelFormat::rgba32f ? 16 : 8;
}

/// x fastest, then y, then z, without gaps. size.z is 1 for what is a 2D texture.
struct TextureImage {
    TexelFormat format = TexelFormat::rgba32f;
    glm::ivec3 size{0};
    std::vector<std::byte> texels;
};

struct TextureOptions {
    int bands = 3;                       // at most; those of the volume above it are left out. 1 .. max_texture_bands
    bool half = false;                   // rgba16f: half of the bytes, each number to 2^-11 of itself (half_storage.h)
    std::optional<glm::dvec3> origin{};  // what positions in shaders are relative to; none: the middle of the grids
};

inline constexpr int max_texture_bands = 3;
/// No texture is larger along any axis, but for the index of a volume that spans more than 2048^2 bricks, the tree of one
/// whose cells that know light make more than 2^20 boxes, and filtered textures of a grid that has more probes along an
/// axis.
inline constexpr int max_texture_size = 2048;

/// RGBA texels that a probe's coefficients and state take. With 3 bands: red 0..3, red 4..7, green 0..3, green 4..7,
/// blue 0..3, blue 4..7, then (red 8, green 8, blue 8, state). With 2: red, green, blue 0..3, (0, 0, 0, state). With 1:
/// (red, green, blue, state). state: 2 valid or moved, 1 filled, 0 no light is known.
[[nodiscard]] constexpr int texels_per_probe(int bands) {
    return bands == 1 ? 1 : bands == 2 ? 4 : 7;
}

/// The exact form, for any number of grids, sparse or not: what lightgrid_light in lightgrid.glsl reads.
///
/// grids  2D, rgba32f, one row per grid, finest first:
///          (origin - VolumeTextures::origin, x of the first brick in `index`), (1 / spacing, its y), (counts, 0)
/// index  2D, rgba16ui, one texel per brick of the lattices, grid by grid, x fastest, then y, then z, in rows of 2048:
///          (place in the atlas, in bricks; 127 + exponent of the power of two that its numbers are multiplied by),
///          or zeros where the brick is not stored
/// tree   2D, rgba32f, in rows of 2048: two texels for each node of KnownCells, the root first:
///          (low - VolumeTextures::origin, number of the first of two children, or -1 - row of a leaf's grid in `grids`),
///          (high - VolumeTextures::origin, 0); a single node of zeros where no cell knows light
/// atlas  3D, rgba32f or rgba16f: bricks of 4 texels_per_probe x 4 x 4 texels, a probe's texels side by side along x
struct VolumeTextures {
    int bands = 0;         // LIGHTGRID_BANDS of the shader
    glm::dvec3 origin{0};  // of positions given to the shader
    TextureImage grids;
    TextureImage index;
    TextureImage tree;
    TextureImage atlas;
};

/// Throws Error for a probe list, which has no cells, and for more bricks than an atlas of max_texture_size holds.
[[nodiscard]] VolumeTextures pack_volume(const Volume& volume, const TextureOptions& options = {});

/// The plain form: one texel per probe in texels_per_probe textures that hardware filters; what lightgrid_filtered in
/// lightgrid.glsl reads. Filled probes count as light, so what is behind walls leaks more than in the exact form, and
/// hardware may round the eight weights to 8 bits.
struct FilteredTextures {
    int bands = 0;
    glm::dvec3 origin{0};
    std::vector<TextureImage> probes;  // 3D, rgba32f or rgba16f, `state` halved: 1 valid, 0.5 filled, 0 unknown
    glm::vec3 scale{1};                // texture coordinate = position * scale + offset
    glm::vec3 offset{0};
    float gain = 1;  // that the textures' light is multiplied by
};

/// One grid with all its bricks stored.
[[nodiscard]] bool is_dense(const Volume& volume);
/// Throws Error where the volume is not is_dense.
[[nodiscard]] FilteredTextures pack_filtered(const Volume& volume, const TextureOptions& options = {});

}  // namespace lightgrid
