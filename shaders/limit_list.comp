// limit_list: lists the selected particles whose keys are within the limit; the others stay on their objects.
// Reads   particles, flow.
// Writes  motions in place; particle_indices (appended, counted in flow.listed).
// One invocation per particle; without excess there are no groups.
// Overflow: cannot happen; no two keys are equal, so that as many are within the limit as the list holds.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"
#include "tables.glsl"
#include "ring.glsl"
#include "append.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Params {
    uint particle_count;
    uint capacity;
    uint salt;
} params;

PAGED_READS(uvec4, 0) particles;
PAGED_CHANGES(uvec4, 1) motions;
layout(std430, set = 0, binding = 2) buffer FlowBlock { Flow flow[]; };
layout(std430, set = 0, binding = 3) writeonly buffer ParticleIndices { uint particle_indices[]; };

#include "limit.glsl"

void main() {
    uint i = invocation_index();
    if (i >= params.particle_count) return;
    uvec4 motion = load_paged(motions, i);
    if ((motion.w & SELECTED) == 0u) return;
    if (key_of(fetch_paged(particles, i).w, params.salt) <= flow[0].limit) {
        append_to(flow[0].listed, place)
        if (place < params.capacity) particle_indices[place] = i;
    } else {
        motion.w &= ~SELECTED;
        store_paged(motions, i, motion);
    }
}
