// wish: the motor stage with one particle a cell: where each particle would come to, and the cell there. Every particle takes its present cell.
// Reads   particles, motions, strips, physarums, homes, bias and looks (gutters filled); for pulses shells, corners, vertices and poses.
// Writes  wishes and wish_motions: the particle there, and its motion; claims: the cell there, the present cell, the rank, and the texel there;
//         cells, by atomic minima. Dead particles have no rank.
// One invocation per particle.
// A walk that runs out of edge-crossing attempts leaves the rest of its length pending, and the next step is so much longer.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "words.glsl"
#include "index.glsl"
#include "tables.glsl"
#include "texels.glsl"

layout(local_size_x = 256) in;

layout(constant_id = 4) const bool BORDER_REFLECTS = true;
// Some object has its own parameters for the particles on it.
layout(constant_id = 9) const bool OWN_PHYSARUM = false;
// The bias was painted: places attract, repel or may not be entered.
layout(constant_id = 15) const bool PAINTED = false;
// Pulses are live.
layout(constant_id = 17) const bool PULSES = false;
// A second look was painted, and there is one.
layout(constant_id = 18) const bool LOOKS = false;
// Particles may be dead.
layout(constant_id = 22) const bool MORTAL = false;

layout(push_constant) uniform Params {
    uint particle_count;
    uint salt;         // of the step
    uint attempts;     // edge crossings that one walk may make, unless objects have their own
    uint pitch;        // texels from one atlas row to the next
    uint shell_count;  // of the shells, those of live pulses
    uint second_look;  // row of the physarums
} params;

PAGED_READS(uvec4, 0) particles;  // one an invocation
PAGED_READS(uvec4, 1) motions;  // one an invocation
PAGED_WRITES(uvec4, 2) wishes;  // one an invocation
PAGED_WRITES(uvec4, 3) wish_motions;  // one an invocation
PAGED_WRITES(uvec4, 16) claims;  // one an invocation
READS(uvec4, 4) strips;
layout(std430, set = 0, binding = 5) readonly buffer Physarums { Physarum physarums[]; };
READS(uint, 6) homes_texels;
layout(std430, set = 0, binding = 7) buffer Cells { uint cells_block[]; };
CHANGES(uint, 8) cells_low;
CHANGES(uint, 9) cells_high;
READS(float, 10) bias_texels;  // may be absent
READS(float, 11) looks_texels;  // may be absent
layout(std430, set = 0, binding = 12) readonly buffer Shells { Shell shells[]; };
READS(uint, 13) corners;
READS(uvec4, 14) vertices;
READS(vec4, 15) poses;

#include "motor.glsl"
#include "claims.glsl"
#include "ring.glsl"

uint cell_at(vec2 position) {
    return texel_of(homes, texel_at(position, params.pitch));
}

void main() {
    uint i = invocation_index();
    if (i >= params.particle_count) return;
    particle = particle_of(fetch_paged(particles, i));
    motion = motion_of(fetch_paged(motions, i));
    if (MORTAL && (motion.flags & DEAD) != 0u) {
        store_paged(claims, i, uvec4(0u, 0u, NO_RANK, 0u));
        return;
    }
    uint own_cell = cell_at(previous_position());
    uint rank = rank_of(particle.id, params.salt);
    lower_texel(cells, own_cell, taken_by(rank), before)
    if (before <= RANKS) {
        lower_texel(cells, own_cell, SHARED_CELL, also)
    }
    take_own_parameters();
    stand();
    walk_step(motion.pending);
    if (PAINTED) stay_out_of_no_go_areas();
    w.u = settled(w.u);
    w.v = settled(w.v);
    uint texel = texel_at(walked_position(w), params.pitch);
    uint cell = texel_of(homes, texel);
    vec2 heading = settled(w.heading);
    store_paged(wishes, i, words_of(Particle(w.triangle, w.u, w.v, particle.id)));
    store_paged(wish_motions, i, words_of(Motion(heading.x, heading.y, settled(min(pending, own.speed)), 0u)));
    store_paged(claims, i, uvec4(cell, own_cell, rank, texel));
}
