// claim: every particle claims the cell that it would come to, if it may come there once that is empty; the lowest rank remains.
// Reads   claims, cells.
// Writes  bids, by atomic minima, so that no order shows; goals: a mark, by each particle that finds another rank in its own cell.
// One invocation per particle.
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
} params;

PAGED_READS(uvec4, 0) claims;  // one an invocation
READS(uint, 1) cells_texels;
layout(std430, set = 0, binding = 2) buffer Bids { uint bids_block[]; };
CHANGES(uint, 3) bids_low;
CHANGES(uint, 4) bids_high;
layout(std430, set = 0, binding = 5) writeonly buffer Goals { uint goals_block[]; };
WRITES(uint, 6) goals_low;
WRITES(uint, 7) goals_high;

void main() {
    uint i = invocation_index();
    if (i >= params.particle_count) return;
    // The cell that it would come to, the present cell, the rank, the texel there.
    uvec4 claim = fetch_paged(claims, i);
    if (MORTAL && claim.z == NO_RANK) return;
    if (texel_of(cells, claim.y) != claim.z) put_texel(goals, claim.y, SHARED)
    if (!may_come(claim.z, texel_of(cells, claim.x))) return;
    lower_texel(bids, claim.x, claim.z, before)
}
