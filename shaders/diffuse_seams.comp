// diffuse_seams: as diffuse, for texels that exchange across a seam, or whose neighbours are limited.
// Reads   rows, entries, trail, deposits (those on gutter texels too), density.
// Writes  next_trail for the texels of the rows.
// One invocation a row.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Params {
    uint row_count;
    uint reach_across;  // texels between the stencil's taps
    uint reach_down;    // the same times the pitch
    float diffusion;    // 0: nothing spreads, 1: the mean of the nine taps
    float deposit;      // trail units that one particle leaves on a texel of mean area
    float decay;        // what remains after a step
    float tiny;         // below this a value is zero
} params;

layout(std430, set = 0, binding = 0) readonly buffer Rows { ExchangeRow rows[]; };
layout(std430, set = 0, binding = 1) readonly buffer Entries { ExchangeEntry entries[]; };
layout(std430, set = 0, binding = 2) readonly buffer Trail { float trail[]; };
layout(std430, set = 0, binding = 3) readonly buffer Deposits { uint deposits[]; };
layout(std430, set = 0, binding = 4) readonly buffer Density { float density[]; };
layout(std430, set = 0, binding = 5) writeonly buffer NextTrail { float next_trail[]; };

// How much more a neighbour has, if the texel exchanges with it.
float more_at(uint mask, uint bit, uint neighbour, uint texel, float here) {
    bool exchanges = (mask >> bit & 1u) != 0u;
    precise float more = trail[exchanges ? neighbour : texel] - here;
    return more;
}

void main() {
    uint i = invocation_index();
    if (i >= params.row_count) return;
    ExchangeRow row = rows[i];
    uint texel = row.texel;
    float here = trail[texel];
    uint above = texel - params.reach_down;
    uint below = texel + params.reach_down;
    uint mask = row.counts_and_mask;
    precise float inside = more_at(mask, 0u, above - params.reach_across, texel, here);
    inside += more_at(mask, 1u, above, texel, here);
    inside += more_at(mask, 2u, above + params.reach_across, texel, here);
    inside += more_at(mask, 3u, texel - params.reach_across, texel, here);
    inside += more_at(mask, 4u, texel + params.reach_across, texel, here);
    inside += more_at(mask, 5u, below - params.reach_across, texel, here);
    inside += more_at(mask, 6u, below, texel, here);
    inside += more_at(mask, 7u, below + params.reach_across, texel, here);
    uint next = row.first;
    uint end = next + row.pair_count;
    precise float across = 0.0;
    for (; next < end; next++) {
        ExchangeEntry pair = entries[next];
        across += pair.weight * (trail[pair.texel] - here);
    }
    end += row.counts_and_mask >> 8u;
    // Counts and shares are small multiples of a power of two, so the order does not matter here.
    precise float counted = float(deposits[texel]);
    for (; next < end; next++) {
        ExchangeEntry part = entries[next];
        counted += part.weight * float(deposits[part.texel]);
    }
    float own = density[texel];
    precise float spread = here + (params.diffusion * own) * (row.conductance * inside + across);
    precise float value = (spread + (params.deposit * counted) * own) * params.decay;
    next_trail[texel] = value >= params.tiny ? value : 0.0;
}
