#version 330 core
// A sphere as a square that faces the eye, for ball.frag to cut it out.
uniform mat4 clip_from_level;
uniform mat3 ray;             // columns: right, up, forward, of any length
uniform samplerBuffer balls;  // nine texels each: (centre, radius), (rim, 0), 9 RGB coefficients
uniform bool before_all;      // seen through walls

flat out vec3 rim;
flat out vec3 radiance[9];
out vec2 from_center;  // in radii

void main() {
    int texel = 9 * gl_InstanceID;
    vec4 sphere = texelFetch(balls, texel);
    rim = texelFetch(balls, texel + 1).rgb;
    float numbers[28];
    for (int i = 0; i < 7; ++i) {
        vec4 four = texelFetch(balls, texel + 2 + i);
        for (int k = 0; k < 4; ++k) numbers[4 * i + k] = four[k];
    }
    for (int i = 0; i < 9; ++i) radiance[i] = vec3(numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]);
    from_center = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
    vec2 offset = sphere.w * from_center;
    gl_Position = clip_from_level *
                  vec4(sphere.xyz + offset.x * normalize(ray[0]) + offset.y * normalize(ray[1]), 1.0);
    if (before_all) gl_Position.z = mix(-gl_Position.w, gl_Position.z, 0.01);
}
