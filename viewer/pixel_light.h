#pragma once

#include "viewer/settings.h"
#include "viewer/volume_on_card.h"

#include <glm/glm.hpp>

namespace lightgrid {

/// Light that shaders look up in the volume at every pixel: what pixel_light.glsl asks for.
struct PixelLight {
    const VolumeOnCard* volume = nullptr;  // of upload_for_pixels
    Filter filter = Filter::trilinear;
    int bands = 3;          // that are used
    float normal_bias = 0;  // metres, of the level's surfaces
};

/// The volume in three bands, whatever its own are, so that one shader serves all; those that it lacks are zero.
///
/// origin  that positions in shaders are relative to
/// half    kept as half on the card, too
///
/// Throws Error for what the card cannot hold.
[[nodiscard]] VolumeOnCard upload_for_pixels(const Gl& gl, const Volume& volume, glm::dvec3 origin, bool half);

/// Factors of the bands for irradiance: of the cosine lobe, and zero for those that are not used.
[[nodiscard]] glm::vec3 irradiance_factors(int bands);

/// Binds the volume to the four units from `first_unit` on and tells the program in use all that it asks.
void set_pixel_light(const Gl& gl, const Uniforms& uniforms, const PixelLight& light, int first_unit);

}  // namespace lightgrid
