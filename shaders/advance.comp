// advance: one step of every particle: walk what is pending, sense, turn, walk, eat, deposit, and select for transfer; or one of the
// two stages of it, by scenes with rules that part them.
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
// One shader, five forms (SENSING), because devices that run both sides of every branch would pay for all of them for each
// particle. Each form is a pipeline of its own, by the name that timers show:
//
//   pipeline      SENSING                  particles                                 sensors        sees other objects
//   advance       SENSORS_WALK             all                                       walk           if ACROSS
//   advance       SENSORS_STRAIGHT         all; lists those for other forms          read straight  no
//   walk_sensors  SENSORS_WALK_LISTED      listed: walk pending or path not clear    walk           no
//   advance_near  SENSORS_STRAIGHT_LISTED  listed: near another object               read straight  if ACROSS
//   walk_near     SENSORS_WALK_NEAR        listed: both                              walk           if ACROSS
//
// By sensing = "walk", and with gravity, the first form is the only one. By "auto" the second comes first; walk_sensors follows,
// and where sensors see other objects (ACROSS) advance_near and walk_near. "Read straight" means straight ahead in the atlas, where the
// whole path lies on the chart.
//
// If motor and sensory stage are parted (STAGE), the forms above only sense and turn, and the first is called turn; SENSORS_WALK without the
// sensory stage is called walk. With one particle a cell the motor stage is wish.comp and the kernels behind it.
//
// walkers has room for every particle, and each is listed at most once: particles that walk are listed from the front, particles near
// another object from the back. walkers_near lists particles that are both; with one object there are none.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "words.glsl"
#include "index.glsl"
#include "tables.glsl"
#include "rng.glsl"
#include "ring.glsl"
#include "append.glsl"

layout(local_size_x = 256) in;

// Unused features of a scene cost nothing: they are compiled out, as are the optional terms of sensing.glsl.
layout(constant_id = 4) const bool BORDER_REFLECTS = true;
// Selects for transfer the particles that enter another object.
layout(constant_id = 6) const bool SELECTS = false;
// Some object has its own parameters for the particles on it.
layout(constant_id = 9) const bool OWN_PHYSARUM = false;
// Sensors see other objects where these cover the surface.
layout(constant_id = 10) const bool ACROSS = false;
layout(constant_id = 11) const uint SENSING = 0u;
// The bias was painted: places attract, repel or may not be entered.
layout(constant_id = 15) const bool PAINTED = false;
// The scene has food or markers. Without them no particle is fed.
layout(constant_id = 16) const bool FOOD = false;
// Pulses are live.
layout(constant_id = 17) const bool PULSES = false;
// A second look was painted, and there is one.
layout(constant_id = 18) const bool LOOKS = false;
// What a particle does here.
layout(constant_id = 19) const uint STAGE = 0u;
// Where both sides read more than the middle, a particle turns to either by chance.
layout(constant_id = 20) const bool RANDOM_TIES = false;
// Some particles turn to any direction, by chance.
layout(constant_id = 21) const bool RANDOM_TURNS = false;
// Particles may be dead.
layout(constant_id = 22) const bool MORTAL = false;
// Particles die if they have been hungry for long.
layout(constant_id = 23) const bool HUNGER = false;

// Everything.
const uint STAGE_WHOLE = 0u;
// It senses and turns. What is pending stays so.
const uint STAGE_SENSORY = 1u;
// It walks and arrives.
const uint STAGE_MOTOR = 2u;

const uint SENSORS_WALK = 0u;
// Sensors go straight ahead in the atlas; particles whose sensors cannot are listed.
const uint SENSORS_STRAIGHT = 1u;
// Listed particles.
const uint SENSORS_WALK_LISTED = 2u;
// Particles whose sensors go straight ahead, but which are listed because they are near other objects.
const uint SENSORS_STRAIGHT_LISTED = 3u;
// Particles which are listed because their sensors must walk, and which are near other objects.
const uint SENSORS_WALK_NEAR = 4u;

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

#include "motor.glsl"
#include "sensing.glsl"
#include "walkers.glsl"
#include "arriving.glsl"

uint fed;

// The slot of an invocation's particle; NONE if it has none.
uint slot_of(uint i) {
    if (SENSING == SENSORS_WALK_LISTED) return i < walker_count[WALKING] ? load1(walkers, walker_slot(WALKING, i)) : NONE;
    if (SENSING == SENSORS_WALK_NEAR) return i < walker_count[WALKING_NEARBY] ? load1(walkers_near, i) : NONE;
    if (SENSING == SENSORS_STRAIGHT_LISTED) return i < walker_count[NEARBY] ? load1(walkers, walker_slot(NEARBY, i)) : NONE;
    return i < params.particle_count ? i : NONE;
}

// The ways of the three sensors straight ahead, texels.
struct Ways { vec2 left; vec2 middle; vec2 right; };

// The list for a particle that another form takes, or NONE.
uint list_of(vec2 from, Ways ways) {
    uint here = around(from);
    uint on_left = around_end(from, ways.left);
    uint ahead = around_end(from, ways.middle);
    uint on_right = around_end(from, ways.right);
    bool all_clear = is_clear(ways.left, params.outlook_unit, here, on_left)
        && is_clear(ways.middle, params.outlook_unit, here, ahead)
        && is_clear(ways.right, params.outlook_unit, here, on_right);
    bool walks = motion.pending > 0.0 || !all_clear;
    uint meets = (on_left | ahead | on_right) & COVERED;
    // The end of the walk is not known yet.
    bool is_near = ACROSS && ((here & (walks ? IN_SIGHT : NEAR)) | meets) != 0u;
    return walks ? (is_near ? WALKING_NEARBY : WALKING) : is_near ? NEARBY : NONE;
}

