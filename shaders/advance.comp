// advance: one step of every particle: walk what is pending, sense, turn, walk, eat, deposit, and select for transfer. With one particle a
// cell wish.comp and arrive.comp take its place.
// Reads   strips, trail and bias (gutters filled), last step's deposits, surroundings; for gravity corners, vertices, poses;
//         distances, across, across_triangles, physarums; scent (gutters filled), plates and meals; for pulses shells, corners, vertices
//         and poses;
//         looks (gutters filled); homes.
// Writes  particles and motions in place; deposits, by atomic adds, so that no order shows; particle_indices (appended,
//         guarded); walkers, walkers_near, walker_count and walker_groups; what was eaten of meals, by atomic adds.
// One invocation per particle.
// A walk that runs out of edge-crossing attempts leaves the rest of its length pending for the next step.
// Overflow: a texel counts each particle at most once, fed ones fed_deposit times; the limits of scenes keep this below 2^32. If
//         particle_indices is full, flow.wanted still counts, and limit_list makes a new list of the selected particles that leave.
// docs/guide.md lists the differences from the agents of Jones (2010).
//
// turning.glsl has the five forms of this shader.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "words.glsl"
#include "index.glsl"
#include "tables.glsl"
#include "append.glsl"

layout(local_size_x = 256) in;

// Unused features of a scene cost nothing: they are compiled out, as are the optional terms of sensing.glsl.
layout(constant_id = 4) const bool BORDER_REFLECTS = true;
// Selects for transfer the particles that enter another object.
layout(constant_id = 6) const bool SELECTS = false;
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
// Particles die if they have been hungry for long.
layout(constant_id = 23) const bool HUNGER = false;

layout(push_constant) uniform Params {
    uint particle_count;
    uint seed;
    uint time_step;
    uint attempts;            // edge crossings that one walk may make, unless objects have their own
    uint pitch;               // texels from one atlas row to the next
    uint transfer_capacity;   // of particle_indices
    float transfer_threshold; // world length of signed distance below which a place is covered
    float deepest;            // world length of signed distance up to which sensors see nothing
    float last_texel;         // column or row
    uint walker_rows;         // rows of groups in the dispatch of listed particles
    uint fed_steps;           // how long a meal lasts
    uint fed_deposit;         // particles that a fed one counts as where it deposits
    float fed_attraction;     // the share of an attraction that a fed one feels
    float outlook_unit;       // texels
    uint shell_count;         // of the shells, those of live pulses
    uint second_look;         // row of the physarums
    float sensor_share;       // one by the number of cells that a sensor reads
    float sensitivity;        // trail units below which a sensor reads nothing
    float random_turn;        // the probability of a turn to any direction
    uint may_turn;            // 0 in the first step of particles that walk before they sense
} params;

// Numbers of bindings have no order: the build takes them from here, by name.
// Each invocation writes where it alone has read before.
PAGED_WRITES(uvec4, 0) particles;  // one an invocation
PAGED_WRITES(uvec4, 1) motions;  // one an invocation
PAGED_READS(uvec4, 21) particles_before;  // one an invocation
PAGED_READS(uvec4, 22) motions_before;  // one an invocation
READS(uvec4, 2) strips;
READS(float, 5) trail_texels;
READS(uint, 6) previous_deposits_texels;
layout(std430, set = 0, binding = 7) buffer Deposits { uint deposits_block[]; };
READS(uint, 8) corners;
READS(uvec4, 9) vertices;
READS(vec4, 10) poses;
READS(float, 11) distances;
layout(std430, set = 0, binding = 13) buffer FlowBlock { Flow flow[]; };
layout(std430, set = 0, binding = 14) writeonly buffer ParticleIndices { uint particle_indices[]; };
layout(std430, set = 0, binding = 15) readonly buffer Physarums { Physarum physarums[]; };
// For each covered texel the place across.
READS(uint, 16) across;
READS(uint, 17) across_triangles;
// The slots of particles whose sensors must walk, of those that are near other objects, and of those that are both; how many
// there are of each.
CHANGES(uint, 19) walkers;
CHANGES(uint, 12) walkers_near;
layout(std430, set = 0, binding = 20) buffer WalkerGroups { DispatchGroups walker_groups[]; };  // may be absent
layout(std430, set = 0, binding = 23) buffer WalkerCount { uint walker_count[]; };
CHANGES(uint, 24) deposits_low;
CHANGES(uint, 25) deposits_high;
// Added to the sensor readings, trail units; far below zero in no-go areas.
READS(float, 26) bias_texels;  // may be absent
// Added to the sensor readings for food and markers, trail units.
READS(float, 27) scent_texels;  // may be absent
// The food that is eaten at a texel, counted from 1; 0 for none.
READS(uint, 28) plates_texels;  // may be absent
layout(std430, set = 0, binding = 29) buffer Meals { Meal meals[]; };  // may be absent
layout(std430, set = 0, binding = 30) readonly buffer Shells { Shell shells[]; };
// Weights of the second look, 0 to 1.
READS(float, 31) looks_texels;  // may be absent
// The cell of each texel: the owned texel that stands for it.
READS(uint, 32) homes_texels;  // may be absent
// Single words take less work to unpack; a view of a texel buffer has too few elements for them in the largest textures.
#ifdef MYXO_CARD
READS(uint, 18) surroundings;  // two texels in a word
#else
READS(uvec2, 18) surroundings;  // four texels in two words
#endif

#include "turning.glsl"
#include "arriving.glsl"

// Writes a particle that has walked; it eats, deposits, and is selected where it enters another object.
void arrives(uint i) {
    if (PAINTED) stay_out_of_no_go_areas();

    w.u = settled(w.u);
    w.v = settled(w.v);
    // A particle that is not near other objects does not enter one. In two lines, because !, && and || of constants alone are more than
    // the reflection of shaders can evaluate.
    bool is_far = ACROSS;
    is_far = is_far && !sees_others();
    uint flags = flags_at(walked_position(w), i, motion.flags, is_far);
    vec2 heading = settled(w.heading);
    // Last: the buffers are those that were read, and a compiler may read again what it takes for unchanged.
    write_paged(particles, i, words_of(Particle(w.triangle, w.u, w.v, particle.id)));
    write_paged(motions, i, words_of(Motion(heading.x, heading.y, settled(min(pending, own.speed)), flags)));
}

void main() {
    uint i = slot_of(invocation_index());
    if (i == NONE || !turns(i)) return;
    walk_step();
    arrives(i);
}
