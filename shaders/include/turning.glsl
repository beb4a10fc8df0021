// turning: a particle walks what is pending, senses and turns; or it is listed for another form of the kernel.
// Twin of `walked` and `turned` in src/sim/step/advance.rs.
// advance.comp and wish.comp include this. They declare the constants BORDER_REFLECTS, OWN_PHYSARUM, PAINTED, FOOD, PULSES, LOOKS and
// MORTAL, their parameters and buffers first.
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
// With one particle a cell the first is called wish. By sensing = "walk", and with gravity, it is the only one. By "auto" the second comes
// first; walk_sensors follows, and where sensors see other objects (ACROSS) advance_near and walk_near. "Read straight" means straight ahead
// in the atlas, where the whole path lies on the chart.
//
// walkers has room for every particle, and each is listed at most once: particles that walk are listed from the front, particles near
// another object from the back. walkers_near lists particles that are both; with one object there are none.

#ifndef MYXO_TURNING
#define MYXO_TURNING

// Sensors see other objects where these cover the surface.
layout(constant_id = 10) const bool ACROSS = false;
layout(constant_id = 11) const uint SENSING = 0u;
// Where both sides read more than the middle, a particle turns to either by chance.
layout(constant_id = 20) const bool RANDOM_TIES = false;
// Some particles turn to any direction, by chance.
layout(constant_id = 21) const bool RANDOM_TURNS = false;

const uint SENSORS_WALK = 0u;
// Sensors go straight ahead in the atlas; particles whose sensors cannot are listed.
const uint SENSORS_STRAIGHT = 1u;
// Listed particles.
const uint SENSORS_WALK_LISTED = 2u;
// Particles whose sensors go straight ahead, but which are listed because they are near other objects.
const uint SENSORS_STRAIGHT_LISTED = 3u;
// Particles which are listed because their sensors must walk, and which are near other objects.
const uint SENSORS_WALK_NEAR = 4u;

#include "rng.glsl"
#include "ring.glsl"
#include "motor.glsl"
#include "sensing.glsl"
#include "walkers.glsl"

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

// Reads a particle, walks what is pending, senses and turns. False if the particle is dead, or is listed for another form instead.
bool turns(uint i) {
    particle = particle_of(fetch_paged(particles_before, i));
    motion = motion_of(fetch_paged(motions_before, i));
    if (MORTAL && (motion.flags & DEAD) != 0u) return false;
    fed = FOOD ? motion.flags >> FED_SHIFT : 0u;
    take_own_parameters();
    own_appetite = fed == 0u ? 1.0 : params.fed_attraction;

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
    if (params.may_turn != 0u) w.heading = heading;
    return true;
}

#endif
