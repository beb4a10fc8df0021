// settle: particles that have won the cells which they claimed take them. A cell that is left is free from the next round on.
// Writes  claims of those that have won, which are done; cells: which one is taken, and which is left.
// One invocation per particle. A cell's word is its winner's rank, or says that it is taken. Meanwhile only the winner changes it, and only a
// particle that leaves changes another one: whatever others read there, it is not their rank.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"
#include "tables.glsl"
#include "texels.glsl"
#include "claims.glsl"

layout(local_size_x = 256) in;

layout(push_constant) uniform Params {
    uint particle_count;
} params;

PAGED_CHANGES(uvec4, 0) claims;  // one an invocation
layout(std430, set = 0, binding = 1) buffer Cells { uint cells_block[]; };
CHANGES(uint, 2) cells_low;
CHANGES(uint, 3) cells_high;

void main() {
    uint i = invocation_index();
    if (i >= params.particle_count) return;
    // The cell, the present cell, the rank.
    uvec4 claim = load_paged(claims, i);
    if (claim.x == NONE) return;
    // A step within its own cell needs no claim.
    if (claim.x != claim.y) {
        lower_texel(cells, claim.x, FREE, winner)
        if (winner != claim.z) return;
        replace_texel(cells, claim.x, TAKEN)
        lower_texel(cells, claim.y, FREE, left)
        if (left == TAKEN) replace_texel(cells, claim.y, FREE)
    }
    store_paged(claims, i, uvec4(NONE, claim.yzw));
}
