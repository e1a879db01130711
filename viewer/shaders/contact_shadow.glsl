// What an object, taken for a sphere, hides of the light around it: of one distant light and an even rest.
uniform vec3 shadow_center;
uniform float shadow_radius;
uniform vec3 shadow_direction;    // towards the distant light
uniform vec3 shadow_illuminance;  // on a surface that faces it, lux
uniform vec3 shadow_ambient;      // radiance of the rest

// The light comes from a disc with this tangent of half its angle: shadows are sharp beside the object and gone some of
// its sizes away.
const float light_width = 0.25;

// An object fills its sphere only so far.
const float opacity = 0.85;

// The share of its irradiance that a surface keeps.
vec3 kept_light(vec3 at, vec3 normal) {
    vec3 to_object = shadow_center - at;
    float squared = max(dot(to_object, to_object), 1e-12);
    float radius = shadow_radius;

    // An even sky: a sphere above the surface hides cos r^2 / d^2 of its light.
    float hidden = clamp(dot(normal, to_object) * inversesqrt(squared) * radius * radius / squared, 0.0, 1.0);

    // The disc, by where the sphere stands before it and how much larger it is than the sphere.
    float along = dot(to_object, shadow_direction);
    float beside = sqrt(max(squared - along * along, 0.0));
    float width = light_width * max(along, 0.0) + 0.02 * radius;
    float shadow = 1.0 - smoothstep(radius - width, radius + width, beside);
    shadow *= min(1.0, radius * radius / (width * width)) * smoothstep(-radius, 0.5 * radius, along);

    float cosine = max(dot(normal, shadow_direction), 0.0);
    vec3 direct = cosine * shadow_illuminance;
    vec3 share = direct / max(direct + 3.14159265 * shadow_ambient, 1e-20);
    return 1.0 - opacity * mix(vec3(hidden), vec3(shadow), share);
}
