#include "viewer/pixel_light.h"

#include "core/sh.h"

#include <algorithm>
#include <vector>

namespace lightgrid {

VolumeOnCard upload_for_pixels(const Gl& gl, const Volume& volume, glm::dvec3 origin, bool half) {
    const TextureOptions options{.half = half, .origin = origin};
    if (volume.bands >= max_texture_bands) return upload(gl, pack_volume(volume, options));
    Volume widened = volume;
    widened.bands = max_texture_bands;
    widened.coefficients.assign(widened.slots() * widened.sh_size(), glm::vec3(0));
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        std::ranges::copy(volume.sh(slot),
                          widened.coefficients.begin() + static_cast<std::ptrdiff_t>(slot * widened.sh_size()));
    }
    return upload(gl, pack_volume(widened, options));
}

glm::vec3 irradiance_factors(int bands) {
    glm::vec3 factors(0);
    for (int band = 0; band < std::min(bands, 3); ++band) factors[band] = static_cast<float>(cosine_lobe(band));
    return factors;
}

void set_pixel_light(const Gl& gl, const Uniforms& uniforms, const PixelLight& light, int first_unit) {
    bind(gl, *light.volume, uniforms, first_unit);
    uniforms.set("band_factors", irradiance_factors(light.bands));
    uniforms.set("normal_bias", light.normal_bias);
}

}  // namespace lightgrid
