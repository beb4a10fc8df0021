// draw_order: lists the particles of a picture by their ids. Pixels round each sum, so a picture is always the same only if its points come
// in the same order, and the order of slots is not fixed.
// Reads   particles.
// Writes  order: the slot of each particle whose id is a multiple of the stride.
// One invocation per slot.
// Overflow: cannot happen; ids are below the number of particles, and no two particles have the same.
#version 460
#include "index.glsl"
#include "tables.glsl"

layout(local_size_x = 256) in;

PAGED_READS(uvec4, 0) particles;
layout(set = 0, binding = 1) writeonly buffer Order { uint order[]; };

layout(push_constant) uniform Params {
    uint particle_count;
    uint stride;  // from one drawn id to the next
} params;

void main() {
    uint slot = invocation_index();
    if (slot >= params.particle_count) return;
    uint id = fetch_paged(particles, slot).w;
    if (id % params.stride == 0u) order[id / params.stride] = slot;
}