// Reads a particle, walks what is pending unless that comes with the step, senses and turns. False if the particle is dead, or is listed for
// another form instead.
bool turns(uint i) {
    particle = particle_of(fetch_paged(particles_before, i));
    motion = motion_of(fetch_paged(motions_before, i));
    if (MORTAL && (motion.flags & DEAD) != 0u) return false;
    fed = FOOD ? motion.flags >> FED_SHIFT : 0u;
    take_own_parameters();
    own_appetite = fed == 0u ? 1.0 : params.fed_attraction;

    if (STAGE == STAGE_MOTOR) {
        stand();
        return true;
    }
    float kept = motion.pending;
    if (STAGE == STAGE_SENSORY) motion.pending = 0.0;

    vec2 heading = vec2(motion.heading_p, motion.heading_h);
    vec2 from = vec2(0.0);
    Ways ways = Ways(vec2(0.0), vec2(0.0), vec2(0.0));
    bool goes_straight = SENSING == SENSORS_STRAIGHT;
    goes_straight = goes_straight || SENSING == SENSORS_STRAIGHT_LISTED;
    if (goes_straight) {
        from = atlas_position(atlas_map_of(particle.triangle), particle.u, particle.v);
        mat2 texels_of_axes = texels_of_frame(particle.triangle);
        ways.left = straight_way(texels_of_axes, left_of(heading));
        ways.middle = straight_way(texels_of_axes, heading);
        ways.right = straight_way(texels_of_axes, right_of(heading));
    }
    uint list = SENSING == SENSORS_STRAIGHT ? list_of(from, ways) : NONE;
    if (list != NONE) {
        enlist(list, i);
        return false;
    }

    if (goes_straight) {
        stand();
    } else {
        walk_pending();
        heading = w.heading;
    }

    bool from_open = sees_others() && distances_of(texel_at(walked_position(w), params.pitch)) >= params.transfer_threshold;
    vec3 value;
    if (goes_straight) {
        // With gravity all sensors walk; only then the triangle is needed.
        value.x = sensed_at(from + ways.left, NONE, vec2(0.0), from_open);
        value.y = sensed_at(from + ways.middle, NONE, vec2(0.0), from_open);
        value.z = sensed_at(from + ways.right, NONE, vec2(0.0), from_open);
    } else {
        value.x = sensed_by_walking(w, left_of(heading), from_open);
        value.y = sensed_by_walking(w, heading, from_open);
        value.z = sensed_by_walking(w, right_of(heading), from_open);
    }
    if (SENSOR_NOISE) {
        vec3 noise = normals(random_words(params.seed, particle.id, params.time_step, PURPOSE_SENSOR_NOISE));
        precise vec3 noisy = value + own.sensor_noise * noise;
        value = noisy;
    }
    float left = value.x;
    float middle = value.y;
    float right = value.z;
    if (RANDOM_TIES) {
        bool is_tie = middle < left && middle < right;
        bool keeps_on = (middle > left && middle > right) || left == right;
        bool goes_left = is_tie ? random_words(params.seed, particle.id, params.time_step, PURPOSE_TIE).x < 0x80000000u : left > right;
        if (is_tie || !keeps_on) heading = rotated(heading, own.rotation_cos, goes_left ? own.rotation_sin : -own.rotation_sin);
    } else if ((middle < left || middle < right) && left != right) {
        heading = rotated(heading, own.rotation_cos, left > right ? own.rotation_sin : -own.rotation_sin);
    }
    if (RANDOM_TURNS) {
        uvec4 words = random_words(params.seed, particle.id, params.time_step, PURPOSE_TURN);
        if (unit_float(words.x) < params.random_turn) heading = turn_of(words.y);
    }
    w.heading = heading;
    motion.pending = kept;
    return true;
}

// Writes a particle that has walked; it eats, deposits, and is selected where it enters another object.
void arrives(uint i) {
    if (PAINTED) stay_out_of_no_go_areas();

    w.u = settled(w.u);
    w.v = settled(w.v);
    write_paged(particles, i, words_of(Particle(w.triangle, w.u, w.v, particle.id)));
    // A particle that is not near other objects does not enter one. In two lines, because !, && and || of constants alone are more than
    // the reflection of shaders can evaluate.
    bool is_far = ACROSS;
    is_far = is_far && !sees_others();
    uint flags = flags_at(walked_position(w), i, motion.flags, is_far);
    vec2 heading = settled(w.heading);
    write_paged(motions, i, words_of(Motion(heading.x, heading.y, settled(min(pending, own.speed)), flags)));
}

void main() {
    uint i = slot_of(invocation_index());
    if (i == NONE || !turns(i)) return;
    if (STAGE == STAGE_SENSORY) {
        vec2 heading = settled(w.heading);
        write_paged(motions, i, words_of(Motion(heading.x, heading.y, motion.pending, motion.flags)));
        return;
    }
    walk_step(STAGE == STAGE_MOTOR ? motion.pending : 0.0);
    arrives(i);
}
