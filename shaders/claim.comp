// claim: every particle that has not won a cell yet claims the one that it would come to; of those that claim one, the lowest rank remains.
// Reads   claims.
// Writes  cells, by atomic minima, so that no order shows; a taken cell stays as it is.
// One invocation per particle.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"
#include "tables.glsl"
#include "texels.glsl"

layout(local_size_x = 256) in;

layout(push_constant) uniform Params {
    uint particle_count;
} params;

PAGED_READS(uvec4, 0) claims;  // one an invocation
layout(std430, set = 0, binding = 1) buffer Cells { uint cells_block[]; };
CHANGES(uint, 2) cells_low;
CHANGES(uint, 3) cells_high;

void main() {
    uint i = invocation_index();
    if (i >= params.particle_count) return;
    // The cell, the present cell, the rank.
    uvec4 claim = fetch_paged(claims, i);
    if (claim.x == NONE) return;
    lower_texel(cells, claim.x, claim.z, before)
}
