#version 330 core
// A surface of the level: Lambertian on both sides, emitting on its front, as core/scene.h says.
//
// SEE_THROUGH    MASK, BLEND or transmission
// PIXEL_LIGHT    lit by look-ups at every pixel; else by the light at its vertices
// SHADOW         with the contact shadow of the object
// FALSE_COLORS   irradiance or its standard error in false colours
#if defined(PIXEL_LIGHT)
#include "pixel_light.glsl"
#endif
#if defined(SHADOW)
#include "contact_shadow.glsl"
#endif
#if defined(FALSE_COLORS)
#include "false_color.glsl"
#endif
uniform sampler2D base_color_map;
uniform sampler2D emission_map;
uniform sampler2D transmission_map;
uniform vec4 base_color;
uniform vec3 emission;  // times exposure
uniform bool emits;
uniform bool double_sided;
uniform float alpha_cutoff;  // negative: not MASK
uniform bool blend;
uniform float transmission;
uniform float light_scale;  // exposure x gain / pi: from irradiance to what a white surface shows

in vec2 base_color_at;
in vec2 emission_at;
in vec2 transmission_at;
in vec4 vertex_color;
in vec3 at;
in vec3 front;
in vec4 light_in_front;  // lux; and its standard error, as a share of it
in vec4 light_behind;

out vec4 color;
#ifdef SEE_THROUGH
out vec4 passes;  // what is behind is multiplied by it
#endif

void main() {
    vec4 base = texture(base_color_map, base_color_at) * base_color * vertex_color;
    vec3 albedo = clamp(base.rgb, 0.0, 1.0);
    vec4 light = gl_FrontFacing ? light_in_front : light_behind;
    vec3 normal = normalize(gl_FrontFacing ? front : -front);
#ifdef PIXEL_LIGHT
    light.rgb = pixel_irradiance(at + normal_bias * normal, normal);
#endif
#ifdef SHADOW
    light.rgb *= kept_light(at, normal);
#endif
    vec3 shown = albedo * light_scale * light.rgb;
    vec3 emitted = vec3(0.0);
    if (emits && (gl_FrontFacing || double_sided)) emitted = emission * texture(emission_map, emission_at).rgb;
#ifdef FALSE_COLORS
    shown = false_color(light);
    emitted = vec3(0.0);
#endif
#ifdef SEE_THROUGH
    if (base.a < alpha_cutoff) discard;
    float alpha = blend ? clamp(base.a, 0.0, 1.0) : 1.0;
    float through = transmission * texture(transmission_map, transmission_at).r;
    shown = alpha * ((1.0 - through) * shown + emitted);
    passes = vec4(vec3(1.0 - alpha) + alpha * through * albedo, 0.0);
#else
    shown += emitted;
#endif
    color = vec4(min(shown, 60000.0), 1.0);
}
