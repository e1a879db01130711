// Included in a namespace of its own for each LIGHTGRID_BANDS.
using namespace glsl;  // NOLINT: the shader's own names are meant

#define uniform static
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-parameter"  // GLSL has no unnamed parameters
#include "probes/lightgrid.glsl"
#pragma GCC diagnostic pop
#undef uniform

inline Shader program() {
    return {
        [](const lightgrid::VolumeTextures& textures) {
            lightgrid_grids.image = &textures.grids;
            lightgrid_index.image = &textures.index;
            lightgrid_tree.image = &textures.tree;
            lightgrid_atlas.image = &textures.atlas;
        },
        [](const lightgrid::FilteredTextures& textures) {
            for (int t = 0; t < LIGHTGRID_TEXELS; ++t) lightgrid_filtered[t].image = &textures.probes[t];
            lightgrid_filtered_scale = textures.scale;
            lightgrid_filtered_offset = textures.offset;
            lightgrid_filtered_gain = textures.gain;
        },
        [](vec3 position, vec3 normal) { return lightgrid_irradiance(lightgrid_light(position), normal); },
        [](vec3 position, vec3 normal) { return lightgrid_irradiance(lightgrid_filtered_light(position), normal); },
        [](vec3 position, vec3 direction) {
            return lightgrid_evaluate(lightgrid_light(position), direction, vec3(1.0F));
        },
        [](vec3 position) { return lightgrid_light(position).known; },
        [](vec3 position, vec3 normal, float fade_distance) {
            return lightgrid_irradiance(lightgrid_faded(lightgrid_light(position), lightgrid_black(), fade_distance),
                                        normal);
        },
    };
}

#undef LIGHTGRID_BANDS
#undef LIGHTGRID_TEXELS
