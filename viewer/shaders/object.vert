#version 330 core
uniform mat4 clip_from_level;
uniform mat3 rotation;
uniform float size;
uniform vec3 center;

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;

out vec3 turned_normal;

void main() {
    gl_Position = clip_from_level * vec4(center + size * (rotation * position), 1.0);
    turned_normal = rotation * normal;
}
