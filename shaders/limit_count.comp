// limit_count: counts the selected particles by half of their keys: by the upper half, then those with the limit's upper half by
// the lower one.
// Reads   particles, motions, flow.
// Writes  bins, by atomic adds: they are zero before.
// One invocation per particle; without excess there are no groups.
// Overflow: cannot happen; there is a bin for every half of a key.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"
#include "tables.glsl"
#include "ring.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Params {
    uint particle_count;
    uint salt;    // of the step
    uint is_low;  // 0 for the upper halves, 1 for the lower ones
} params;

PAGED_READS(uvec4, 0) particles;
PAGED_READS(uvec4, 1) motions;
layout(std430, set = 0, binding = 2) readonly buffer FlowBlock { Flow flow[]; };
layout(std430, set = 0, binding = 3) buffer Bins { uint bins[]; };

#include "limit.glsl"

void main() {
    uint i = invocation_index();
    if (i >= params.particle_count) return;
    if ((fetch_paged(motions, i).w & SELECTED) == 0u) return;
    uint key = key_of(fetch_paged(particles, i).w, params.salt);
    if (params.is_low == 0u) {
        atomicAdd(bins[key / BINS], 1u);
    } else if (key / BINS == flow[0].limit / BINS) {
        atomicAdd(bins[key % BINS], 1u);
    }
}
