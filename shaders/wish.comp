// wish: the motor stage with one particle a cell: every particle walks to where it would come to, and takes its present cell.
// Reads   particles, strips, physarums, homes, bias and looks (gutters filled); for pulses shells, corners, vertices and poses.
// Writes  wishes: the particle where it would come to; motions in place: as it would be there; claims: the cell there, the present cell,
//         the rank, and the texel there; cells and goals, of which it does not matter whose remain in a cell of several particles. Dead
//         particles have no rank.
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
// The scene has food or markers. Without them no particle is fed.
layout(constant_id = 16) const bool FOOD = false;
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

// Each invocation writes where it alone has read before.
PAGED_READS(uvec4, 0) particles;  // one an invocation
PAGED_WRITES(uvec4, 1) motions;  // one an invocation
PAGED_READS(uvec4, 2) motions_before;  // one an invocation
PAGED_WRITES(uvec4, 3) wishes;  // one an invocation
PAGED_WRITES(uvec4, 4) claims;  // one an invocation
READS(uvec4, 5) strips;
layout(std430, set = 0, binding = 6) readonly buffer Physarums { Physarum physarums[]; };
READS(uint, 7) homes_texels;
layout(std430, set = 0, binding = 8) writeonly buffer Cells { uint cells_block[]; };
WRITES(uint, 9) cells_low;
WRITES(uint, 10) cells_high;
layout(std430, set = 0, binding = 11) writeonly buffer Goals { uint goals_block[]; };
WRITES(uint, 12) goals_low;
WRITES(uint, 13) goals_high;
READS(float, 14) bias_texels;  // may be absent
READS(float, 15) looks_texels;  // may be absent
layout(std430, set = 0, binding = 16) readonly buffer Shells { Shell shells[]; };
READS(uint, 17) corners;
READS(uvec4, 18) vertices;
READS(vec4, 19) poses;

#include "motor.glsl"
#include "claims.glsl"
#include "ring.glsl"

void main() {
    uint i = invocation_index();
    if (i >= params.particle_count) return;
    particle = particle_of(fetch_paged(particles, i));
    motion = motion_of(fetch_paged(motions_before, i));
    if (MORTAL && (motion.flags & DEAD) != 0u) {
        write_paged(claims, i, uvec4(0u, 0u, NO_RANK, 0u));
        return;
    }
    take_own_parameters();
    stand();
    walk_step(motion.pending);
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
    uint rank = rank_of(particle.id, params.salt);
    write_paged(claims, i, uvec4(goal, cell, rank, texel));
    put_texel(cells, cell, rank)
    put_texel(goals, cell, goal)
}
