#version 330 core
uniform mat4 clip_from_level;

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 srgb;

out vec3 shown_color;

void main() {
    gl_Position = clip_from_level * vec4(position, 1.0);
    gl_Position.z = mix(-gl_Position.w, gl_Position.z, 0.01);  // seen through walls
    shown_color = srgb;
}
