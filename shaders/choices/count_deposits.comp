// count_deposits: counts particles in texels, as `advance` does.
// Reads   particles, strips.
// Writes  deposits, by atomic adds, so that no order shows.
// One invocation per particle.
// Overflow: a texel counts each particle at most once.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "words.glsl"
#include "index.glsl"
#include "atlas.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Params {
    uint particle_count;
    uint pitch;  // texels from one atlas row to the next
} params;

layout(set = 0, binding = 0) uniform usamplerBuffer particles;
layout(set = 0, binding = 1) uniform usamplerBuffer strips;
layout(std430, set = 0, binding = 2) buffer Deposits { uint deposits[]; };

#include "strip.glsl"

void main() {
    uint i = invocation_index();
    if (i >= params.particle_count) return;
    Particle particle = particle_of(texelFetch(particles, int(i)));
    vec2 position = atlas_position(atlas_map_of(particle.triangle), particle.u, particle.v);
    atomicAdd(deposits[texel_at(position, params.pitch)], 1u);
}
