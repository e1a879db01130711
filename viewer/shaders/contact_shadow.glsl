// What an object, taken for a sphere, hides of the light around it: of one distant light and an even rest.
uniform vec3 shadow_center;
uniform float shadow_scale;     // 1 / the radius
// 2 / the square of how many radii from the centre all of it has faded: of the distant light's, and of the rest.
uniform float shadow_fading;
uniform float sky_fading;
uniform vec3 shadow_direction;  // towards the distant light
uniform float shadow_contrast;  // its irradiance on a surface that faces it over that of the rest

// The light comes from a disc with this tangent of half its angle: shadows are sharp beside the object and gone some of
// its sizes away.
const float light_width = 0.25;
// An object fills its sphere only so far.
const float opacity = 0.85;

// The share of its irradiance that a surface keeps. Divisions are dear where a processor draws.
float kept_light(vec3 at, vec3 normal) {
    vec3 to_object = (shadow_center - at) * shadow_scale;  // in radii from here on
    float squared = max(dot(to_object, to_object), 1e-6);
    float inverse = inversesqrt(squared);

    // An even sky: a sphere above the surface hides cos r^2 / d^2 of its light.
    float hidden = clamp(dot(normal, to_object) * inverse * inverse * inverse, 0.0, 1.0);
    hidden *= clamp(2.0 - squared * sky_fading, 0.0, 1.0);

    // The disc, by where the sphere stands before it and how much larger it is than the sphere.
    float along = dot(to_object, shadow_direction);
    float sharpness = 1.0 / (light_width * max(along, 0.0) + 0.02);
    float beside = sqrt(max(squared - along * along, 0.0));
    float shadow = clamp(0.5 + 0.5 * (1.0 - beside) * sharpness, 0.0, 1.0);
    shadow *= min(1.0, sharpness * sharpness) * clamp(along + 0.5, 0.0, 1.0);
    shadow *= clamp(2.0 - squared * shadow_fading, 0.0, 1.0);

    float contrast = max(dot(normal, shadow_direction), 0.0) * shadow_contrast;
    return 1.0 - opacity * (hidden + contrast * shadow) / (1.0 + contrast);
}
