// divide_list: lists the particles that divide, by the number of each among these. If ids are left for some of them only, numbers begin at
// a random one in each step, so that low ids do not always come first.
// Reads   particles, births, id_marks, ids_before, population.
// Writes  parents: their slots.
// One invocation per particle.
// Overflow: particles for which there is no id are not listed.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"
#include "tables.glsl"
#include "id_marks.glsl"

layout(local_size_x = 256) in;

layout(push_constant) uniform Params {
    uint particle_count;
    uint offset;  // a random number of the step; its remainder is the number of the particle at which numbers begin then
} params;

PAGED_READS(uvec4, 0) particles;  // one an invocation
READS(uint, 1) births;  // one an invocation
layout(std430, set = 0, binding = 2) readonly buffer IdMarks { uint id_marks[]; };
layout(std430, set = 0, binding = 3) readonly buffer IdsBefore { uint ids_before[]; };
layout(std430, set = 0, binding = 4) readonly buffer PopulationBlock { Population population[]; };
WRITES(uint, 5) parents;

void main() {
    uint i = invocation_index();
    if (i >= params.particle_count) return;
    if (fetch1(births, i) == NONE) return;
    uint id = fetch_paged(particles, i).w;
    uint word = word_of_id(id);
    uint number = ids_before[word] + marked_below(id_marks[word], id);
    uint last = words_of_ids(params.particle_count) - 1u;
    uint dividing = ids_before[last] + uint(bitCount(id_marks[last]));
    if (dividing > population[0].born) number = (number + (dividing - params.offset % dividing)) % dividing;
    if (number < population[0].born) store1(parents, number, i);
}
