#version 330 core
// A picture that is laid over the developed one as it is.
uniform sampler2D label;   // its first row is the uppermost
uniform vec3 upper_right;  // pixels; z is nothing

out vec4 color;

void main() {
    ivec2 from_corner = ivec2(upper_right.xy - gl_FragCoord.xy);
    color = vec4(texelFetch(label, ivec2(textureSize(label, 0).x - 1 - from_corner.x, from_corner.y), 0).rgb, 1.0);
}
