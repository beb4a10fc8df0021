// arrive: particles that have won cells move there; they eat, deposit, and are selected where they enter another object. The others stay where
// they are, with a random heading and without a deposit; they eat, if they are on food.
// Reads   claims, wishes, wish_motions, cells, strips, distances, plates.
// Writes  particles and motions in place; deposits, by atomic adds; particle_indices (appended, guarded); what was eaten of meals, by atomic
//         adds; the count of particles that stay although their cell was left in the last round.
// One invocation per particle.
// Overflow: a texel counts each particle at most once, fed ones fed_deposit times; the limits of scenes keep this below 2^32. If
//         particle_indices is full, flow.wanted still counts, and limit_list makes a new list of the selected particles that leave.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "words.glsl"
#include "index.glsl"
#include "tables.glsl"
#include "texels.glsl"
#include "counted.glsl"
#include "rng.glsl"
#include "append.glsl"

layout(local_size_x = 256) in;

// Selects for transfer the particles that enter another object.
layout(constant_id = 6) const bool SELECTS = false;
// The scene has food or markers. Without them no particle is fed.
layout(constant_id = 16) const bool FOOD = false;
// Particles may be dead.
layout(constant_id = 22) const bool MORTAL = false;
// Particles die if they have been hungry for long.
layout(constant_id = 23) const bool HUNGER = false;

layout(push_constant) uniform Params {
    uint particle_count;
    uint seed;
    uint time_step;
    uint pitch;               // texels from one atlas row to the next
    uint transfer_capacity;   // of particle_indices
    float transfer_threshold; // world length of signed distance below which a place is covered
    uint fed_steps;           // how long a meal lasts
    uint fed_deposit;         // particles that a fed one counts as where it deposits
} params;

PAGED_CHANGES(uvec4, 0) particles;  // one an invocation
PAGED_CHANGES(uvec4, 1) motions;  // one an invocation
PAGED_READS(uvec4, 2) wishes;  // one an invocation
PAGED_READS(uvec4, 3) wish_motions;  // one an invocation
PAGED_READS(uvec4, 4) claims;  // one an invocation
READS(uvec4, 5) strips;
READS(uint, 6) cells_texels;
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
    // The cell, the present cell, the rank, the texel.
    uvec4 claim = fetch_paged(claims, i);
    if (MORTAL && claim.z == NO_RANK) return;
    Particle moved = particle_of(fetch_paged(wishes, i));
    // In two lines, because || of constants alone is not understood by every reader of SPIR-V.
    bool asks = SELECTS;
    asks = asks || FOOD;
    if (asks) particle = particle_of(load_paged(particles, i));
    uint before = FOOD ? load_paged(motions, i).w : 0u;
    uint word = texel_of(cells, claim.x);
    // A step within its own cell needs no claim.
    if (claim.x == claim.y || is_won(word, claim.z)) {
        Motion motion = motion_of(fetch_paged(wish_motions, i));
        uint flags = arrived_flags(claim.w, before);
        if (SELECTS) flags |= selected_flag(position_of(moved), i);
        store_paged(particles, i, words_of(moved));
        store_paged(motions, i, words_of(Motion(motion.heading_p, motion.heading_h, motion.pending, flags)));
    } else {
        if (word == FREE && claim.z != REFUSED) count_one(flow[0].left_over)
        uint flags = STAYED;
        if (FOOD) flags |= fed_flags(texel_at(previous_position(), params.pitch), before);
        vec2 heading = turn_of(random_words(params.seed, moved.id, params.time_step, PURPOSE_REFUSED).x);
        store_paged(motions, i, words_of(Motion(heading.x, heading.y, 0.0, flags)));
    }
}
