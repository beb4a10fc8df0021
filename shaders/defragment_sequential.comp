// defragment_sequential: puts the particles of the transfers that leave into the area given away, one after the other.
// Reads   flow, windows.
// Writes  particles, motions, departing, in place.
// One invocation, which does what defragment_scan and defragment_swap do with many.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"
#include "ring.glsl"

layout(local_size_x = 1) in;

layout(push_constant) uniform Params {
    uint next_object;     // whose window begins with the area given away
    uint object_count;
    uint particle_count;
} params;

layout(std430, set = 0, binding = 0) readonly buffer FlowBlock { Flow flow[]; };
layout(std430, set = 0, binding = 1) readonly buffer Windows { Window windows[]; };
layout(std430, set = 0, binding = 2) buffer Departing { Transfer departing[]; };
layout(rgba32ui, set = 0, binding = 3) uniform uimageBuffer particles;
layout(rgba32ui, set = 0, binding = 4) uniform uimageBuffer motions;

void main() {
    if (invocation_index() > 0u || params.next_object >= params.object_count) return;
    uint start = windows[params.next_object].start;
    uint leaving = flow[0].leaving;
    uint next = 0u;
    for (uint i = 0u; i < leaving; i += 1u) {
        uint outside = departing[i].particle;
        if (ring_offset(start, outside, params.particle_count) < leaving) continue;
        // There is a particle that stays in the area for every transfer whose particle is not in it.
        uint inside = ring_slot(start, next, params.particle_count);
        while (next + 1u < leaving && (imageLoad(motions, int(inside)).w & IN_FLIGHT) != 0u) {
            next += 1u;
            inside = ring_slot(start, next, params.particle_count);
        }
        next += 1u;
        departing[i].particle = inside;
        uvec4 particle = imageLoad(particles, int(inside));
        uvec4 motion = imageLoad(motions, int(inside));
        imageStore(particles, int(inside), imageLoad(particles, int(outside)));
        imageStore(motions, int(inside), imageLoad(motions, int(outside)));
        imageStore(particles, int(outside), particle);
        imageStore(motions, int(outside), motion);
    }
}
