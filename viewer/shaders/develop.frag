#version 330 core
// Light to what a display shows: highlights rolled off, then encoded as sRGB (IEC 61966-2-1).
uniform sampler2D light;
uniform int tone;  // as Tone in settings.h

out vec4 color;

// Fit by Narkowicz (2015) to ACES.
vec3 film(vec3 x) {
    return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
}

void main() {
    vec3 x = max(texelFetch(light, ivec2(gl_FragCoord.xy), 0).rgb, 0.0);
    if (tone == 0) x = film(min(x, 1000.0));
    if (tone == 1) x = x / (1.0 + x);
    x = clamp(x, 0.0, 1.0);
    vec3 curved = 1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055;
    color = vec4(mix(curved, 12.92 * x, lessThan(x, vec3(0.0031308))), 1.0);
}
