// defragment_sequential: puts the particles of the transfers that leave into the area given away, one after the other.
// Reads   windows.
// Writes  particles, motions, departing, in place; flow; how far it is in the first entries of the two lists.
// One invocation, which does what defragment_scan and defragment_swap do with many. Each part goes on where the one before has
// stopped; the first does all, where loops go on to their ends (src/sim/loops.rs).
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
    uint part;            // the first one begins
} params;

layout(std430, set = 0, binding = 0) buffer FlowBlock { Flow flow[]; };
layout(std430, set = 0, binding = 1) readonly buffer Windows { Window windows[]; };
layout(std430, set = 0, binding = 2) buffer Departing { Transfer departing[]; };
layout(rgba32ui, set = 0, binding = 3) uniform uimageBuffer particles;
layout(rgba32ui, set = 0, binding = 4) uniform uimageBuffer motions;
layout(std430, set = 0, binding = 5) buffer ParticleIndices { uint particle_indices[]; };
layout(std430, set = 0, binding = 6) buffer TransferIndices { uint transfer_indices[]; };

void main() {
    if (invocation_index() > 0u || params.next_object >= params.object_count) return;
    uint start = windows[params.next_object].start;
    uint leaving = flow[0].leaving;
    // The transfer to be looked at, and the slot of the area that may have to take its particle.
    uint i = 0u;
    uint next = 0u;
    if (params.part > 0u) {
        i = transfer_indices[0];
        next = particle_indices[0];
    }
    // With each round one of the two goes on.
    while (i < leaving) {
        uint outside = departing[i].particle;
        if (ring_offset(start, outside, params.particle_count) < leaving) {
            i += 1u;
            continue;
        }
        // There is a particle that stays in the area for every transfer whose particle is not in it.
        uint inside = ring_slot(start, next, params.particle_count);
        uvec4 motion = imageLoad(motions, int(inside));
        next += 1u;
        if (next < leaving && (motion.w & IN_FLIGHT) != 0u) continue;
        departing[i].particle = inside;
        uvec4 particle = imageLoad(particles, int(inside));
        imageStore(particles, int(inside), imageLoad(particles, int(outside)));
        imageStore(motions, int(inside), imageLoad(motions, int(outside)));
        imageStore(particles, int(outside), particle);
        imageStore(motions, int(outside), motion);
        i += 1u;
    }
    transfer_indices[0] = i;
    particle_indices[0] = next;
    // Nothing that would have to be exchanged is left by the last part; what is left is told as a mismatch.
    flow[0].outside = leaving - i;
}
