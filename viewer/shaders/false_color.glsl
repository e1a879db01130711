#include "display.glsl"

uniform vec3 ramp[8];   // sRGB
uniform float lowest;   // of the scale, logarithms
uniform float highest;
uniform bool of_error;

const vec3 luminance_weights = vec3(0.2126, 0.7152, 0.0722);

const vec3 not_known = vec3(0.35);  // sRGB

// light  lux, and a share of it: standard error, or difference; negative: not known
vec3 false_color(vec4 light) {
    if (of_error && light.a < 0.0) return light_shown_as(not_known);
    float value = of_error ? light.a : dot(light.rgb, luminance_weights);
    float place = 7.0 * clamp((log(max(value, 1e-30)) - lowest) / (highest - lowest), 0.0, 1.0);
    int below = min(int(place), 6);
    return light_shown_as(mix(ramp[below], ramp[below + 1], place - float(below)));
}
