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
// that weighs most, so that one sees what interpolation is worth. Where no light is known, that of the nearest point which
// knows one; lightgrid_faded fades it to another light. lightgrid_filtered_light reads the plain textures that hardware
// filters.

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
uniform sampler2D lightgrid_tree;
uniform sampler3D lightgrid_atlas;

// FilteredTextures: all that lightgrid_filtered_light needs.
uniform sampler3D lightgrid_filtered[LIGHTGRID_TEXELS];
uniform vec3 lightgrid_filtered_scale;
uniform vec3 lightgrid_filtered_offset;
uniform float lightgrid_filtered_gain;

// SH coefficients of incident radiance, in the order of texels_per_probe.
struct LightgridLight {
    vec4 texels[LIGHTGRID_TEXELS];
    float known;     // share of weight that valid probes carried, before renormalisation; 0: no valid one is near
    float distance;  // metres to the nearest point that knows light, which answers; 0 where the position does
};

// A point in its cell of a grid.
struct LightgridCell {
    ivec3 lower;  // probe at the lower corner
    vec3 share;   // how far it is from there to the upper one
    bool inside;  // the grid
    ivec3 last;   // probe of the grid
    ivec2 first;  // brick of the grid in the index
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
    vec3 nearest = floor(inside + 0.5f);
    inside = mix(inside, nearest, vec3(lessThanEqual(abs(inside - nearest), slack)));

    LightgridCell cell;
    cell.lower = ivec3(inside);
    cell.share = inside - vec3(cell.lower);
    cell.inside = all(lessThanEqual(beyond, slack));
    cell.last = ivec3(last);
    cell.first = ivec2(int(origin.w), int(inverse_spacing.w));
    return cell;
}

LightgridLight lightgrid_black() {
    LightgridLight black;
    for (int t = 0; t < LIGHTGRID_TEXELS; ++t) black.texels[t] = vec4(0.0f);
    black.known = 0.0f;
    black.distance = 0.0f;
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

LightgridLight lightgrid_renormalised(LightgridLight sum) {
    for (int t = 0; t < LIGHTGRID_TEXELS; ++t) sum.texels[t] /= sum.known;
    return sum;
}

// The finest grid that knows an answer gives it. Where no probe around is valid, filled ones answer. Where nothing does,
// `known` is negative.
LightgridLight lightgrid_light_within(vec3 position) {
    int grids = textureSize(lightgrid_grids, 0).y;
    for (int turn = 0; turn < 2 * grids; ++turn) {
        LightgridCell cell = lightgrid_cell(turn % grids, position);
        if (!cell.inside) continue;
        LightgridLight light = lightgrid_sum(cell, turn < grids ? 2.0f : 1.0f);
        if (light.known > 0.0f) {
            light = lightgrid_renormalised(light);
            if (turn >= grids) light.known = 0.0f;
            return light;
        }
    }
    LightgridLight nothing = lightgrid_black();
    nothing.known = -1.0f;
    return nothing;
}

// A node in the tree of boxes of cells that know light.
struct LightgridNode {
    vec3 low;
    vec3 high;
    int link;                // first of two children; of a leaf: -1 - its grid
    float squared_distance;  // from a position
};

LightgridNode lightgrid_node(int number, vec3 position) {
    ivec2 at = ivec2(2 * (number & 1023), number >> 10);
    vec4 low = texelFetch(lightgrid_tree, at, 0);
    LightgridNode node;
    node.low = vec3(low);
    node.high = vec3(texelFetch(lightgrid_tree, at + ivec2(1, 0), 0));
    node.link = int(low.w);
    vec3 nearest = clamp(position, node.low, node.high);
    vec3 off = abs(position - nearest);
    off *= vec3(greaterThan(off, 2.4e-7f * (abs(position) + abs(nearest))));  // no distance where it is but rounding
    node.squared_distance = dot(off, off);
    return node;
}

// The leaf that is nearest; its `link` is 0 where no cell knows light.
LightgridNode lightgrid_nearest(vec3 position) {
    int waiting[40];  // a node at most for each level of the tree, which halves its leaves
    int count = 0;
    LightgridNode nearest = lightgrid_node(0, position);
    if (nearest.link > 0) waiting[count++] = 0;
    while (count > 0) {
        LightgridNode node = lightgrid_node(waiting[--count], position);
        if (nearest.link < 0 && !(node.squared_distance < nearest.squared_distance)) continue;
        if (node.link < 0) {
            nearest = node;
            continue;
        }
        bool second_is_nearer = lightgrid_node(node.link + 1, position).squared_distance <
                                lightgrid_node(node.link, position).squared_distance;
        waiting[count++] = node.link + (second_is_nearer ? 0 : 1);
        waiting[count++] = node.link + (second_is_nearer ? 1 : 0);
    }
    return nearest;
}

// On a face of its box where no corner answers, those of the cell do: a thousandth of the cell's size inside.
LightgridLight lightgrid_light_inside(LightgridNode box, vec3 position) {
    int grid = -1 - box.link;
    vec3 origin = vec3(texelFetch(lightgrid_grids, ivec2(0, grid), 0));
    vec3 inverse_spacing = vec3(texelFetch(lightgrid_grids, ivec2(1, grid), 0));
    ivec3 low = ivec3((box.low - origin) * inverse_spacing + 0.5f);
    ivec3 high = ivec3((box.high - origin) * inverse_spacing + 0.5f);
    LightgridCell cell = lightgrid_cell(grid, position);
    vec3 place = vec3(cell.lower) + cell.share;
    cell.lower = clamp(cell.lower, low, max(high - 1, low));
    cell.share = clamp(place - vec3(cell.lower), 0.0009765625f, 0.9990234375f);
    cell.share *= vec3(greaterThan(high, low));  // without thickness where there is a single probe along an axis
    LightgridLight light = lightgrid_sum(cell, 2.0f);
    if (light.known > 0.0f) return lightgrid_renormalised(light);
    light = lightgrid_renormalised(lightgrid_sum(cell, 1.0f));
    light.known = 0.0f;
    return light;
}

LightgridLight lightgrid_light(vec3 position) {
    LightgridLight light = lightgrid_light_within(position);
    if (light.known >= 0.0f) return light;
    LightgridNode nearest = lightgrid_nearest(position);
    if (nearest.link == 0) {
        light.known = 0.0f;
        light.distance = 3.0e38f;
        return light;
    }
    vec3 point = clamp(position, nearest.low, nearest.high);
    light = lightgrid_light_within(point);
    if (light.known < 0.0f) light = lightgrid_light_inside(nearest, point);
    light.distance = sqrt(nearest.squared_distance);
    return light;
}

// As Outside::fade: by its distance from the nearest point that knows light to the light of what is distant, which counts as known.
LightgridLight lightgrid_faded(LightgridLight light, LightgridLight distant, float fade_distance) {
    float share = light.distance < fade_distance ? light.distance / fade_distance : (light.distance > 0.0f ? 1.0f : 0.0f);
    for (int t = 0; t < LIGHTGRID_TEXELS; ++t) light.texels[t] = mix(light.texels[t], distant.texels[t], share);
    light.known = share + (1.0f - share) * light.known;
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
    light.distance = 0.0f;
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
