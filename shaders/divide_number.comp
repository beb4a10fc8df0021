// divide_number: numbers the particles that divide by their ids, and the ids of dead particles, so that the first of these goes to the first
// of those, and so on; and counts births and deaths.
// Reads   id_marks.
// Writes  ids_before: the number of marked ids in the words before each word, of either set; population.
// One group: each invocation adds up a run of words, then all add up the runs before theirs.
// Overflow: if fewer ids are left than particles divide, population.refused is increased; divide_list chooses those that divide.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"
#include "counted.glsl"
#include "id_marks.glsl"

layout(local_size_x = 256) in;

layout(push_constant) uniform Params {
    uint particle_count;
} params;

layout(std430, set = 0, binding = 0) readonly buffer IdMarks { uint id_marks[]; };
layout(std430, set = 0, binding = 1) writeonly buffer IdsBefore { uint ids_before[]; };
layout(std430, set = 0, binding = 2) buffer PopulationBlock { Population population[]; };

shared uint dividing_in_runs[gl_WorkGroupSize.x];
shared uint dead_in_runs[gl_WorkGroupSize.x];

void main() {
    uint me = invocation_index();
    if (me >= gl_WorkGroupSize.x) return;
    uint words = words_of_ids(params.particle_count);
    uint run = (words + gl_WorkGroupSize.x - 1u) / gl_WorkGroupSize.x;
    uint first = min(me * run, words);
    uint end = min(first + run, words);
    uint dividing = 0u;
    uint dead = 0u;
    for (uint i = first; i < end; i += 1u) {
        dividing += uint(bitCount(id_marks[i]));
        dead += uint(bitCount(id_marks[words + i]));
    }
    dividing_in_runs[me] = dividing;
    dead_in_runs[me] = dead;
    barrier();
    uint dividing_before = 0u;
    uint dead_before = 0u;
    dividing = 0u;
    dead = 0u;
    for (uint i = 0u; i < gl_WorkGroupSize.x; i += 1u) {
        dividing_before += i < me ? dividing_in_runs[i] : 0u;
        dead_before += i < me ? dead_in_runs[i] : 0u;
        dividing += dividing_in_runs[i];
        dead += dead_in_runs[i];
    }
    for (uint i = first; i < end; i += 1u) {
        ids_before[i] = dividing_before;
        ids_before[words + i] = dead_before;
        dividing_before += uint(bitCount(id_marks[i]));
        dead_before += uint(bitCount(id_marks[words + i]));
    }
    if (me == 0u) {
        Population now = population[0];
        uint survivors = params.particle_count - dead;
        now.died = now.living - survivors;
        now.born = min(dividing, dead);
        now.living = survivors + now.born;
        now.births = counted(now.births, now.born);
        now.deaths = counted(now.deaths, now.died);
        now.refused = counted(now.refused, dividing - now.born);
        population[0] = now;
    }
}
