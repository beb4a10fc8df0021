// defragment_scan: lists slots that hold a particle of another object than their window's, and those particles, which lie outside of their
// object's window. Each object has equally many of both.
// Reads   flow, windows, particle_indices, transfers, particles, motions, strips.
// Writes  borders (counters); for each window, behind borders[].list: holes, the slots; strays and stray_motions, the particles.
// One invocation per slot that may be wrong: those of particles that have changed objects, then those that windows have got; or all of the
// ring, if particles were born. With SEQUENTIAL one invocation takes a run. Overflow: cannot happen; a window's part of the lists is as
// long as the number of slots that may be wrong.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"
#include "tables.glsl"

layout(local_size_x = 64) in;

layout(constant_id = 0) const bool SEQUENTIAL = false;

layout(push_constant) uniform Params {
    uint object_count;
    uint particle_count;
    uint first;  // of the run, by SEQUENTIAL
    uint count;  // of the run
    uint whole;  // 1: any slot may be wrong, because particles were born
} params;

layout(std430, set = 0, binding = 0) readonly buffer FlowBlock { Flow flow[]; };
layout(std430, set = 0, binding = 1) readonly buffer Windows { Window windows[]; };
layout(std430, set = 0, binding = 2) buffer Borders { Border borders[]; };
layout(std430, set = 0, binding = 3) readonly buffer ParticleIndices { uint particle_indices[]; };
layout(std430, set = 0, binding = 4) readonly buffer Transfers { Transfer transfers[]; };
PAGED_READS(uvec4, 5) particles;
PAGED_READS(uvec4, 6) motions;
READS(uvec4, 7) strips;
WRITES(uint, 8) holes;
PAGED_WRITES(uvec4, 9) strays;
PAGED_WRITES(uvec4, 10) stray_motions;

#include "strip_table.glsl"
#include "windows.glsl"

// Lists a slot of a window, and its particle, if that is another object's.
void look_at(uint slot, uint object) {
    uvec4 particle = fetch_paged(particles, slot);
    uint own = shape_words(particle.x).w;
    if (own == object) return;
    store1(holes, borders[object].list + atomicAdd(borders[object].holes, 1u), slot);
    int place = int(borders[own].list + atomicAdd(borders[own].strays, 1u));
    write_paged(strays, place, particle);
    write_paged(stray_motions, place, fetch_paged(motions, slot));
}

void main() {
    uint i = invocation_index();
    if (SEQUENTIAL) {
        if (i > 0u) return;
        i = params.first;
    }
    bool whole = params.whole != 0u;
    uint leaving = whole ? 0u : flow[0].leaving;
    uint all = whole ? params.particle_count : flow[0].gained + leaving;
    if (whole ? i >= params.particle_count : i >= all) return;
    uint end = min(i + params.count, all);
    // The parts of the lists are then as long as the windows.
    uint object = window_of(max(i, leaving) - leaving, whole);
    while (i < end) {
        if (whole) {
            while (object + 1u < params.object_count && borders[object + 1u].list <= i) object += 1u;
            look_at(ring_slot(windows[0].start, i, params.particle_count), object);
        } else if (i < leaving) {
            uint slot = particle_indices[i];
            // Slots that another window gains are examined by that window.
            if (has_kept(transfers[i].source, slot)) look_at(slot, transfers[i].source);
        } else {
            while (object + 1u < params.object_count && borders[object + 1u].first <= i - leaving) object += 1u;
            look_at(gained_slot(object, i - leaving - borders[object].first), object);
        }
        i += 1u;
    }
}
