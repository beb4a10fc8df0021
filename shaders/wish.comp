// wish: with one particle a cell, every particle takes its present cell, walks what is pending, senses, turns, walks, and claims the cell
// there.
// Reads   as advance.comp: particles, strips, trail and bias (gutters filled), last step's deposits, surroundings; distances, across,
//         across_triangles, physarums; scent and looks (gutters filled); for gravity and pulses corners, vertices and poses; shells; homes.
// Writes  wishes: the particle where it would come to; motions in place: as it would be there; claims: the cell there, the present cell,
//         the texel there, and whether it is alive; bids by atomic minima, and goals, too, where cells may be shared, so that no order
//         shows; walkers, walkers_near, walker_count and walker_groups.
// One invocation per particle.
// A walk that runs out of edge-crossing attempts leaves the rest of its length pending for the next step.
// Overflow: cannot happen; every list has room for all particles.
// turning.glsl has the five forms of this shader.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "words.glsl"
#include "index.glsl"
#include "tables.glsl"
#include "texels.glsl"
#include "append.glsl"

layout(local_size_x = 256) in;

layout(constant_id = 4) const bool BORDER_REFLECTS = true;
// Some object has its own parameters for the particles on it.
layout(constant_id = 9) const bool OWN_PHYSARUM = false;
// The bias was painted: places attract, repel or may not be entered.
layout(constant_id = 15) const bool PAINTED = false;
// The scene has food or markers. Without them no particle is fed.
layout(constant_id = 16) const bool FOOD = false;
// Pulses are live.
layout(constant_id = 17) const bool PULSES = false;
// A second look was painted, and there is one.
layout(constant_id = 18) const bool LOOKS = false;
// Particles may be dead.
layout(constant_id = 22) const bool MORTAL = false;
// No cell has several particles.
layout(constant_id = 24) const bool APART = false;

layout(push_constant) uniform Params {
    uint particle_count;
    uint seed;
    uint time_step;
    uint salt;                // of the step
    uint attempts;            // edge crossings that one walk may make, unless objects have their own
    uint pitch;               // texels from one atlas row to the next
    float transfer_threshold; // world length of signed distance below which a place is covered
    float deepest;            // world length of signed distance up to which sensors see nothing
    float last_texel;         // column or row
    uint walker_rows;         // rows of groups in the dispatch of listed particles
    float fed_attraction;     // the share of an attraction that a fed one feels
    float outlook_unit;       // texels
    uint shell_count;         // of the shells, those of live pulses
    uint second_look;         // row of the physarums
    float sensor_share;       // one by the number of cells that a sensor reads
    float sensitivity;        // trail units below which a sensor reads nothing
    float random_turn;        // the probability of a turn to any direction
    uint may_turn;            // 0 in the first step of particles that walk before they sense
} params;

// What is also in advance.comp is explained there. Each invocation writes where it alone has read before.
PAGED_READS(uvec4, 0) particles_before;  // one an invocation
PAGED_WRITES(uvec4, 1) motions;  // one an invocation
PAGED_READS(uvec4, 2) motions_before;  // one an invocation
PAGED_WRITES(uvec4, 3) wishes;  // one an invocation
PAGED_WRITES(uvec4, 4) claims;  // one an invocation
READS(uvec4, 5) strips;
layout(std430, set = 0, binding = 6) readonly buffer Physarums { Physarum physarums[]; };
READS(uint, 7) homes_texels;
layout(std430, set = 0, binding = 8) buffer Goals { uint goals_block[]; };
CHANGES(uint, 9) goals_low;
CHANGES(uint, 10) goals_high;
layout(std430, set = 0, binding = 11) buffer Bids { uint bids_block[]; };
CHANGES(uint, 12) bids_low;
CHANGES(uint, 13) bids_high;
READS(float, 14) bias_texels;  // may be absent
READS(float, 15) looks_texels;  // may be absent
layout(std430, set = 0, binding = 16) readonly buffer Shells { Shell shells[]; };
READS(uint, 17) corners;
READS(uvec4, 18) vertices;
READS(vec4, 19) poses;
READS(float, 20) trail_texels;
READS(uint, 21) previous_deposits_texels;
READS(float, 22) distances;
READS(uint, 23) across;
READS(uint, 24) across_triangles;
READS(float, 25) scent_texels;  // may be absent
CHANGES(uint, 26) walkers;
CHANGES(uint, 27) walkers_near;
layout(std430, set = 0, binding = 28) buffer WalkerGroups { DispatchGroups walker_groups[]; };  // may be absent
layout(std430, set = 0, binding = 29) buffer WalkerCount { uint walker_count[]; };
#ifdef MYXO_CARD
READS(uint, 30) surroundings;  // two texels in a word
#else
READS(uvec2, 30) surroundings;  // four texels in two words
#endif

#include "turning.glsl"
#include "claims.glsl"

// Takes the cell that a particle is in. Where nothing else can be there, a plain store will do, which is faster. Otherwise all but the
// first one mark the cell, by the lowest of all words.
void take(uint cell, uint goal) {
    if (APART) {
        put_texel(goals, cell, goal_word(goal))
        return;
    }
    lower_texel(goals, cell, goal_word(goal), before)
    if (before != FREE) {
        lower_texel(goals, cell, SHARED, marked)
    }
}

// Writes where a particle that has walked would come to, and claims the cell there.
void wishes_for(uint i) {
    if (PAINTED) stay_out_of_no_go_areas();
    w.u = settled(w.u);
    w.v = settled(w.v);
    vec2 heading = settled(w.heading);
    // Where particles may be fed, `arrive` needs to see what they were.
    uint flags = FOOD ? motion.flags : 0u;
    write_paged(wishes, i, words_of(Particle(w.triangle, w.u, w.v, particle.id)));
    write_paged(motions, i, words_of(Motion(heading.x, heading.y, settled(min(pending, own.speed)), flags)));
    uint texel = texel_at(walked_position(w), params.pitch);
    uint goal = texel_of(homes, texel);
    uint cell = texel_of(homes, texel_at(previous_position(), params.pitch));
    write_paged(claims, i, uvec4(goal, cell, texel, 1u));
    take(cell, goal);
    // A step within its own cell needs no claim.
    if (goal != cell) {
        uint claim = claim_of(rank_of(cell, params.salt), rank_of(goal, params.salt));
        lower_texel(bids, goal, claim, before)
    }
}

void main() {
    uint i = slot_of(invocation_index());
    if (i == NONE) return;
    if (turns(i)) {
        walk_step();
        wishes_for(i);
    } else if (MORTAL && (motion.flags & DEAD) != 0u) {
        write_paged(claims, i, uvec4(0u));
    }
}
