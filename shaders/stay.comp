// stay: particles that have won no cell stay where they are, with a random heading and without a deposit. They eat, if they are on food.
// Reads   particles, wishes, cells, strips, plates.
// Writes  motions of those that stay; what was eaten of meals, by atomic adds; the count of those whose cell was left in the last round.
// One invocation per particle.
// Overflow: cannot happen; counters stop at the largest number.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "words.glsl"
#include "index.glsl"
#include "tables.glsl"
#include "texels.glsl"
#include "counted.glsl"
#include "rng.glsl"
#include "ring.glsl"
#include "strict.glsl"

layout(local_size_x = 256) in;

// The scene has food or markers. Without them no particle is fed.
layout(constant_id = 16) const bool FOOD = false;

layout(push_constant) uniform Params {
    uint particle_count;
    uint seed;
    uint time_step;
    uint pitch;      // texels from one atlas row to the next
    uint fed_steps;  // how long a meal lasts
} params;

PAGED_READS(uvec4, 0) particles;  // one an invocation
PAGED_CHANGES(uvec4, 1) motions;  // one an invocation
PAGED_READS(uvec4, 2) wishes;  // one an invocation
READS(uint, 3) cells_texels;
READS(uvec4, 4) strips;
layout(std430, set = 0, binding = 5) buffer FlowBlock { Flow flow[]; };
READS(uint, 6) plates_texels;  // may be absent
layout(std430, set = 0, binding = 7) buffer Meals { Meal meals[]; };  // may be absent

#include "strip_table.glsl"
#include "atlas.glsl"
#include "claims.glsl"
#include "eating.glsl"

void main() {
    uint i = invocation_index();
    if (i >= params.particle_count) return;
    uint cell = fetch_paged(wishes, i).w;
    if (cell == NONE) return;
    if (texel_of(cells, cell) == FREE) count_one(flow[0].left_over)
    Particle particle = particle_of(fetch_paged(particles, i));
    uint flags = STAYED;
    if (FOOD) {
        vec2 position = atlas_position(atlas_map_of(particle.triangle), particle.u, particle.v);
        uint fed = fed_at(texel_at(position, params.pitch), load_paged(motions, i).w >> FED_SHIFT);
        flags |= fed << FED_SHIFT;
    }
    vec2 heading = turn_of(random_words(params.seed, particle.id, params.time_step, PURPOSE_REFUSED).x);
    store_paged(motions, i, words_of(Motion(heading.x, heading.y, 0.0, flags)));
}
