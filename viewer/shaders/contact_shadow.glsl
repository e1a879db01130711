// What an object, taken for a sphere, hides of the light around it: of one distant light and an even rest.
uniform vec3 shadow_center;
uniform float shadow_radius;
uniform float shadow_reach;     // radii from the centre to where all of it has faded
uniform vec3 shadow_direction;  // towards the distant light
uniform float shadow_contrast;  // its irradiance on a surface that faces it over that of the rest

// The light comes from a disc with this tangent of half its angle: shadows are sharp beside the object and gone some of
// its sizes away.
const float light_width = 0.25;
// An object fills its sphere only so far.
const float opacity = 0.85;

// The share of its irradiance that a surface keeps.
float kept_light(vec3 at, vec3 normal) {
    vec3 to_object = (shadow_center - at) / shadow_radius;  // in radii from here on
    float squared = max(dot(to_object, to_object), 1e-6);

    // An even sky: a sphere above the surface hides cos r^2 / d^2 of its light.
    float hidden = clamp(dot(normal, to_object) * inversesqrt(squared) / squared, 0.0, 1.0);

    // The disc, by where the sphere stands before it and how much larger it is than the sphere.
    float along = dot(to_object, shadow_direction);
    float width = light_width * max(along, 0.0) + 0.02;
    float beside = sqrt(max(squared - along * along, 0.0));
    float shadow = clamp((1.0 + width - beside) / (2.0 * width), 0.0, 1.0);
    shadow *= min(1.0, 1.0 / (width * width)) * clamp(along + 0.5, 0.0, 1.0);

    float contrast = max(dot(normal, shadow_direction), 0.0) * shadow_contrast;
    float near = clamp(2.0 - 2.0 * squared / (shadow_reach * shadow_reach), 0.0, 1.0);
    return 1.0 - opacity * near * (hidden + contrast * shadow) / (1.0 + contrast);
}
