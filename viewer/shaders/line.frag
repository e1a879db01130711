#version 330 core
#include "display.glsl"

in vec3 shown_color;
out vec4 color;

void main() {
    color = vec4(light_shown_as(shown_color), 1.0);
}
