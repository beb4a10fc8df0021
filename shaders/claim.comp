// claim: every particle claims the cell that it would come to; of those that claim one, the lowest rank remains. What is taken, or was won in an
// earlier round, stays as it is: so winners claim their cell again for nothing. Particles that would move before the one that is in their cell
// are marked in the first round, in which no cell has been left, and claim nothing.
// Reads   claims.
// Writes  cells, by atomic minima, so that no order shows; claims, the mark in place of the rank.
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
    uint round;  // from 0
} params;

PAGED_CHANGES(uvec4, 0) claims;  // one an invocation
layout(std430, set = 0, binding = 1) buffer Cells { uint cells_block[]; };
CHANGES(uint, 2) cells_low;
CHANGES(uint, 3) cells_high;

void main() {
    uint i = invocation_index();
    if (i >= params.particle_count) return;
    // The cell, the present cell, the rank, the texel.
    uvec4 claim = load_paged(claims, i);
    if (MORTAL && claim.z == NO_RANK) return;
    if (claim.z == REFUSED) return;
    uint mine = claim_of(claim.z, params.round);
    // Words only become less meanwhile. A look first, because an atomic minimum takes much longer where it is not needed.
    read_texel(cells, claim.x, word)
    if (params.round == 0u && comes_too_early(claim.z, word)) {
        store_paged(claims, i, uvec4(claim.x, claim.y, REFUSED, claim.w));
        return;
    }
    if (word > mine) {
        lower_texel(cells, claim.x, mine, before)
    }
}
