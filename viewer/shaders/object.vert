#version 330 core
uniform mat4 clip_from_level;
uniform mat3 rotation;
uniform float size;
uniform vec3 center;

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 base_color_uv;
layout(location = 3) in vec2 emission_uv;
layout(location = 4) in vec4 color;

out vec3 turned_normal;
out vec2 base_color_at;
out vec2 emission_at;
out vec4 vertex_color;

void main() {
    gl_Position = clip_from_level * vec4(center + size * (rotation * position), 1.0);
    turned_normal = rotation * normal;
    base_color_at = base_color_uv;
    emission_at = emission_uv;
    vertex_color = color;
}
