// Light of a baked volume in shaders: GLSL 3.30, no extension. README.md beside this file says how to upload a volume.
//
//     #define LIGHTGRID_BANDS 3      // of the uploaded textures, 1 to 3; 3 where it is not defined
//     #include "lightgrid.glsl"
//     ...
//     LightgridLight light = lightgrid_light(position + bias * normal);
//     vec3 radiance = albedo / pi * max(lightgrid_irradiance(light, normal), 0.0);
//
// Positions are metres relative to the `origin` of the packed textures, axes those of the level. Irradiance is in lux,
// linear Rec.709. lightgrid_light finds what the C++ Sampler finds (probes/sampler.h says what that is), with its weights
// in float: eight probes by texelFetch, those that are not valid left out; with LIGHTGRID_NEAREST defined, the one of them
// that weighs most, so that one sees what interpolation is worth. lightgrid_filtered_light reads the plain textures that
// hardware filters.

#ifndef LIGHTGRID_BANDS
#define LIGHTGRID_BANDS 3
#endif

#if LIGHTGRID_BANDS == 3
#define LIGHTGRID_TEXELS 7
#elif LIGHTGRID_BANDS == 2
#define LIGHTGRID_TEXELS 4
#else
#define LIGHTGRID_TEXELS 1
#endif

// VolumeTextures: all that lightgrid_light needs.
uniform sampler2D lightgrid_grids;
uniform usampler2D lightgrid_index;
uniform sampler3D lightgrid_atlas;

// FilteredTextures: all that lightgrid_filtered_light needs.
uniform sampler3D lightgrid_filtered[LIGHTGRID_TEXELS];
uniform vec3 lightgrid_filtered_scale;
uniform vec3 lightgrid_filtered_offset;
uniform float lightgrid_filtered_gain;

// SH coefficients of incident radiance, in the order of texels_per_probe.
struct LightgridLight {
    vec4 texels[LIGHTGRID_TEXELS];
    float known;  // share of weight that valid probes carried, before renormalisation; 0: no light is known here
};

// The point of a grid that is nearest to a position.
struct LightgridCell {
    ivec3 lower;             // probe at the lower corner
    vec3 share;              // how far it is from there to the upper one
    float squared_distance;  // from the position; exactly 0 within the grid
    ivec3 last;              // probe of the grid
    ivec2 first;             // brick of the grid in the index
};

LightgridCell lightgrid_cell(int grid, vec3 position) {
    vec4 origin = texelFetch(lightgrid_grids, ivec2(0, grid), 0);
    vec4 inverse_spacing = texelFetch(lightgrid_grids, ivec2(1, grid), 0);
    vec3 last = vec3(texelFetch(lightgrid_grids, ivec2(2, grid), 0)) - 1.0f;

    // What is an integer but for rounding becomes one, so that probes answer for themselves and the far faces belong to
    // the grid.
    vec3 exact = (position - vec3(origin)) * vec3(inverse_spacing);
    vec3 slack = 2.4e-7f * ((abs(position) + abs(vec3(origin))) * vec3(inverse_spacing) + abs(exact));
    vec3 inside = clamp(exact, vec3(0.0f), last);
    vec3 beyond = abs(exact - inside);
    beyond *= vec3(greaterThan(beyond, slack)) / vec3(inverse_spacing);
    vec3 nearest = floor(inside + 0.5f);
    inside = mix(inside, nearest, vec3(lessThanEqual(abs(inside - nearest), slack)));

    LightgridCell cell;
    cell.lower = ivec3(inside);
    cell.share = inside - vec3(cell.lower);
    cell.squared_distance = dot(beyond, beyond);
    cell.last = ivec3(last);
    cell.first = ivec2(int(origin.w), int(inverse_spacing.w));
    return cell;
}

LightgridLight lightgrid_black() {
    LightgridLight black;
    for (int t = 0; t < LIGHTGRID_TEXELS; ++t) black.texels[t] = vec4(0.0f);
    black.known = 0.0f;
    return black;
}

