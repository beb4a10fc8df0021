// defragment_swap: exchanges the particles that defragment_scan has listed, pair by pair, and tells transfers the new slot
// of their particle.
// Reads   flow, particle_indices, transfer_indices.
// Writes  particles, motions, departing, in place.
// One invocation a pair; which ones are paired does not matter, as nothing depends on a particle's slot.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Params {
    uint capacity;
} params;

layout(std430, set = 0, binding = 0) readonly buffer FlowBlock { Flow flow[]; };
layout(std430, set = 0, binding = 1) readonly buffer ParticleIndices { uint particle_indices[]; };
layout(std430, set = 0, binding = 2) readonly buffer TransferIndices { uint transfer_indices[]; };
layout(std430, set = 0, binding = 3) buffer Departing { Transfer departing[]; };
layout(rgba32ui, set = 0, binding = 4) uniform uimageBuffer particles;
layout(rgba32ui, set = 0, binding = 5) uniform uimageBuffer motions;

void main() {
    uint i = invocation_index();
    if (i >= params.capacity || i >= min(flow[0].stayers, flow[0].outside)) return;
    uint transfer = transfer_indices[i];
    uint inside = particle_indices[i];
    uint outside = departing[transfer].particle;
    departing[transfer].particle = inside;
    uvec4 particle = imageLoad(particles, int(inside));
    uvec4 motion = imageLoad(motions, int(inside));
    imageStore(particles, int(inside), imageLoad(particles, int(outside)));
    imageStore(motions, int(inside), imageLoad(motions, int(outside)));
    imageStore(particles, int(outside), particle);
    imageStore(motions, int(outside), motion);
}
