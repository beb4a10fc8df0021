// claim: every particle that has not moved yet claims the cell that it would come to; of those that claim one, the lowest rank remains.
// Reads   particles, wishes.
// Writes  cells, by atomic minima, so that no order shows; a taken cell stays as it is.
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

layout(push_constant) uniform Params {
    uint particle_count;
    uint salt;  // of the step
} params;

PAGED_READS(uvec4, 0) particles;  // one an invocation
PAGED_READS(uvec4, 1) wishes;  // one an invocation
layout(std430, set = 0, binding = 2) buffer Cells { uint cells_block[]; };
CHANGES(uint, 3) cells_low;
CHANGES(uint, 4) cells_high;

void main() {
    uint i = invocation_index();
    if (i >= params.particle_count) return;
    uint cell = fetch_paged(wishes, i).w;
    if (cell == NONE) return;
    uint rank = rank_of(fetch_paged(particles, i).w, params.salt);
    lower_texel(cells, cell, rank, before)
}
