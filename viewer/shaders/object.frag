#version 330 core
// PIXEL_LIGHT     lit by look-ups at every pixel; else by one for all of it
// SELF_SHADOWING  with what the object hides and reflects of itself
#include "sh.glsl"
#ifdef PIXEL_LIGHT
#include "pixel_light.glsl"
#endif

uniform vec3 irradiance[36];
uniform int bands;
uniform float light_scale;  // exposure x gain / pi
uniform sampler2D base_color_map;
uniform sampler2D emission_map;
uniform vec4 base_color;
uniform vec3 emission;  // times exposure
uniform float alpha_cutoff;  // negative: not MASK

in vec3 at;
in vec3 turned_normal;
in vec2 base_color_at;
in vec2 emission_at;
in vec4 vertex_color;
#ifdef SELF_SHADOWING
in vec3 own_light;
#endif

out vec4 color;

vec3 light(vec3 normal) {
    vec3 whole = max(evaluate_sh(irradiance, bands, normal), 0.0);
#ifdef PIXEL_LIGHT
    vec3 here = pixel_irradiance(at, normal);
#else
    vec3 here = whole;
#endif
#ifdef SELF_SHADOWING
    if (!gl_FrontFacing) return here;  // transfer is of the front
#ifdef PIXEL_LIGHT
    // The same share of it as of the light of the whole, which is not quite black anywhere.
    vec3 base = max(whole, 0.01 * irradiance[0]);
    here *= clamp(own_light / max(base, 1e-20), 0.0, 2.0);
#else
    here = own_light;
    if (bands > 3) here += evaluate_higher_sh(irradiance, normal);  // transfer is of three bands
    here = max(here, 0.0);
#endif
#endif
    return here;
}

void main() {
    vec4 base = texture(base_color_map, base_color_at) * base_color * vertex_color;
    if (base.a < alpha_cutoff) discard;
    vec3 normal = normalize(gl_FrontFacing ? turned_normal : -turned_normal);
    vec3 shown = clamp(base.rgb, 0.0, 1.0) * light_scale * light(normal);
    shown += emission * texture(emission_map, emission_at).rgb;
    color = vec4(min(shown, 60000.0), 1.0);
}
