// sort_count: counts the particles of a slice in each bin, and copies them to where sort_scatter takes them from.
// Reads   particles, motions, strips, windows.
// Writes  slice_particles, slice_motions; bins, by atomic adds: they are zero before.
// One invocation a particle of the slice.
// Overflow: cannot happen; there is a bin for every tile of every triangle.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Params {
    uint particle_count;
    uint first;       // of the slice: how far behind the ring's beginning
    uint count;       // of its particles
    uint tile_shift;  // log2 of a tile's side, texels
} params;

layout(set = 0, binding = 0) uniform usamplerBuffer particles;
layout(set = 0, binding = 1) uniform usamplerBuffer motions;
layout(set = 0, binding = 2) uniform usamplerBuffer strips;
layout(std430, set = 0, binding = 3) buffer Bins { uint bins[]; };
layout(rgba32ui, set = 0, binding = 4) uniform writeonly uimageBuffer slice_particles;  // one an invocation
layout(rgba32ui, set = 0, binding = 5) uniform writeonly uimageBuffer slice_motions;  // one an invocation
layout(std430, set = 0, binding = 6) readonly buffer Windows { Window windows[]; };

#include "sort.glsl"

void main() {
    uint i = invocation_index();
    if (i >= params.count) return;
    int slot = int(slot_of(i));
    uvec4 particle = texelFetch(particles, slot);
    imageStore(slice_particles, int(i), particle);
    imageStore(slice_motions, int(i), texelFetch(motions, slot));
    atomicAdd(bins[bin_of(particle)], 1u);
}
