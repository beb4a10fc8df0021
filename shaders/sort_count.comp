// sort_count: counts the particles in each tile of the atlas.
// Reads   particles, strips.
// Writes  bins, by atomic adds: they are zero before.
// One invocation a particle.
// Overflow: cannot happen; there is a bin for every tile of every object.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"

layout(local_size_x = 64) in;

// Each object's particles stay together.
layout(constant_id = 0) const bool WINDOWS = false;

layout(push_constant) uniform Params {
    uint particle_count;
    uint tile_shift;   // log2 of a tile's side, texels
    uint tiles_a_row;
    uint tile_count;   // bins of an object
} params;

layout(set = 0, binding = 0) uniform usamplerBuffer particles;  // one an invocation
layout(set = 0, binding = 1) uniform usamplerBuffer strips;
layout(std430, set = 0, binding = 2) buffer Bins { uint bins[]; };

#include "sort.glsl"

void main() {
    uint i = invocation_index();
    if (i >= params.particle_count) return;
    atomicAdd(bins[bin_of(texelFetch(particles, int(i)))], 1u);
}
