// count_cells: counts the particles in each cell.
// Reads   particles, motions, strips, homes.
// Writes  occupants, by atomic adds: they are zero before.
// One invocation per particle; dead ones are nowhere.
// Overflow: cannot happen; each particle counts once.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "words.glsl"
#include "index.glsl"
#include "tables.glsl"
#include "texels.glsl"
#include "ring.glsl"

layout(local_size_x = 256) in;

layout(push_constant) uniform Params {
    uint particle_count;
    uint pitch;  // texels from one atlas row to the next
} params;

PAGED_READS(uvec4, 0) particles;  // one an invocation
PAGED_READS(uvec4, 1) motions;  // one an invocation
READS(uvec4, 2) strips;
READS(uint, 3) homes_texels;
layout(std430, set = 0, binding = 4) buffer Occupants { uint occupants_block[]; };
CHANGES(uint, 5) occupants_low;
CHANGES(uint, 6) occupants_high;

#include "strip_table.glsl"
#include "atlas.glsl"

void main() {
    uint i = invocation_index();
    if (i >= params.particle_count) return;
    if ((fetch_paged(motions, i).w & DEAD) != 0u) return;
    Particle particle = particle_of(fetch_paged(particles, i));
    vec2 position = atlas_position(atlas_map_of(particle.triangle), particle.u, particle.v);
    uint cell = texel_of(homes, texel_at(position, params.pitch));
    add_to_texel(occupants, cell, 1u)
}
