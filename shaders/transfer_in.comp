// transfer_in: transfers that are for this object land on it; the others are copied on, to the front of the lists.
// Reads   arriving, triangles, corners, vertices, poses.
// Writes  particles and motions in place, departing (appended), flow.
// One invocation a transfer that the last turn left.
// Overflow: cannot happen; the lists are empty but for these, and held them in the last turn.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "words.glsl"
#include "index.glsl"
#include "counted.glsl"
#include "ring.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Params {
    uint object;    // whose turn it is; NONE where all transfers land
    uint capacity;  // of the lists of transfers
} params;

layout(std430, set = 0, binding = 0) readonly buffer Arriving { Transfer arriving[]; };
layout(std430, set = 0, binding = 1) writeonly buffer Departing { Transfer departing[]; };
layout(std430, set = 0, binding = 2) buffer FlowBlock { Flow flow[]; };
layout(rgba32ui, set = 0, binding = 3) uniform uimageBuffer particles;
layout(rgba32ui, set = 0, binding = 4) uniform uimageBuffer motions;
layout(set = 0, binding = 5) uniform usamplerBuffer triangles;
layout(set = 0, binding = 6) uniform usamplerBuffer corners;
layout(set = 0, binding = 7) uniform usamplerBuffer vertices;
layout(set = 0, binding = 8) uniform samplerBuffer poses;

#include "transfer.glsl"

void main() {
    uint i = invocation_index();
    if (i >= params.capacity || i >= flow[0].leaving) return;
    Transfer transfer = arriving[i];
    if (params.object != NONE && params.object != transfer.target) {
        atomicAdd(flow[0].passing, 1u);
        departing[atomicAdd(flow[0].wanted, 1u)] = transfer;
        return;
    }
    count_one(flow[0].arrived)
    int slot = int(transfer.particle);
    Motion motion = motion_of(imageLoad(motions, slot));
    Landing landing = landing_on(transfer.triangle, Flight(transfer.position, transfer.heading, transfer.normal));
    Particle landed = Particle(transfer.triangle, landing.u, landing.v, imageLoad(particles, slot).w);
    imageStore(particles, slot, words_of(landed));
    Motion goes_on = Motion(landing.heading_p, landing.heading_h, motion.pending + transfer.rest, motion.flags & ~IN_FLIGHT);
    imageStore(motions, slot, words_of(goes_on));
}
