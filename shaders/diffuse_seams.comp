// diffuse_seams: as diffuse, for texels that exchange across a seam, or whose neighbours are limited.
// Reads   rows, entries, trail, deposits (those on gutter texels too), density.
// Writes  next_trail for the texels of the rows.
// One invocation a row. What is read comes by texel buffers, which CPU drivers are quicker with.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "index.glsl"

layout(local_size_x = 64) in;

// What one view of single texels does not hold is read four texels at once, and written through two views.
layout(constant_id = 0) const bool TEXELS_IN_QUADS = false;
layout(constant_id = 1) const uint BAND = 0xffffffffu;  // texels of the first of two

layout(push_constant) uniform Params {
    uint row_count;
    uint reach_across;  // texels between the stencil's taps
    uint reach_down;    // the same times the pitch
    float diffusion;    // 0: nothing spreads, 1: the mean of the nine taps
    float deposit;      // trail units that one particle leaves on a texel of mean area
    float decay;        // what remains after a step
    float tiny;         // below this a value is zero
} params;

// Five words a row: the texel, its first entry, the number of pairs, how many deposits and the mask, the conductance.
layout(set = 0, binding = 0) uniform usamplerBuffer rows;
// Two words an entry: a texel, and its conductance or share.
layout(set = 0, binding = 1) uniform usamplerBuffer entries;
layout(set = 0, binding = 2) uniform samplerBuffer trail;
layout(set = 0, binding = 3) uniform usamplerBuffer deposits;
layout(set = 0, binding = 4) uniform samplerBuffer density;
layout(r32f, set = 0, binding = 5) uniform writeonly imageBuffer low_next_trail;
layout(r32f, set = 0, binding = 6) uniform writeonly imageBuffer high_next_trail;

#include "texels.glsl"

uint word(uint row, uint k) {
    return texelFetch(rows, int(5u * row + k)).x;
}

float trail_at(uint texel) {
    return texel_of(trail, texel);
}

float deposits_at(uint texel) {
    return float(texel_of(deposits, texel));
}

// How much more a neighbour has, if the texel exchanges with it.
float more_at(uint mask, uint bit, uint neighbour, uint texel, float here) {
    bool exchanges = (mask >> bit & 1u) != 0u;
    precise float more = trail_at(exchanges ? neighbour : texel) - here;
    return more;
}

void main() {
    uint i = invocation_index();
    if (i >= params.row_count) return;
    uint texel = word(i, 0u);
    float here = trail_at(texel);
    uint above = texel - params.reach_down;
    uint below = texel + params.reach_down;
    uint mask = word(i, 3u);
    precise float inside = more_at(mask, 0u, above - params.reach_across, texel, here);
    inside += more_at(mask, 1u, above, texel, here);
    inside += more_at(mask, 2u, above + params.reach_across, texel, here);
    inside += more_at(mask, 3u, texel - params.reach_across, texel, here);
    inside += more_at(mask, 4u, texel + params.reach_across, texel, here);
    inside += more_at(mask, 5u, below - params.reach_across, texel, here);
    inside += more_at(mask, 6u, below, texel, here);
    inside += more_at(mask, 7u, below + params.reach_across, texel, here);
    uint next = word(i, 1u);
    uint end = next + word(i, 2u);
    precise float across = 0.0;
    for (; next < end; next++) {
        uvec2 pair = texelFetch(entries, int(next)).xy;
        across += uintBitsToFloat(pair.y) * (trail_at(pair.x) - here);
    }
    end += mask >> 8u;
    // Counts and shares are small multiples of a power of two, so the order does not matter here.
    precise float counted = deposits_at(texel);
    for (; next < end; next++) {
        uvec2 part = texelFetch(entries, int(next)).xy;
        counted += uintBitsToFloat(part.y) * deposits_at(part.x);
    }
    float own = texel_of(density, texel);
    precise float spread = here + (params.diffusion * own) * (uintBitsToFloat(word(i, 4u)) * inside + across);
    precise float value = (spread + (params.deposit * counted) * own) * params.decay;
    store_texel(low_next_trail, high_next_trail, texel, vec4(value >= params.tiny ? value : 0.0))
}
