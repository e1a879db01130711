#version 330 core
// A vertex of the level. Its light, front and back, is two texels of a table with a row for each vertex of each
// instance: irradiance, and its standard error as a share of it.
uniform mat4 clip_from_level;
uniform samplerBuffer instances;  // three texels each: the rows of a 3 x 4 matrix
uniform samplerBuffer light_table;
uniform int first_instance;
uniform int first_light;  // row of vertex 0 of the first instance; may be negative
uniform int light_stride;
uniform bool lit_by_vertex;
uniform vec3 constant_light;

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 base_color_uv;
layout(location = 3) in vec2 emission_uv;
layout(location = 4) in vec2 transmission_uv;
layout(location = 5) in vec4 color;

out vec2 base_color_at;
out vec2 emission_at;
out vec2 transmission_at;
out vec4 vertex_color;
out vec3 at;
out vec3 front;  // normal of that side
out vec4 light_in_front;
out vec4 light_behind;

void main() {
    int row = 3 * (first_instance + gl_InstanceID);
    vec4 x = texelFetch(instances, row);
    vec4 y = texelFetch(instances, row + 1);
    vec4 z = texelFetch(instances, row + 2);
    at = vec3(dot(x, vec4(position, 1.0)), dot(y, vec4(position, 1.0)), dot(z, vec4(position, 1.0)));
    // Normals turn as planes do: by the transposed inverse, here but for a positive factor.
    vec3 yz = cross(y.xyz, z.xyz);
    front = vec3(dot(yz, normal), dot(cross(z.xyz, x.xyz), normal), dot(cross(x.xyz, y.xyz), normal));
    front = normalize(dot(x.xyz, yz) < 0.0 ? -front : front);
    gl_Position = clip_from_level * vec4(at, 1.0);
    base_color_at = base_color_uv;
    emission_at = emission_uv;
    transmission_at = transmission_uv;
    vertex_color = color;
    light_in_front = vec4(constant_light, 0.0);
    light_behind = light_in_front;
    if (lit_by_vertex) {
        int texel = 2 * (first_light + gl_InstanceID * light_stride + gl_VertexID);
        light_in_front = texelFetch(light_table, texel);
        light_behind = texelFetch(light_table, texel + 1);
    }
}
