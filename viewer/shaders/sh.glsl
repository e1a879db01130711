// Functions on the sphere from their SH coefficients (core/sh.h).
vec3 evaluate_sh(vec3 c[9], vec3 n) {
    return 0.282095 * c[0] + 0.488603 * (n.y * c[1] + n.z * c[2] + n.x * c[3]) +
           1.092548 * (n.x * n.y * c[4] + n.y * n.z * c[5] + n.x * n.z * c[7]) +
           0.315392 * (3.0 * n.z * n.z - 1.0) * c[6] + 0.546274 * (n.x * n.x - n.y * n.y) * c[8];
}

// What bands 4 to 6 add.
vec3 evaluate_higher_sh(vec3 c[36], vec3 n) {
    float x = n.x, y = n.y, z = n.z;
    float xx = x * x, yy = y * y, zz = z * z, xy = x * y;
    float cos2 = xx - yy, sin3 = y * (3.0 * xx - yy), cos3 = x * (xx - 3.0 * yy);  // of m azimuths, times sin^m
    vec3 sum = 0.590044 * (sin3 * c[9] + cos3 * c[15]) + z * (2.890611 * xy * c[10] + 1.445306 * cos2 * c[14]) +
           0.457046 * (5.0 * zz - 1.0) * (y * c[11] + x * c[13]) + 0.373176 * z * (5.0 * zz - 3.0) * c[12];
    float sin4 = xy * cos2, cos4 = xx * xx - 6.0 * xx * yy + yy * yy;
    sum += 2.503343 * sin4 * c[16] + 0.625836 * cos4 * c[24] + 1.770131 * z * (sin3 * c[17] + cos3 * c[23]) +
           (7.0 * zz - 1.0) * (0.946175 * xy * c[18] + 0.473087 * cos2 * c[22]) +
           0.669047 * z * (7.0 * zz - 3.0) * (y * c[19] + x * c[21]) +
           0.105786 * (35.0 * zz * zz - 30.0 * zz + 3.0) * c[20];
    float sin5 = y * (5.0 * xx * xx - 10.0 * xx * yy + yy * yy), cos5 = x * (xx * xx - 10.0 * xx * yy + 5.0 * yy * yy);
    sum += 0.656382 * (sin5 * c[25] + cos5 * c[35]) + z * (8.302649 * sin4 * c[26] + 2.075662 * cos4 * c[34]) +
           0.489238 * (9.0 * zz - 1.0) * (sin3 * c[27] + cos3 * c[33]) +
           z * (3.0 * zz - 1.0) * (4.793537 * xy * c[28] + 2.396768 * cos2 * c[32]) +
           0.452947 * (21.0 * zz * zz - 14.0 * zz + 1.0) * (y * c[29] + x * c[31]) +
           0.116950 * z * (63.0 * zz * zz - 70.0 * zz + 15.0) * c[30];
    return sum;
}

// Of up to six bands; only the first three are read where there are no more.
vec3 evaluate_sh(vec3 c[36], int bands, vec3 n) {
    vec3 sum = evaluate_sh(vec3[9](c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7], c[8]), n);
    return bands > 3 ? sum + evaluate_higher_sh(c, n) : sum;
}
