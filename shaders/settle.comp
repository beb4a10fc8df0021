// settle: what particles leave that have won a cell in this round is free from the next round on.
// Reads   claims.
// Writes  cells: those that are left.
// One invocation per particle. Meanwhile words change only from taken to free: whatever others read there, it is not their claim.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"
#include "tables.glsl"
#include "texels.glsl"
#include "claims.glsl"

layout(local_size_x = 256) in;

// Particles may be dead.
layout(constant_id = 22) const bool MORTAL = false;

layout(push_constant) uniform Params {
    uint particle_count;
    uint round;  // from 0
} params;

PAGED_READS(uvec4, 0) claims;  // one an invocation
layout(std430, set = 0, binding = 1) buffer Cells { uint cells_block[]; };
CHANGES(uint, 2) cells_low;
CHANGES(uint, 3) cells_high;

void main() {
    uint i = invocation_index();
    if (i >= params.particle_count) return;
    // The cell, the present cell, the rank, the texel.
    uvec4 claim = fetch_paged(claims, i);
    if (MORTAL && claim.z == NO_RANK) return;
    read_texel(cells, claim.x, winner)
    if (winner != claim_of(claim.z, params.round)) return;
    // The only particle in its cell: no other one writes this word here.
    read_texel(cells, claim.y, left)
    if (left == taken_by(claim.z)) write_texel(cells, claim.y, FREE)
}
