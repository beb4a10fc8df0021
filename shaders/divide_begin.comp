// divide_begin: particles are born: the ids of dead particles get the cells of the listed parents, one by one, as long as there are any.
// Each begins in the middle of its cell, with a random heading, and has been hungry for as long as its parent. Where objects have windows,
// one that died on another object changes them as a particle that goes over.
// Reads   parents, births, id_marks, ids_before, population, strips, nests.
// Writes  particles and motions in place, of dead particles; borders, by atomic adds.
// One invocation per particle; those whose ids are not needed return.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "words.glsl"
#include "index.glsl"
#include "tables.glsl"
#include "texels.glsl"
#include "rng.glsl"
#include "ring.glsl"
#include "id_marks.glsl"

layout(local_size_x = 256) in;

// Objects have windows, whose borders are to move.
layout(constant_id = 0) const bool WINDOWS = false;
// Particles die if they have been hungry for long.
layout(constant_id = 23) const bool HUNGER = false;

layout(push_constant) uniform Params {
    uint particle_count;
    uint seed;
    uint time_step;
    uint pitch;  // texels from one atlas row to the next
} params;

PAGED_CHANGES(uvec4, 0) particles;  // one an invocation
PAGED_CHANGES(uvec4, 1) motions;  // one an invocation
READS(uvec4, 2) strips;
// The triangle on which particles are born in a texel.
READS(uint, 3) nests_texels;
READS(uint, 4) parents;
READS(uint, 8) births;  // one an invocation
layout(std430, set = 0, binding = 5) readonly buffer IdMarks { uint id_marks[]; };
layout(std430, set = 0, binding = 6) readonly buffer IdsBefore { uint ids_before[]; };
layout(std430, set = 0, binding = 7) readonly buffer PopulationBlock { Population population[]; };
layout(std430, set = 0, binding = 9) buffer Borders { Border borders[]; };

#include "strip_table.glsl"
#include "atlas.glsl"

// Functions of their own, so that main() stays small: in large functions shaderc looks without end for what `precise` reaches.

// The flags of a particle that is born.
uint flags_of_child(uint parent) {
    uint flags = 0u;
    if (HUNGER) flags = hungry_steps(load_paged(motions, parent).w) << HUNGRY_SHIFT;
    return flags;
}

// A particle that lay on one triangle is born on another.
void change_windows(uint old_triangle, uint new_triangle) {
    uint from = shape_words(old_triangle).w;
    uint to = shape_words(new_triangle).w;
    if (from == to) return;
    atomicAdd(borders[from].left, 1u);
    atomicAdd(borders[to].came, 1u);
}

void main() {
    uint i = invocation_index();
    if (i >= params.particle_count) return;
    uvec4 dead = load_paged(particles, i);
    uint id = dead.w;
    uint word = words_of_ids(params.particle_count) + word_of_id(id);
    uint marks = id_marks[word];
    if ((marks & bit_of_id(id)) == 0u) return;
    uint number = ids_before[word] + marked_below(marks, id);
    if (number >= population[0].born) return;
    uint parent = fetch1(parents, number);
    uint cell = fetch1(births, parent);
    uint triangle = texel_of(nests, cell);
    vec2 corner = vec2(float(cell % params.pitch), float(cell / params.pitch));
    precise vec2 middle = corner + 0.5;
    vec2 weights = weights_at(atlas_map_of(triangle), middle);
    float u = settled(within(weights.x, 0.0, 1.0));
    precise float most = 1.0 - u;
    float v = settled(within(weights.y, 0.0, most));
    vec2 heading = turn_of(random_words(params.seed, id, params.time_step, PURPOSE_POPULATION).w);
    store_paged(particles, i, words_of(Particle(triangle, u, v, id)));
    store_paged(motions, i, words_of(Motion(heading.x, heading.y, 0.0, flags_of_child(parent))));
    if (WINDOWS) change_windows(dead.x, triangle);
}
