// diffuse: the trail spreads, takes up the deposits, decays; values too small to see become zero.
// Reads   trail (gutters filled), deposits, density.
// Writes  next_trail for owned texels; previous_deposits, cleared for the next step.
// One invocation per four texels of a row: one wide load a row and side.
// Texels that no triangle owns have density 0; four of them together return at once.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "index.glsl"

layout(local_size_x = 64) in;

layout(constant_id = 0) const int DISTANCE = 1;  // texels between the taps, 1 to 4

layout(push_constant) uniform Params {
    uint quad_count;     // texels / 4
    uint quads_a_row;    // pitch / 4
    uint rows;
    float diffusion;     // 0: nothing spreads, 1: the mean of the nine taps
    float deposit;       // trail units that one particle leaves on a texel of mean area
    float decay;         // what remains after a step
    float tiny;          // below this a value is zero: denormals are slow, and nobody sees them
} params;

layout(std430, set = 0, binding = 0) readonly buffer Trail { vec4 trail[]; };
layout(std430, set = 0, binding = 1) readonly buffer Deposits { uvec4 deposits[]; };
layout(std430, set = 0, binding = 2) readonly buffer Density { vec4 density[]; };
layout(std430, set = 0, binding = 3) writeonly buffer NextTrail { vec4 next_trail[]; };
layout(std430, set = 0, binding = 4) writeonly buffer PreviousDeposits { uvec4 previous_deposits[]; };

// Four texels, moved by `DISTANCE` to the left and to the right, from the four before and after.
vec4 from_left(vec4 before, vec4 here) {
    if (DISTANCE == 1) return vec4(before.w, here.xyz);
    if (DISTANCE == 2) return vec4(before.zw, here.xy);
    if (DISTANCE == 3) return vec4(before.yzw, here.x);
    return before;
}

vec4 from_right(vec4 here, vec4 after) {
    if (DISTANCE == 1) return vec4(here.yzw, after.x);
    if (DISTANCE == 2) return vec4(here.zw, after.xy);
    if (DISTANCE == 3) return vec4(here.w, after.xyz);
    return after;
}

// The sum of the three taps in a row, for each of four texels. Rows end in gutter or unused texels, so what lies
// beyond them is never needed; the index is only kept inside the buffer.
vec4 row_sum(uint quad) {
    vec4 before = trail[max(quad, 1u) - 1u];
    vec4 here = trail[quad];
    vec4 after = trail[min(quad + 1u, params.quad_count - 1u)];
    precise vec4 sum = (from_left(before, here) + here) + from_right(here, after);
    return sum;
}

void main() {
    uint quad = invocation_index();
    if (quad >= params.quad_count) return;
    vec4 owned = density[quad];
    if (owned == vec4(0.0)) return;

    uint row = quad / params.quads_a_row;
    uint up = quad - min(row, uint(DISTANCE)) * params.quads_a_row;
    uint down = quad + min(params.rows - 1u - row, uint(DISTANCE)) * params.quads_a_row;
    vec4 here = trail[quad];
    precise vec4 mean = ((row_sum(up) + row_sum(quad)) + row_sum(down)) * (1.0 / 9.0);
    precise vec4 spread = here + params.diffusion * (mean - here);
    precise vec4 value = (spread + (params.deposit * vec4(deposits[quad])) * owned) * params.decay;
    bvec4 kept = bvec4(uvec4(greaterThanEqual(value, vec4(params.tiny))) & uvec4(greaterThan(owned, vec4(0.0))));
    next_trail[quad] = mix(vec4(0.0), value, kept);
    previous_deposits[quad] = uvec4(0u);
}
