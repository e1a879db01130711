#version 330 core
// SELF_SHADOWING  with the light that its vertices get through what the object hides and reflects of itself
uniform mat4 clip_from_level;
uniform mat3 rotation;
uniform float size;
uniform vec3 center;

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 base_color_uv;
layout(location = 3) in vec2 emission_uv;
layout(location = 4) in vec4 color;
#ifdef SELF_SHADOWING
layout(location = 5) in vec3 low_transfer;  // of three coefficients each, in the object's axes
layout(location = 6) in vec3 middle_transfer;
layout(location = 7) in vec3 high_transfer;
uniform vec3 turned_radiance[9];  // likewise

out vec3 own_light;
#endif

out vec3 at;
out vec3 turned_normal;
out vec2 base_color_at;
out vec2 emission_at;
out vec4 vertex_color;

void main() {
    at = center + size * (rotation * position);
    gl_Position = clip_from_level * vec4(at, 1.0);
    turned_normal = rotation * normal;
    base_color_at = base_color_uv;
    emission_at = emission_uv;
    vertex_color = color;
#ifdef SELF_SHADOWING
    own_light = vec3(0.0);
    for (int i = 0; i < 3; ++i) {
        own_light += low_transfer[i] * turned_radiance[i] + middle_transfer[i] * turned_radiance[3 + i] +
                     high_transfer[i] * turned_radiance[6 + i];
    }
#endif
}
