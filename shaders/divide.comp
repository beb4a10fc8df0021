// divide: particles die where it is too crowded, or too lonely, round them, or of hunger; others that have just moved forward divide, by
// how crowded it is: they claim one of the free cells beside theirs. Of several that claim one, the lowest rank remains.
// Reads   particles, strips, homes, occupants, nests, bias, distances.
// Writes  motions of particles that die; births: the cell that each particle claims; nursery, by atomic minima; id_marks: the ids of dead
//         particles, by atomic ors: both are empty before.
// One invocation per particle.
// Overflow: cannot happen; nothing is appended.
// The rules and their usual numbers are those of Jones, "From Pattern Formation to Material Computation" (2015).

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "words.glsl"
#include "index.glsl"
#include "tables.glsl"
#include "texels.glsl"
#include "ring.glsl"
#include "rng.glsl"
#include "claims.glsl"
#include "no_go.glsl"
#include "id_marks.glsl"

layout(local_size_x = 256) in;

// The bias was painted: some places may not be entered.
layout(constant_id = 15) const bool PAINTED = false;
// Particles leave places that other objects cover, so none is born there.
layout(constant_id = 6) const bool SELECTS = false;
// Particles die if they have been hungry for long.
layout(constant_id = 23) const bool HUNGER = false;

layout(push_constant) uniform Params {
    uint particle_count;
    uint seed;
    uint time_step;
    uint salt;                   // of the step
    uint pitch;                  // texels from one atlas row to the next
    int division_reach;          // cells in each direction from the particle's
    uint division_least;         // particles in that window with which it divides
    uint division_most;
    float division_probability;
    int survival_reach;          // the same for the window in which it must not be too crowded
    uint survival_least;
    uint survival_most;
    float death_probability;     // of those outside of these bounds
    uint hunger;                 // hungry steps with which a particle dies
    float transfer_threshold;    // world length of signed distance below which a place is covered
} params;

PAGED_READS(uvec4, 0) particles;  // one an invocation
PAGED_CHANGES(uvec4, 1) motions;  // one an invocation
READS(uvec4, 2) strips;
READS(uint, 3) homes_texels;
READS(uint, 4) occupants_texels;
// The triangle on which particles are born in a texel; NONE if none can be.
READS(uint, 5) nests_texels;
READS(float, 6) bias_texels;  // may be absent
layout(std430, set = 0, binding = 7) buffer Nursery { uint nursery_block[]; };
CHANGES(uint, 8) nursery_low;
CHANGES(uint, 9) nursery_high;
WRITES(uint, 10) births;  // one an invocation
layout(std430, set = 0, binding = 11) buffer IdMarks { uint id_marks[]; };
READS(float, 12) distances;

#include "strip_table.glsl"
#include "atlas.glsl"

uint texel_beside(uint cell, int column, int row) {
    return uint(int(cell) + row * int(params.pitch) + column);
}

// Particles in the cells of a window. Over a seam it has the cells that stand for the texels of the gutter.
uint count_round(uint cell, int reach) {
    uint sum = 0u;
    for (int row = -reach; row <= reach; row += 1) {
        for (int column = -reach; column <= reach; column += 1) {
            uint beside = texel_of(homes, texel_beside(cell, column, row));
            sum += texel_of(occupants, beside);
        }
    }
    return sum;
}

bool is_free(uint cell) {
    if (texel_of(nests, cell) == NONE || texel_of(occupants, cell) != 0u) return false;
    if (PAINTED) {
        if (texel_of(bias, cell) < NO_GO) return false;
    }
    if (SELECTS) {
        if (fetch1(distances, cell) < params.transfer_threshold) return false;
    }
    return true;
}

// One of the eight cells round a cell. The middle one of nine is the cell itself.
uint cell_beside(uint cell, uint k) {
    uint place = k < 4u ? k : k + 1u;
    return texel_of(homes, texel_beside(cell, int(place % 3u) - 1, int(place / 3u) - 1));
}

// Is this the first one of the eight places with its cell? Over a border or a seam several have the same.
bool is_first(uint cell, uint k) {
    uint beside = cell_beside(cell, k);
    for (uint j = 0u; j < k; j += 1u) {
        if (cell_beside(cell, j) == beside) return false;
    }
    return true;
}

// One of the free cells of the eight round a cell, each as likely as the others; NONE if none is free.
uint free_beside(uint cell, uint chance) {
    uint free = 0u;
    for (uint k = 0u; k < 8u; k += 1u) {
        if (is_free(cell_beside(cell, k)) && is_first(cell, k)) free |= 1u << k;
    }
    if (free == 0u) return NONE;
    // Clears the lowest set bits, a random number of them, and takes the next.
    for (uint left = chance % uint(bitCount(free)); left > 0u; left -= 1u) free &= free - 1u;
    return cell_beside(cell, uint(findLSB(free)));
}

void main() {
    uint i = invocation_index();
    if (i >= params.particle_count) return;
    Particle particle = particle_of(fetch_paged(particles, i));
    Motion motion = motion_of(load_paged(motions, i));
    bool is_dead = (motion.flags & DEAD) != 0u;
    uint claimed = NONE;
    if (!is_dead) {
        vec2 position = atlas_position(atlas_map_of(particle.triangle), particle.u, particle.v);
        uint cell = texel_of(homes, texel_at(position, params.pitch));
        uvec4 words = random_words(params.seed, particle.id, params.time_step, PURPOSE_POPULATION);
        uint crowd = count_round(cell, params.survival_reach);
        bool survives = crowd >= params.survival_least && crowd <= params.survival_most;
        is_dead = !survives && unit_float(words.x) < params.death_probability;
        if (HUNGER) is_dead = is_dead || hungry_steps(motion.flags) >= params.hunger;
        if (is_dead) {
            store_paged(motions, i, words_of(Motion(motion.heading_p, motion.heading_h, 0.0, DEAD)));
        } else if ((motion.flags & STAYED) == 0u && unit_float(words.y) < params.division_probability) {
            crowd = count_round(cell, params.division_reach);
            if (crowd >= params.division_least && crowd <= params.division_most) claimed = free_beside(cell, words.z);
        }
    }
    if (is_dead) atomicOr(id_marks[words_of_ids(params.particle_count) + word_of_id(particle.id)], bit_of_id(particle.id));
    if (claimed != NONE) {
        lower_texel(nursery, claimed, rank_of(particle.id, params.salt), before)
    }
    store1(births, i, claimed);
}
