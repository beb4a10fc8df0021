// limit_list: lists the selected particles whose keys are within the limit; the others stay on their objects.
// Reads   particles, flow.
// Writes  motions in place; particle_indices (appended, counted in flow.listed).
// One invocation a particle; without excess there are no groups.
// Overflow: cannot happen; no two keys are equal, so that as many are within the limit as the list holds.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"
#include "ring.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Params {
    uint particle_count;
    uint capacity;
    uint salt;
} params;

layout(set = 0, binding = 0) uniform usamplerBuffer particles;
layout(rgba32ui, set = 0, binding = 1) uniform uimageBuffer motions;
layout(std430, set = 0, binding = 2) buffer FlowBlock { Flow flow[]; };
layout(std430, set = 0, binding = 3) writeonly buffer ParticleIndices { uint particle_indices[]; };

#include "limit.glsl"

void main() {
    uint i = invocation_index();
    if (i >= params.particle_count) return;
    uvec4 motion = imageLoad(motions, int(i));
    if ((motion.w & SELECTED) == 0u) return;
    if (key_of(texelFetch(particles, int(i)).w, params.salt) <= flow[0].limit) {
        uint place = atomicAdd(flow[0].listed, 1u);
        if (place < params.capacity) particle_indices[place] = i;
    } else {
        motion.w &= ~SELECTED;
        imageStore(motions, int(i), motion);
    }
}
