// Colours that are to appear as they are, in spite of the tone map that follows (develop.frag).
uniform int tone;  // as Tone in settings.h

// The light that is shown as this sRGB colour.
vec3 light_shown_as(vec3 srgb) {
    vec3 curved = pow((srgb + 0.055) / 1.055, vec3(2.4));
    vec3 y = min(mix(curved, srgb / 12.92, lessThan(srgb, vec3(0.04045))), 0.99);
    if (tone == 0) {
        vec3 a = 2.51 - 2.43 * y;
        vec3 b = 0.03 - 0.59 * y;
        return (sqrt(b * b + 0.56 * a * y) - b) / (2.0 * a);
    }
    return tone == 1 ? y / (1.0 - y) : y;
}
