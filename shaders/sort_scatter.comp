// sort_scatter: puts particles in the order of their bins. Within a bin they come in any order, which nothing depends on.
// Reads   particles, motions, strips, windows.
// Writes  sorted_particles and sorted_motions; bins, by atomic adds.
// One invocation a particle.
// With windows the bins lie one behind the other in the ring, from the first window on.
// Overflow: cannot happen; each slot is taken once.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"
#include "ring.glsl"

layout(local_size_x = 64) in;

layout(constant_id = 0) const bool WINDOWS = false;

layout(push_constant) uniform Params {
    uint particle_count;
    uint tile_shift;   // log2 of a tile's side, texels
    uint tiles_a_row;
    uint tile_count;   // bins of an object
} params;

layout(set = 0, binding = 0) uniform usamplerBuffer particles;  // one an invocation
layout(set = 0, binding = 1) uniform usamplerBuffer motions;  // one an invocation
layout(set = 0, binding = 2) uniform usamplerBuffer strips;
layout(std430, set = 0, binding = 3) buffer Bins { uint bins[]; };
layout(rgba32ui, set = 0, binding = 4) uniform writeonly uimageBuffer sorted_particles;  // one an invocation
layout(rgba32ui, set = 0, binding = 5) uniform writeonly uimageBuffer sorted_motions;  // one an invocation
layout(std430, set = 0, binding = 6) readonly buffer Windows { Window windows[]; };

#include "sort.glsl"

void main() {
    uint i = invocation_index();
    if (i >= params.particle_count) return;
    uvec4 particle = texelFetch(particles, int(i));
    uvec4 motion = texelFetch(motions, int(i));
    uint slot = atomicAdd(bins[bin_of(particle)], 1u);
    if (WINDOWS) slot = ring_slot(windows[0].start, slot, params.particle_count);
    imageStore(sorted_particles, int(slot), particle);
    imageStore(sorted_motions, int(slot), motion);
}
