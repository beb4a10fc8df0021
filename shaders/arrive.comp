// arrive: particles that have won cells move there; they eat, deposit, and are selected where they enter another object. The others stay
// where they are, with a random heading and without a deposit; they eat, if they are on food.
// Reads   claims, wishes, goals, bids, strips, distances, plates.
// Writes  particles and motions in place; deposits, by atomic adds; particle_indices (appended, guarded); what was eaten of meals, by
//         atomic adds; the count of particles that would have won their cells in one more round.
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
    uint salt;                // of the claims
    uint rounds;              // in which cells are won
    uint transfer_capacity;   // of particle_indices
    float transfer_threshold; // world length of signed distance below which a place is covered
    uint fed_steps;           // how long a meal lasts
    uint fed_deposit;         // particles that a fed one counts as where it deposits
} params;

// Each invocation writes where it alone has read before.
PAGED_WRITES(uvec4, 0) particles;  // one an invocation
PAGED_WRITES(uvec4, 1) motions;  // one an invocation
PAGED_READS(uvec4, 2) particles_before;  // one an invocation
PAGED_READS(uvec4, 3) motions_before;  // one an invocation
PAGED_READS(uvec4, 4) wishes;  // one an invocation
PAGED_READS(uvec4, 5) claims;  // one an invocation
READS(uvec4, 6) strips;
READS(uint, 8) goals_texels;
READS(uint, 9) bids_texels;
layout(std430, set = 0, binding = 10) buffer Deposits { uint deposits_block[]; };
CHANGES(uint, 11) deposits_low;
CHANGES(uint, 12) deposits_high;
READS(float, 13) distances;
layout(std430, set = 0, binding = 14) buffer FlowBlock { Flow flow[]; };
layout(std430, set = 0, binding = 15) writeonly buffer ParticleIndices { uint particle_indices[]; };
READS(uint, 16) plates_texels;  // may be absent
layout(std430, set = 0, binding = 17) buffer Meals { Meal meals[]; };  // may be absent

#include "strip_table.glsl"
#include "atlas.glsl"

Particle particle;

vec2 position_of(Particle particle) {
    return atlas_position(atlas_map_of(particle.triangle), particle.u, particle.v);
}

vec2 previous_position() {
    return position_of(particle);
}

#include "arriving.glsl"

uint bid_of(uint cell) {
    return texel_of(bids, cell);
}

#include "rows.glsl"

void main() {
    uint i = invocation_index();
    if (i >= params.particle_count) return;
    // The cell that it would come to, the present cell, the texel there, whether it is alive.
    uvec4 claim = fetch_paged(claims, i);
    if (MORTAL && claim.w == 0u) return;
    // In two lines, because || of constants alone is not understood by every reader of SPIR-V.
    bool has_flags = SELECTS;
    has_flags = has_flags || FOOD;
    uvec4 motion = uvec4(0u);
    if (has_flags) motion = fetch_paged(motions_before, i);
    uint round = won_in(claim.y, claim.x, params.salt, params.rounds + 1u);
    uvec4 moved = fetch_paged(wishes, i);
    if (has_flags) particle = particle_of(fetch_paged(particles_before, i));
    // A step within its own cell needs no claim.
    if (claim.x == claim.y || (round != 0u && round <= params.rounds)) {
        motion.w = arrived_flags(claim.z, motion.w);
        if (SELECTS) motion.w |= selected_flag(position_of(particle_of(moved)), i);
        write_paged(particles, i, moved);
        if (has_flags) write_paged(motions, i, motion);
    } else {
        if (round != 0u) count_one(flow[0].left_over)
        uint flags = STAYED;
        if (FOOD) flags |= fed_flags(texel_at(previous_position(), params.pitch), motion.w);
        vec2 heading = turn_of(random_words(params.seed, moved.w, params.time_step, PURPOSE_REFUSED).x);
        write_paged(motions, i, words_of(Motion(heading.x, heading.y, 0.0, flags)));
    }
}
