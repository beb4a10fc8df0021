// defragment_scan: lists what lies in the wrong place after the border has moved: particles that stay and lie in the area
// given away, and transfers whose particle does not lie there. They are equally many.
// Reads   departing, motions, windows, flow.
// Writes  particle_indices (appended, counted in flow.stayers): slots of particles that stay; transfer_indices (appended,
//         counted in flow.outside): transfers whose particle lies outside.
// One invocation a transfer that leaves, which looks at one slot of the area too.
// Overflow: cannot happen; either list has at most as many entries as there are transfers.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"
#include "ring.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Params {
    uint next_object;     // whose window begins with the area given away
    uint particle_count;
    uint capacity;
} params;

layout(std430, set = 0, binding = 0) readonly buffer Departing { Transfer departing[]; };
layout(set = 0, binding = 1) uniform usamplerBuffer motions;
layout(std430, set = 0, binding = 2) readonly buffer Windows { Window windows[]; };
layout(std430, set = 0, binding = 3) buffer FlowBlock { Flow flow[]; };
layout(std430, set = 0, binding = 4) writeonly buffer ParticleIndices { uint particle_indices[]; };
layout(std430, set = 0, binding = 5) writeonly buffer TransferIndices { uint transfer_indices[]; };

void main() {
    uint i = invocation_index();
    if (i >= params.capacity || i >= flow[0].leaving) return;
    uint start = windows[params.next_object].start;
    uint slot = ring_slot(start, i, params.particle_count);
    if ((texelFetch(motions, int(slot)).w & IN_FLIGHT) == 0u) {
        particle_indices[atomicAdd(flow[0].stayers, 1u)] = slot;
    }
    if (ring_offset(start, departing[i].particle, params.particle_count) >= flow[0].leaving) {
        transfer_indices[atomicAdd(flow[0].outside, 1u)] = i;
    }
}
