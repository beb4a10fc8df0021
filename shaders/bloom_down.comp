// bloom_down: the next coarser level of the bloom, half as wide and high.
// Reads   bloom (a level).
// Writes  bloom (the next level).
// One invocation per cell of the coarser level.
// Overflow: cannot happen; beyond its edges a level continues as at them.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "index.glsl"
#include "tables.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Params {
    uint cell_count;   // of the coarser level
    uint across;       // its cells in a row
    uint first;        // its first element
    uint fine_across;
    uint fine_down;
    uint fine_first;
} params;

CHANGES(vec4, 0) bloom;

vec3 fine_at(int x, int y) {
    uint column = uint(clamp(x, 0, int(params.fine_across) - 1));
    uint row = uint(clamp(y, 0, int(params.fine_down) - 1));
    return load4(bloom, params.fine_first + row * params.fine_across + column).xyz;
}

// A quarter, three quarters, three quarters, a quarter: twice that of four in a row. It sums up what may not be contracted.
vec3 mean_of(vec3 a, vec3 b, vec3 c, vec3 d) {
    precise vec3 outer = a + d;
    precise vec3 inner = b + c;
    precise vec3 outer_share = outer * 0.125;
    precise vec3 inner_share = inner * 0.375;
    precise vec3 sum = outer_share + inner_share;
    return sum;
}

vec3 row_at(int x, int y) {
    return mean_of(fine_at(x - 1, y), fine_at(x, y), fine_at(x + 1, y), fine_at(x + 2, y));
}

void main() {
    uint i = invocation_index();
    if (i >= params.cell_count) return;
    int x = 2 * int(i % params.across);
    int y = 2 * int(i / params.across);
    vec3 mean = mean_of(row_at(x, y - 1), row_at(x, y), row_at(x, y + 1), row_at(x, y + 2));
    store4(bloom, params.first + i, vec4(mean, 0.0));
}
