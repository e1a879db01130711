#version 330 core
#include "sh.glsl"

uniform vec3 irradiance[9];
uniform vec3 light_scale;  // exposure x albedo / pi

in vec3 turned_normal;
out vec4 color;

void main() {
    vec3 shown = light_scale * max(evaluate_sh(irradiance, normalize(turned_normal)), 0.0);
    color = vec4(min(shown, 60000.0), 1.0);
}
