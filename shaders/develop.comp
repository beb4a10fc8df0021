// develop: adds the bloom to a picture, and lists the pixels at edges.
// Reads   picture, bloom (its finest level).
// Writes  developed; edges and groups, if edges are to be smoothed.
// One invocation per four pixels of a row.
// Overflow: cannot happen; the list has room for every pixel.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "index.glsl"
#include "tables.glsl"
#include "append.glsl"

layout(local_size_x = 64) in;

// Is there bloom? Are edges to be smoothed? May pixels be clear, where there is bloom? CPU drivers run both sides of a branch.
layout(constant_id = 0) const bool BLOOMS = true;
layout(constant_id = 1) const bool SMOOTHS = true;
layout(constant_id = 2) const bool MAY_BE_CLEAR = true;

layout(push_constant) uniform Params {
    uint quad_count;
    uint across;      // fours of pixels in a row
    uint width;       // of the picture, pixels
    uint height;
    uint cells_down;  // of the bloom; it has `across` in a row
    uint is_opaque;   // 1: the picture's alpha is set to 255
    uint in_group;    // invocations in a group of the kernel that smooths edges
} params;

READS(uvec4, 0) picture;
READS(vec4, 1) bloom;
WRITES(uvec4, 2) developed;
layout(std430, set = 0, binding = 3) writeonly buffer Edges { uint edges[]; };
layout(std430, set = 0, binding = 4) buffer Groups { DispatchGroups groups[]; };

#include "strict.glsl"
#include "developing.glsl"
#include "groups.glsl"

// Differences from which on an edge is smoothed: of all steps of brightness, and of the brightest pixel, in sixteenths.
const int LEAST_STEP = 40;
const int LEAST_SHARE = 2;

vec3 bloom_at(int column, int row) {
    uint x = uint(clamp(column, 0, int(params.across) - 1));
    uint y = uint(clamp(row, 0, int(params.cells_down) - 1));
    return fetch4(bloom, y * params.across + x).xyz;
}

ivec4 brightness_of_four(uvec4 words) {
    return ivec4(brightness_of(words.x), brightness_of(words.y), brightness_of(words.z), brightness_of(words.w));
}

uvec4 row_of(uint column, int row) {
    return fetch4(picture, uint(clamp(row, 0, int(params.height) - 1)) * params.across + column);
}

void main() {
    uint i = invocation_index();
    if (i >= params.quad_count) return;
    uint column = i % params.across;
    uint row = i / params.across;
    uvec4 words = fetch4(picture, i);
    uvec4 alphas = words >> 24u;
    if (params.is_opaque == 1u) alphas = uvec4(255u);

    // The columns of cells on the left, here and on the right, at this row.
    vec3 left = vec3(0.0);
    vec3 here = vec3(0.0);
    vec3 right = vec3(0.0);
    if (BLOOMS) {
        int cell = int(row >> 2u);
        // Eighths of a cell from its middle: -3, -1, 1, 3.
        int eighths = 2 * int(row & 3u) - 3;
        int beside = cell + (eighths < 0 ? -1 : 1);
        precise float part = float(abs(eighths)) * 0.125;
        int x = int(column);
        left = part_way(bloom_at(x - 1, cell), bloom_at(x - 1, beside), part);
        here = part_way(bloom_at(x, cell), bloom_at(x, beside), part);
        right = part_way(bloom_at(x + 1, cell), bloom_at(x + 1, beside), part);
    }
    uvec4 result;
    for (uint x = 0u; x < 4u; x++) {
        vec3 glow = x < 2u ? part_way(here, left, x == 0u ? 0.375 : 0.125) : part_way(here, right, x == 2u ? 0.125 : 0.375);
        result[x] = with_bloom(bytes_of(words[x]), alphas[x], glow, noise_of(4u * column + x, row), MAY_BE_CLEAR);
    }
    store4(developed, i, result);

    if (SMOOTHS) {
        ivec4 own = brightness_of_four(words);
        ivec4 above = brightness_of_four(row_of(column, int(row) - 1));
        ivec4 below = brightness_of_four(row_of(column, int(row) + 1));
        uint last = params.width - 1u;
        int before = column == 0u ? own.x : brightness_of(row_of(column - 1u, int(row)).w);
        int after = 4u * column + 4u > last ? own.w : brightness_of(row_of(column + 1u, int(row)).x);
        ivec4 to_left = ivec4(before, own.xyz);
        ivec4 to_right = ivec4(own.yzw, after);
        ivec4 most = max(max(max(above, below), max(to_left, to_right)), own);
        ivec4 least = min(min(min(above, below), min(to_left, to_right)), own);
        for (uint x = 0u; x < 4u; x++) {
            int step = most[x] - least[x];
            // What lies to the right of the last pixel is not of the picture.
            bool has_right = 4u * column + x < last;
            if (has_right && step >= LEAST_STEP && 16 * step >= LEAST_SHARE * most[x]) {
                edges[appended(params.in_group)] = 4u * i + x;
            }
        }
    }
}
