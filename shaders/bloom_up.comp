// bloom_up: adds the next coarser level of the bloom to a level; in the finest, light becomes what a picture shows.
// Reads   bloom (a coarser level).
// Writes  bloom (a level; each invocation reads its own cell first).
// One invocation per cell of the finer level.
// Overflow: cannot happen; beyond its edges a level continues as at them.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "index.glsl"
#include "tables.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Params {
    uint cell_count;     // of the finer level
    uint across;         // its cells in a row
    uint first;          // its first element
    uint coarse_across;
    uint coarse_down;
    uint coarse_first;
    float kept;          // weight of the finer level
    float spread;        // weight of the coarser level
    float strength;      // of the sum
    uint is_last;        // 1: the root of the sum is written, as the picture has encoded values
} params;

CHANGES(vec4, 0) bloom;

#include "strict.glsl"

vec3 coarse_at(int x, int y) {
    uint column = uint(clamp(x, 0, int(params.coarse_across) - 1));
    uint row = uint(clamp(y, 0, int(params.coarse_down) - 1));
    return load4(bloom, params.coarse_first + row * params.coarse_across + column).xyz;
}

// Three quarters of the nearer, a quarter of the farther.
vec3 between(vec3 near, vec3 far) {
    precise vec3 most = near * 0.75;
    precise vec3 rest = far * 0.25;
    precise vec3 sum = most + rest;
    return sum;
}

void main() {
    uint i = invocation_index();
    if (i >= params.cell_count) return;
    uint column = i % params.across;
    uint row = i / params.across;
    int x = int(column >> 1u);
    int y = int(row >> 1u);
    int beside_x = x + ((column & 1u) == 0u ? -1 : 1);
    int beside_y = y + ((row & 1u) == 0u ? -1 : 1);
    vec3 here = between(coarse_at(x, y), coarse_at(beside_x, y));
    vec3 beside = between(coarse_at(x, beside_y), coarse_at(beside_x, beside_y));
    vec3 coarse = between(here, beside);
    vec3 own = load4(bloom, params.first + i).xyz;
    precise vec3 kept = own * params.kept;
    precise vec3 spread = coarse * params.spread;
    precise vec3 sum = kept + spread;
    precise vec3 result = sum * params.strength;
    if (params.is_last == 1u) {
        result = vec3(root(min(result.x, 1.0)), root(min(result.y, 1.0)), root(min(result.z, 1.0)));
    }
    store4(bloom, params.first + i, vec4(result, 0.0));
}
