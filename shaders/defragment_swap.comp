// defragment_swap: puts the particles that defragment_scan has listed into the slots of their objects' windows where particles of other
// objects lay.
// Reads   flow, borders, holes, strays, stray_motions.
// Writes  particles, motions.
// One invocation per entry of the lists. Nothing depends on which slot of its window a particle gets. With SEQUENTIAL one invocation takes
// a run of entries.
// Overflow: cannot happen; nothing is appended.

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
} params;

layout(std430, set = 0, binding = 0) readonly buffer FlowBlock { Flow flow[]; };
layout(std430, set = 0, binding = 1) readonly buffer Windows { Window windows[]; };
layout(std430, set = 0, binding = 2) readonly buffer Borders { Border borders[]; };
READS(uint, 3) holes;
PAGED_READS(uvec4, 4) strays;
PAGED_READS(uvec4, 5) stray_motions;
PAGED_WRITES(uvec4, 6) particles;
PAGED_WRITES(uvec4, 7) motions;

#include "windows.glsl"

void main() {
    uint i = invocation_index();
    if (SEQUENTIAL) {
        if (i > 0u) return;
        i = params.first;
    }
    if (i >= flow[0].entries) return;
    uint end = min(i + params.count, flow[0].entries);
    uint object = window_of(i, true);
    while (i < end) {
        while (object + 1u < params.object_count && borders[object + 1u].list <= i) object += 1u;
        Border border = borders[object];
        // Parts have their largest possible length.
        if (i - border.list < min(border.holes, border.strays)) {
            int slot = int(fetch1(holes, i));
            write_paged(particles, slot, fetch_paged(strays, i));
            write_paged(motions, slot, fetch_paged(stray_motions, i));
        }
        i += 1u;
    }
}
