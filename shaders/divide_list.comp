// divide_list: lists the cells that particles divide into, by the number of the particle among those that divide.
// Reads   particles, births, id_marks, ids_before, population.
// Writes  cradles.
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
} params;

PAGED_READS(uvec4, 0) particles;  // one an invocation
READS(uint, 1) births;  // one an invocation
layout(std430, set = 0, binding = 2) readonly buffer IdMarks { uint id_marks[]; };
layout(std430, set = 0, binding = 3) readonly buffer IdsBefore { uint ids_before[]; };
layout(std430, set = 0, binding = 4) readonly buffer PopulationBlock { Population population[]; };
WRITES(uint, 5) cradles;

void main() {
    uint i = invocation_index();
    if (i >= params.particle_count) return;
    uint cell = fetch1(births, i);
    if (cell == NONE) return;
    uint id = fetch_paged(particles, i).w;
    uint word = word_of_id(id);
    uint number = ids_before[word] + marked_below(id_marks[word], id);
    if (number < population[0].born) store1(cradles, number, cell);
}
