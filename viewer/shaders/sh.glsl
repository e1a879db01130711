// A function on the sphere from its 9 SH coefficients (core/sh.h).
vec3 evaluate_sh(vec3 c[9], vec3 n) {
    return 0.282095 * c[0] + 0.488603 * (n.y * c[1] + n.z * c[2] + n.x * c[3]) +
           1.092548 * (n.x * n.y * c[4] + n.y * n.z * c[5] + n.x * n.z * c[7]) +
           0.315392 * (3.0 * n.z * n.z - 1.0) * c[6] + 0.546274 * (n.x * n.x - n.y * n.y) * c[8];
}
