// sort_scatter: puts the particles of a slice back in the order of their bins. Within a bin they come in any order, which nothing
// depends on.
// Reads   slice_particles, slice_motions, strips, windows.
// Writes  particles and motions; bins, by atomic adds.
// One invocation a particle of the slice.
// Bins are numbered object by object, and a slice has as many particles of each object as before: so all stay in their windows.
// Overflow: cannot happen; each slot is taken once.

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

layout(set = 0, binding = 0) uniform usamplerBuffer slice_particles;  // one an invocation
layout(set = 0, binding = 1) uniform usamplerBuffer slice_motions;  // one an invocation
layout(set = 0, binding = 2) uniform usamplerBuffer strips;
layout(std430, set = 0, binding = 3) buffer Bins { uint bins[]; };
layout(rgba32ui, set = 0, binding = 4) uniform writeonly uimageBuffer particles;
layout(rgba32ui, set = 0, binding = 5) uniform writeonly uimageBuffer motions;
layout(std430, set = 0, binding = 6) readonly buffer Windows { Window windows[]; };

#include "sort.glsl"

void main() {
    uint i = invocation_index();
    if (i >= params.count) return;
    uvec4 particle = texelFetch(slice_particles, int(i));
    uvec4 motion = texelFetch(slice_motions, int(i));
    int slot = int(slot_of(atomicAdd(bins[bin_of(particle)], 1u)));
    imageStore(particles, slot, particle);
    imageStore(motions, slot, motion);
}
