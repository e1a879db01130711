#version 330 core
#include "sh.glsl"

uniform vec3 irradiance[36];
uniform int bands;
uniform float light_scale;  // exposure / pi
uniform sampler2D base_color_map;
uniform sampler2D emission_map;
uniform vec4 base_color;
uniform vec3 emission;  // times exposure
uniform float alpha_cutoff;  // negative: not MASK

in vec3 turned_normal;
in vec2 base_color_at;
in vec2 emission_at;
in vec4 vertex_color;

out vec4 color;

void main() {
    vec4 base = texture(base_color_map, base_color_at) * base_color * vertex_color;
    if (base.a < alpha_cutoff) discard;
    vec3 normal = normalize(gl_FrontFacing ? turned_normal : -turned_normal);
    vec3 shown = clamp(base.rgb, 0.0, 1.0) * light_scale * max(evaluate_sh(irradiance, bands, normal), 0.0);
    shown += emission * texture(emission_map, emission_at).rgb;
    color = vec4(min(shown, 60000.0), 1.0);
}
