// Light of the volume at every pixel.
#ifdef NEAREST
#define LIGHTGRID_NEAREST
#endif
#define LIGHTGRID_BANDS 3
#include "lightgrid.glsl"

uniform vec3 band_factors;  // of the cosine lobe; 0 for a band that is not used
uniform float normal_bias;  // metres that a surface of the level looks light up away from itself

// Lux, not negative.
vec3 pixel_irradiance(vec3 position, vec3 normal) {
    return max(lightgrid_evaluate(lightgrid_light(position), normal, band_factors), 0.0);
}
