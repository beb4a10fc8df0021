// diffuse_seams: as diffuse, for texels that exchange across a seam, or whose neighbours are limited.
// Reads   rows, entries, trail, deposits (those on gutter texels too); where objects differ in their rates, objects and rates.
// Writes  next_trail for the texels of the rows.
// One invocation per row.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"
#include "tables.glsl"

layout(local_size_x = 64) in;

// Objects differ in how much is left on them, or in how it spreads or decays.
layout(constant_id = 0) const bool OWN_RATES = false;

layout(push_constant) uniform Params {
    uint row_count;
    uint reach_across;  // texels between the stencil's taps
    uint reach_down;    // the same times the pitch
    float diffusion;    // 0: nothing spreads, 1: the mean of the nine taps
    float deposit;      // trail units that one particle leaves on a texel of mean area
    float decay;        // what remains after a step
    float tiny;         // below this a value is zero
    uint first_rates;   // as in diffuse
} params;

// Two texels per row: the texel, its first two pairs, its first two deposits, their end; the mask, the conductance, the density.
READS(uvec4, 0) rows;  // two an invocation
// Two entries a texel: a texel and its conductance or share, twice.
READS(uvec4, 1) entries;
READS(float, 2) trail_texels;
READS(uint, 3) deposits_texels;
WRITES(float, 4) next_trail_low;
WRITES(float, 5) next_trail_high;
READS(uint, 6) objects_texels;  // may be absent
layout(std430, set = 0, binding = 7) readonly buffer Rates { TrailRates rates[]; };  // may be absent

#include "texels.glsl"
#include "rates.glsl"

float trail_at(uint texel) {
    return texel_of(trail, texel);
}

float deposits_at(uint texel) {
    return float(texel_of(deposits, texel));
}

// The rates of a texel's object. Rows never cross from object to object.
TrailRates rates_of(uint texel) {
    uint object = 0u;
    if (OWN_RATES) object = texel_of(objects, texel);
    return rates_on(object);
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
    uvec4 row = fetch4(rows, 2u * i);
    uvec4 more = fetch4(rows, 2u * i + 1u);
    uint texel = row.x;
    float here = trail_at(texel);
    uint above = texel - params.reach_down;
    uint below = texel + params.reach_down;
    uint mask = more.x;
    precise float inside = more_at(mask, 0u, above - params.reach_across, texel, here);
    inside += more_at(mask, 1u, above, texel, here);
    inside += more_at(mask, 2u, above + params.reach_across, texel, here);
    inside += more_at(mask, 3u, texel - params.reach_across, texel, here);
    inside += more_at(mask, 4u, texel + params.reach_across, texel, here);
    inside += more_at(mask, 5u, below - params.reach_across, texel, here);
    inside += more_at(mask, 6u, below, texel, here);
    inside += more_at(mask, 7u, below + params.reach_across, texel, here);
    uint next = row.y;
    precise float across = 0.0;
    // Both loops exit at their end: after an exit at the beginning, a device would still run the rest of the round. Branches keep the
    // results of invocations that have exited, even if the device continues the loop for others.
    while (true) {
        if (next < row.z) {
            uvec4 two = fetch4(entries, next);
            across += uintBitsToFloat(two.y) * (trail_at(two.x) - here);
            across += uintBitsToFloat(two.w) * (trail_at(two.z) - here);
            next++;
        }
        if (next >= row.z) break;
    }
    // Counts and shares are small multiples of a power of two, so the order does not matter here.
    precise float counted = deposits_at(texel);
    while (true) {
        if (next < row.w) {
            uvec4 two = fetch4(entries, next);
            counted += uintBitsToFloat(two.y) * deposits_at(two.x);
            counted += uintBitsToFloat(two.w) * deposits_at(two.z);
            next++;
        }
        if (next >= row.w) break;
    }
    float own = uintBitsToFloat(more.z);
    TrailRates of = rates_of(texel);
    precise float spread = here + (of.diffusion * own) * (uintBitsToFloat(more.y) * inside + across);
    precise float value = (spread + (of.deposit * counted) * own) * of.decay;
    store_texel(next_trail, texel, vec4(value >= params.tiny ? value : 0.0))
}
