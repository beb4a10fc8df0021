// settle: the particles that have won the cells which they claimed move there; they eat, deposit, and are selected where they enter another
// object. A cell that is left is free from the next round on.
// Reads   strips, distances, plates.
// Writes  particles and motions of those that move, and their wishes, which are done; cells: where one moves to and where it leaves; deposits,
//         by atomic adds; particle_indices (appended, guarded); what was eaten of meals, by atomic adds.
// One invocation per particle. A cell's word is its winner's rank, or says that it is taken. Meanwhile only the winner changes it, and only a
// particle that leaves changes another one: whatever others read there, it is not their rank.
// Overflow: a texel counts each particle at most once, fed ones fed_deposit times; the limits of scenes keep this below 2^32. If
//         particle_indices is full, flow.wanted still counts, and limit_list makes a new list of the selected particles that leave.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "words.glsl"
#include "index.glsl"
#include "tables.glsl"
#include "texels.glsl"
#include "append.glsl"

layout(local_size_x = 256) in;

// Selects for transfer the particles that enter another object.
layout(constant_id = 6) const bool SELECTS = false;
// The scene has food or markers. Without them no particle is fed.
layout(constant_id = 16) const bool FOOD = false;

layout(push_constant) uniform Params {
    uint particle_count;
    uint salt;                // of the step
    uint pitch;               // texels from one atlas row to the next
    uint transfer_capacity;   // of particle_indices
    float transfer_threshold; // world length of signed distance below which a place is covered
    uint fed_steps;           // how long a meal lasts
    uint fed_deposit;         // particles that a fed one counts as where it deposits
} params;

PAGED_CHANGES(uvec4, 0) particles;  // one an invocation
PAGED_CHANGES(uvec4, 1) motions;  // one an invocation
PAGED_CHANGES(uvec4, 2) wishes;  // one an invocation
PAGED_READS(uvec4, 3) wish_motions;  // one an invocation
READS(uvec4, 4) strips;
layout(std430, set = 0, binding = 5) buffer Cells { uint cells_block[]; };
CHANGES(uint, 6) cells_low;
CHANGES(uint, 7) cells_high;
layout(std430, set = 0, binding = 8) buffer Deposits { uint deposits_block[]; };
CHANGES(uint, 9) deposits_low;
CHANGES(uint, 10) deposits_high;
READS(float, 11) distances;
layout(std430, set = 0, binding = 12) buffer FlowBlock { Flow flow[]; };
layout(std430, set = 0, binding = 13) writeonly buffer ParticleIndices { uint particle_indices[]; };
READS(uint, 14) plates_texels;  // may be absent
layout(std430, set = 0, binding = 15) buffer Meals { Meal meals[]; };  // may be absent

#include "strip_table.glsl"
#include "atlas.glsl"
#include "claims.glsl"

Particle particle;

vec2 position_of(Particle particle) {
    return atlas_position(atlas_map_of(particle.triangle), particle.u, particle.v);
}

vec2 previous_position() {
    return position_of(particle);
}

#include "arriving.glsl"

void main() {
    uint i = invocation_index();
    if (i >= params.particle_count) return;
    Particle wish = particle_of(load_paged(wishes, i));
    uint cell = wish.id;
    if (cell == NONE) return;
    particle = particle_of(load_paged(particles, i));
    Motion motion = motion_of(fetch_paged(wish_motions, i));
    uint own_cell = motion.flags;
    // A step within its own cell needs no claim.
    if (cell != own_cell) {
        lower_texel(cells, cell, FREE, winner)
        if (winner != rank_of(particle.id, params.salt)) return;
        replace_texel(cells, cell, TAKEN)
        lower_texel(cells, own_cell, FREE, left)
        if (left == TAKEN) replace_texel(cells, own_cell, FREE)
    }
    Particle moved = Particle(wish.triangle, wish.u, wish.v, particle.id);
    uint fed = FOOD ? load_paged(motions, i).w >> FED_SHIFT : 0u;
    uint flags = flags_at(position_of(moved), i, fed, false);
    store_paged(particles, i, words_of(moved));
    store_paged(motions, i, words_of(Motion(motion.heading_p, motion.heading_h, motion.pending, flags)));
    store_paged(wishes, i, words_of(Particle(wish.triangle, wish.u, wish.v, NONE)));
}
