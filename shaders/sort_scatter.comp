// sort_scatter: puts the particles of a segment back in the order of their bins. Within a bin they come in any order, which nothing depends
// on.
// Reads   segment_particles, segment_motions, strips, windows.
// Writes  particles and motions; places, by atomic adds.
// One invocation per particle of the segment. Bins are numbered object by object, and the segment's number of particles of each object does
// not change, so that all stay in their windows.
// Overflow: cannot happen; each slot is taken once.

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

PAGED_READS(uvec4, 0) segment_particles;  // one an invocation
PAGED_READS(uvec4, 1) segment_motions;  // one an invocation
READS(uvec4, 2) strips;
layout(std430, set = 0, binding = 3) buffer Places { uint places[]; };
PAGED_WRITES(uvec4, 4) particles;
PAGED_WRITES(uvec4, 5) motions;
layout(std430, set = 0, binding = 6) readonly buffer Windows { Window windows[]; };

#include "sort.glsl"

void main() {
    uint i = invocation_index();
    if (i >= params.count) return;
    uvec4 particle = fetch_paged(segment_particles, i);
    uvec4 motion = fetch_paged(segment_motions, i);
    uint bin = bin_of(particle);
    append_to_one_of(places, bin, place)
    uint slot = slot_of(place);
    write_paged(particles, slot, particle);
    write_paged(motions, slot, motion);
}
