#version 330 core
#include "sh.glsl"

uniform bool has_environment;
uniform sampler2D environment;  // equirectangular: +X in the centre, +Z to the right of it, +Y above
uniform vec3 radiance[36];
uniform int bands;
uniform float exposure;

in vec3 direction;
out vec4 color;

const float pi = 3.14159265;

void main() {
    vec3 n = normalize(direction);
    vec3 seen;
    if (has_environment) {
        vec2 at = vec2(0.5 + atan(n.z, n.x) / (2.0 * pi), acos(clamp(n.y, -1.0, 1.0)) / pi);
        seen = textureLod(environment, at, 0.0).rgb;
    } else {
        seen = max(evaluate_sh(radiance, bands, n), 0.0);
    }
    color = vec4(min(exposure * seen, 60000.0), 1.0);
}
