// sort_count: counts the particles of a segment in each bin, and copies them to where sort_scatter takes them from.
// Reads   particles, motions, strips, windows.
// Writes  segment_particles, segment_motions; bins, by atomic adds: they are zero before.
// One invocation per particle of the segment.
// Overflow: cannot happen; there is a bin for every tile of every triangle.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"
#include "tables.glsl"
#include "append.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Params {
    uint particle_count;
    uint first;       // of the segment: how far behind the ring's beginning
    uint count;       // of its particles
    uint tile_shift;  // log2 of a tile's side, texels
    uint part_bits;   // log2 of how many parts a tile has along a side
} params;

PAGED_READS(uvec4, 0) particles;
PAGED_READS(uvec4, 1) motions;
READS(uvec4, 2) strips;
layout(std430, set = 0, binding = 3) buffer Bins { uint bins[]; };
PAGED_WRITES(uvec4, 4) segment_particles;  // one an invocation
PAGED_WRITES(uvec4, 5) segment_motions;  // one an invocation
layout(std430, set = 0, binding = 6) readonly buffer Windows { Window windows[]; };

#include "sort.glsl"

void main() {
    uint i = invocation_index();
    if (i >= params.count) return;
    int slot = int(slot_of(i));
    uvec4 particle = fetch_paged(particles, slot);
    write_paged(segment_particles, i, particle);
    write_paged(segment_motions, i, fetch_paged(motions, slot));
    uint bin = bin_of(particle);
    append_to_one_of(bins, bin, place)
}
