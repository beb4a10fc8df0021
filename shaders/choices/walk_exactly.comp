// walk_exactly: a straight walk of a given length, as in `advance`: it finds the edge ahead before it goes there.
// Reads   particles_before, motions_before, strips.
// Writes  particles, motions.
// One invocation per particle.
// A walk that runs out of edge-crossing attempts continues in the next dispatch.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "words.glsl"
#include "index.glsl"
#include "atlas.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Params {
    uint particle_count;
    uint attempts;  // edge crossings that one walk may make
    float way;      // world length
} params;

layout(set = 0, binding = 0) uniform usamplerBuffer particles_before;
layout(set = 0, binding = 1) uniform usamplerBuffer motions_before;
layout(set = 0, binding = 2) uniform usamplerBuffer strips;
layout(rgba32ui, set = 0, binding = 3) uniform writeonly uimageBuffer particles;
layout(rgba32ui, set = 0, binding = 4) uniform writeonly uimageBuffer motions;

#include "strip.glsl"

void main() {
    uint i = invocation_index();
    if (i >= params.particle_count) return;
    Particle particle = particle_of(texelFetch(particles_before, int(i)));
    Motion motion = motion_of(texelFetch(motions_before, int(i)));
    vec2 heading = vec2(motion.heading_p, motion.heading_h);
    precise float remaining = motion.pending + params.way;
    StripWalk w = StripWalk(particle.triangle, particle.u, particle.v, heading, remaining, WALK_DONE);
    walk_strip(w, params.attempts, true);
    float pending = w.status == WALK_OUT_OF_ATTEMPTS ? w.remaining : 0.0;
    imageStore(particles, int(i), words_of(Particle(w.triangle, w.u, w.v, particle.id)));
    imageStore(motions, int(i), words_of(Motion(w.heading.x, w.heading.y, pending, motion.flags)));
}
