// transfer_in: particles that have left their objects land.
// Reads   transfers, triangles, corners, vertices, poses.
// Writes  particles and motions in place; flow and borders, by atomic adds.
// One invocation per transfer.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "words.glsl"
#include "index.glsl"
#include "tables.glsl"
#include "counted.glsl"
#include "ring.glsl"

layout(local_size_x = 64) in;

// Objects have windows, whose borders are to move.
layout(constant_id = 0) const bool WINDOWS = false;

layout(push_constant) uniform Params {
    uint capacity;  // of the lists of transfers
} params;

layout(std430, set = 0, binding = 0) readonly buffer Transfers { Transfer transfers[]; };
layout(std430, set = 0, binding = 1) buffer Borders { Border borders[]; };
layout(std430, set = 0, binding = 2) buffer FlowBlock { Flow flow[]; };
PAGED_CHANGES(uvec4, 3) particles;
PAGED_CHANGES(uvec4, 4) motions;
READS(uvec4, 5) triangles;
READS(uint, 6) corners;
READS(uvec4, 7) vertices;
READS(vec4, 8) poses;

#include "transfer.glsl"

void main() {
    uint i = invocation_index();
    if (i >= params.capacity || i >= flow[0].leaving) return;
    Transfer transfer = transfers[i];
    count_one(flow[0].arrived)
    if (WINDOWS && transfer.source != transfer.target) {
        atomicAdd(borders[transfer.source].left, 1u);
        atomicAdd(borders[transfer.target].came, 1u);
    }
    if (transfer.stays == 1u) return;
    int slot = int(transfer.particle);
    Motion motion = motion_of(load_paged(motions, slot));
    Landing landing = landing_on(transfer.triangle, Flight(transfer.position, transfer.heading, transfer.normal));
    Particle landed = Particle(transfer.triangle, landing.u, landing.v, load_paged(particles, slot).w);
    store_paged(particles, slot, words_of(landed));
    precise float pending = motion.pending + transfer.rest;
    Motion goes_on = Motion(landing.heading_p, landing.heading_h, settled(pending), motion.flags & ~SELECTED);
    store_paged(motions, slot, words_of(goes_on));
}
