// divide_settle: of the particles that claim one cell to divide into, the one with the lowest rank gets it, and the others do not divide.
// Reads   particles, nursery.
// Writes  births: the claims of the others are taken back; id_marks: the ids of particles that divide, by atomic ors.
// One invocation per particle.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"
#include "tables.glsl"
#include "texels.glsl"
#include "claims.glsl"
#include "id_marks.glsl"

layout(local_size_x = 256) in;

layout(push_constant) uniform Params {
    uint particle_count;
    uint salt;  // of the step
} params;

PAGED_READS(uvec4, 0) particles;  // one an invocation
READS(uint, 1) nursery_texels;
CHANGES(uint, 2) births;  // one an invocation
layout(std430, set = 0, binding = 3) buffer IdMarks { uint id_marks[]; };

void main() {
    uint i = invocation_index();
    if (i >= params.particle_count) return;
    uint cell = load1(births, i);
    if (cell == NONE) return;
    uint id = fetch_paged(particles, i).w;
    if (texel_of(nursery, cell) == rank_of(id, params.salt)) {
        atomicOr(id_marks[word_of_id(id)], bit_of_id(id));
    } else {
        store1(births, i, NONE);
    }
}
