#version 330 core
// A white sphere under its own light, with a coloured rim.
#include "display.glsl"
#include "sh.glsl"

uniform mat3 ray;
uniform vec3 band_factors;  // of the cosine lobe; 0 for a band that is not used
uniform float light_scale;  // albedo x exposure x gain / pi
uniform float rim_from;     // radii; beyond 1 there is none

flat in vec3 rim;
flat in vec3 radiance[9];
in vec2 from_center;

out vec4 color;

void main() {
    float radius = length(from_center);
    float pixel = fwidth(radius);
    if (radius > 1.0) discard;
    float bulge = sqrt(1.0 - radius * radius);
    vec3 normal = mat3(normalize(ray[0]), normalize(ray[1]), -normalize(ray[2])) * vec3(from_center, bulge);
    vec3 irradiance[9];
    for (int i = 0; i < 9; ++i) irradiance[i] = band_factors[i == 0 ? 0 : i < 4 ? 1 : 2] * radiance[i];
    vec3 lit = light_scale * max(evaluate_sh(irradiance, normal), 0.0);
    float in_rim = smoothstep(rim_from - pixel, rim_from + pixel, radius);
    color = vec4(min(mix(lit, light_shown_as(rim), in_rim), 60000.0), 1.0);
}
