// motor: the walk of a particle in a step. Twin of `walk_pending` and `walk_step` in src/sim/step/advance.rs.
// The includer declares the constants OWN_PHYSARUM, LOOKS, PULSES and BORDER_REFLECTS, the parameters and the buffers that follow here.

#ifndef MYXO_MOTOR
#define MYXO_MOTOR

#include "strip.glsl"
#include "atlas.glsl"
#include "texels.glsl"
#include "no_go.glsl"
#include "frame.glsl"
#include "pose_table.glsl"
#include "shells.glsl"
#include "looks.glsl"

// A particle on its way through the step.
Particle particle;
Motion motion;
StripWalk w;
float pending;

// Parameters of the particles on this particle's object.
Physarum own;

// The atlas position of a walk.
vec2 walked_position(StripWalk w) {
    return atlas_position(atlas_map_of(w.triangle), w.u, w.v);
}

// Where the step began.
vec2 previous_position() {
    return atlas_position(atlas_map_of(particle.triangle), particle.u, particle.v);
}

// Edge crossings that one walk may make.
uint own_attempts() {
    return OWN_PHYSARUM ? own.attempts : params.attempts;
}

void take_own_parameters() {
    // If no object has its own parameters, all particles read one row.
    own = physarums[OWN_PHYSARUM ? shape_words(particle.triangle).w : 0u];
    if (LOOKS) {
        own = mixed_look(own, physarums[params.second_look], texel_of(looks, texel_at(previous_position(), params.pitch)));
    }
}

// Begins the walk where the particle is.
void stand() {
    vec2 heading = vec2(motion.heading_p, motion.heading_h);
    w = StripWalk(particle.triangle, particle.u, particle.v, heading, motion.pending, WALK_DONE);
    pending = 0.0;
}

void walk_pending() {
    stand();
    if (motion.pending > 0.0) {
        walk_strip(w, own_attempts(), BORDER_REFLECTS);
        pending = w.status == WALK_OUT_OF_ATTEMPTS ? w.remaining : 0.0;
    }
}

void walk_step() {
    w.remaining = own.speed;
    if (PULSES) sweep(w);
    walk_strip(w, own_attempts(), BORDER_REFLECTS);
    precise float left_over = pending + (w.status == WALK_OUT_OF_ATTEMPTS ? w.remaining : 0.0);
    pending = left_over;
}

// Particles outside of a no-go area turn round at it. Particles inside may leave.
void stay_out_of_no_go_areas() {
    bool was_allowed = texel_of(bias, texel_at(previous_position(), params.pitch)) >= NO_GO;
    if (was_allowed && texel_of(bias, texel_at(walked_position(w), params.pitch)) < NO_GO) {
        w.triangle = particle.triangle;
        w.u = particle.u;
        w.v = particle.v;
        w.heading = -vec2(motion.heading_p, motion.heading_h);
        pending = 0.0;
    }
}

#endif