// The sum over a cell's probes of this state, by trilinear weight; `known` is the sum of the weights. Nothing if a probe
// that carries weight is not stored.
LightgridLight lightgrid_sum(LightgridCell cell, float state) {
    LightgridLight sum = lightgrid_black();
    ivec3 bricks = (cell.last >> 2) + 1;
    bool stored = true;
#ifdef LIGHTGRID_NEAREST
    float heaviest = 0.0f;
#endif
    for (int i = 0; i < 8; ++i) {
        ivec3 upper = ivec3(i & 1, (i >> 1) & 1, i >> 2);
        vec3 factors = mix(1.0f - cell.share, cell.share, vec3(upper));
        float weight = factors.x * factors.y * factors.z;
        ivec3 probe = min(cell.lower + upper, cell.last);  // what lies beyond carries no weight
        ivec3 brick = probe >> 2;
        int number = cell.first.x + (brick.z * bricks.y + brick.y) * bricks.x + brick.x;
        uvec4 entry = texelFetch(lightgrid_index, ivec2(number & 2047, cell.first.y + (number >> 11)), 0);
        stored = stored && (entry.w != 0u || weight == 0.0f);
        ivec3 texel = ivec3(entry) * 4 + (probe & 3);
        texel.x *= LIGHTGRID_TEXELS;
        vec4 last = texelFetch(lightgrid_atlas, texel + ivec3(LIGHTGRID_TEXELS - 1, 0, 0), 0);
        weight = last.w == state ? weight : 0.0f;
        sum.known += weight;
#ifdef LIGHTGRID_NEAREST
        if (weight > heaviest) {
            heaviest = weight;
            for (int t = 0; t < LIGHTGRID_TEXELS; ++t) sum.texels[t] = vec4(0.0f);
#else
        if (weight > 0.0f) {
#endif
            weight *= uintBitsToFloat(entry.w << 23);
            sum.texels[LIGHTGRID_TEXELS - 1] += weight * last;
            for (int t = 0; t < LIGHTGRID_TEXELS - 1; ++t) {
                sum.texels[t] += weight * texelFetch(lightgrid_atlas, texel + ivec3(t, 0, 0), 0);
            }
        }
    }
    if (!stored) return lightgrid_black();
#ifdef LIGHTGRID_NEAREST
    if (heaviest > 0.0f) {
        for (int t = 0; t < LIGHTGRID_TEXELS; ++t) sum.texels[t] *= sum.known / heaviest;
    }
#endif
    return sum;
}

// The finest grid that knows an answer gives it; outside of all grids, the nearest point of the nearest one. Where no
// probe around is valid, filled ones answer.
LightgridLight lightgrid_light(vec3 position) {
    int grids = textureSize(lightgrid_grids, 0).y;
    LightgridCell nearest = lightgrid_cell(0, position);
    for (int grid = 1; grid < grids; ++grid) {
        LightgridCell cell = lightgrid_cell(grid, position);
        if (cell.squared_distance < nearest.squared_distance) nearest = cell;
    }
    bool outside = nearest.squared_distance > 0.0f;
    int turns = outside ? 1 : grids;

    LightgridLight light = lightgrid_black();
    for (int turn = 0; turn < 2 * turns && light.known == 0.0f; ++turn) {
        LightgridCell cell = nearest;
        if (turns > 1) cell = lightgrid_cell(turn % turns, position);
        if (outside || cell.squared_distance == 0.0f) light = lightgrid_sum(cell, turn < turns ? 2.0f : 1.0f);
        if (light.known > 0.0f) {
            for (int t = 0; t < LIGHTGRID_TEXELS; ++t) light.texels[t] /= light.known;
            if (turn >= turns) {
                light.known = 0.0f;
                break;
            }
        }
    }
    return light;
}

LightgridLight lightgrid_filtered_light(vec3 position) {
    vec3 at = position * lightgrid_filtered_scale + lightgrid_filtered_offset;
    LightgridLight light;
    light.texels[0] = texture(lightgrid_filtered[0], at);
#if LIGHTGRID_BANDS > 1
    light.texels[1] = texture(lightgrid_filtered[1], at);
    light.texels[2] = texture(lightgrid_filtered[2], at);
    light.texels[3] = texture(lightgrid_filtered[3], at);
#endif
#if LIGHTGRID_BANDS > 2
    light.texels[4] = texture(lightgrid_filtered[4], at);
    light.texels[5] = texture(lightgrid_filtered[5], at);
    light.texels[6] = texture(lightgrid_filtered[6], at);
#endif
    light.known = light.texels[LIGHTGRID_TEXELS - 1].w;
    for (int t = 0; t < LIGHTGRID_TEXELS; ++t) light.texels[t] *= lightgrid_filtered_gain;
    return light;
}

// The sum of all coefficients times their basis functions at a unit direction, each band times a factor: radiance with
// factors of 1, irradiance with those of the cosine lobe, fewer bands with zeros.
vec3 lightgrid_evaluate(LightgridLight light, vec3 direction, vec3 factors) {
#if LIGHTGRID_BANDS == 1
    return 0.28209479f * factors.x * vec3(light.texels[0]);
#else
    float x = direction.x;
    float y = direction.y;
    float z = direction.z;
    vec4 low = vec4(0.28209479f * factors.x, 0.48860251f * factors.y * vec3(y, z, x));
#if LIGHTGRID_BANDS == 2
    return vec3(dot(light.texels[0], low), dot(light.texels[1], low), dot(light.texels[2], low));
#else
    vec4 high = factors.z * vec4(1.0925484f * x * y, 1.0925484f * y * z, 0.31539157f * (3.0f * z * z - 1.0f),
                                 1.0925484f * x * z);
    float last = factors.z * 0.54627422f * (x * x - y * y);
    return vec3(dot(light.texels[0], low) + dot(light.texels[1], high),
                dot(light.texels[2], low) + dot(light.texels[3], high),
                dot(light.texels[4], low) + dot(light.texels[5], high)) +
           last * vec3(light.texels[6]);
#endif
#endif
}

// pi, 2 pi / 3, pi / 4: convolution with the clamped cosine (Ramamoorthi and Hanrahan 2001).
const vec3 lightgrid_cosine_lobe = vec3(3.1415927f, 2.0943951f, 0.78539816f);

// On a surface that faces `normal`. Negative where three bands ring: clamp where it is used.
vec3 lightgrid_irradiance(LightgridLight light, vec3 normal) {
    return lightgrid_evaluate(light, normal, lightgrid_cosine_lobe);
}
