// What an engine does: reads a volume and asks it for light.

#include "probes/sampler.h"
#include "probes/volume_file.h"
#include "probes/volume_textures.h"

#include <cmath>
#include <cstdio>

int main(int, char** arguments) {
    // A sky of radiance 1.
    lightgrid::Volume sky = lightgrid::make_volume({{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}}, 3);
    for (std::size_t i = 0; i < sky.coefficients.size(); i += sky.sh_size()) {
        sky.coefficients[i] = glm::vec3(2 * std::sqrt(std::acos(-1.0)));
    }
    lightgrid::save_volume(sky, arguments[1]);

    const lightgrid::Volume volume = lightgrid::load_volume(arguments[1]);
    const lightgrid::Sampler sampler(volume);
    const glm::vec3 irradiance = sampler.irradiance({0.3, 0.6, 0.9}, {0, 1, 0});
    std::printf("%g lux\n", irradiance.r);
    const lightgrid::VolumeTextures textures = lightgrid::pack_volume(volume, {.half = true});
    if (textures.bands != 3 || textures.atlas.texels.empty()) return 1;
    return std::abs(irradiance.r - std::acos(-1.0)) < 1e-5 ? 0 : 1;
}
