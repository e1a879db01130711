#pragma once

#include "probes/volume_textures.h"
#include "viewer/gl_objects.h"

#include <glm/glm.hpp>

#include <cstddef>
#include <vector>

/// A volume's textures on the card, for shaders that include lightgrid.glsl.
namespace lightgrid {

struct VolumeOnCard {
    GlTexture grids;
    GlTexture index;
    GlTexture tree;
    GlTexture atlas;
    std::size_t bytes = 0;  // of texels
};
/// Throws Error for textures that are larger than the card takes.
[[nodiscard]] VolumeOnCard upload(const Gl& gl, const VolumeTextures& textures);

struct FilteredVolumeOnCard {
    std::vector<GlTexture> probes;
    glm::vec3 scale{1};
    glm::vec3 offset{0};
    float gain = 1;
};
/// Likewise.
[[nodiscard]] FilteredVolumeOnCard upload(const Gl& gl, const FilteredTextures& textures);

/// Binds the textures to units and tells the program in use. One of the two forms takes 4 units, the other at most 7. A
/// shader that reads both needs units of its own for each; one that reads neither ignores all of it.
void bind(const Gl& gl, const VolumeOnCard& volume, const Uniforms& uniforms, int first_unit);
void bind(const Gl& gl, const FilteredVolumeOnCard& volume, const Uniforms& uniforms, int first_unit);

}  // namespace lightgrid
