// shells: pulses sweep particles along in shells in world space. Twin of src/sim/pulse.rs, which says how.
// The includer declares `shells`, `params.shell_count`, and what frame.glsl and pose_table.glsl need.

#ifndef MYXO_SHELLS
#define MYXO_SHELLS

#include "frame.glsl"
#include "spaces.glsl"
#include "strip.glsl"

// Where the back of a shell begins, half widths from its middle.
const float BACK = -0.25;

// Turns a particle and lengthens its step in each shell that it is in.
void sweep(inout StripWalk w) {
    uvec4 shape = shape_words(w.triangle);
    Pose pose = pose_of(shape.w);
    Frame frame = frame_of(w.triangle);
    vec3 place = position_on(shape, frame, w.u, w.v);
    for (uint k = 0u; k < params.shell_count; k++) {
        Shell shell = shells[k];
        precise vec3 away = place - place_in_object(pose, shell.center);
        precise float x = (length_of(away) - shell.radius) * shell.narrow;
        precise float rest = 1.0 - x * x;
        float inside = positive(rest);
        precise float weight = shell.strength * (inside * inside);
        if (weight <= 0.0) continue;
        // At the back of the shell particles turn round.
        bool is_behind = x < BACK;
        // Shorter where the surface lies across.
        vec3 outward = direction_or(away, vec3(0.0));
        vec2 flat_way = vec2(dot_of(outward, frame.p), dot_of(outward, frame.h));
        precise vec2 turned = w.heading + weight * ((is_behind ? -flat_way : flat_way) - w.heading);
        w.heading = direction_or(turned, w.heading);
        if (is_behind) continue;
        precise float slower = shell.speed - w.remaining;
        precise float more = positive(slower) * root(dot_of(flat_way, flat_way));
        precise float longer = w.remaining + weight * more;
        w.remaining = longer;
    }
}

#endif
