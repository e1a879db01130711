// A surface of the level: Lambertian on both sides, emitting on its front, as core/scene.h says.
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

in vec2 base_color_at;
in vec2 emission_at;
in vec2 transmission_at;
in vec4 vertex_color;
in vec3 light_in_front;
in vec3 light_behind;

out vec4 color;
#ifdef SEE_THROUGH
out vec4 passes;  // what is behind is multiplied by it
#endif

void main() {
    vec4 base = texture(base_color_map, base_color_at) * base_color * vertex_color;
    vec3 albedo = clamp(base.rgb, 0.0, 1.0);
    vec3 shown = albedo * (gl_FrontFacing ? light_in_front : light_behind);
    vec3 emitted = vec3(0.0);
    if (emits && (gl_FrontFacing || double_sided)) emitted = emission * texture(emission_map, emission_at).rgb;
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
