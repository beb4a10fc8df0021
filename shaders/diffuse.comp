// diffuse: the trail spreads, takes up the deposits, decays; values too small to see become zero.
// Reads   strips, trail, deposits, density.
// Writes  next_trail for owned texels, zero for others of the strips; previous_deposits, cleared for the next step.
// One invocation per four texels of a row, four of them a strip, a cache line; strips without any texel in use are not listed.
// Texels beside a seam come out wrong here: diffuse_seams writes them anew.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "index.glsl"

layout(local_size_x = 64) in;

layout(constant_id = 0) const int DISTANCE = 1;  // texels between the taps, 1 to 4

layout(push_constant) uniform Params {
    uint lane_count;     // four a strip
    uint quad_count;     // texels / 4
    uint quads_a_row;    // pitch / 4
    float diffusion;     // 0: nothing spreads, 1: the mean of the nine taps
    float most_density;  // smaller texels spread no faster than one of this density
    float deposit;       // trail units that one particle leaves on a texel of mean area
    float decay;         // what remains after a step
    float tiny;          // below this a value is zero: denormals are slow, and nobody sees them
} params;

layout(std430, set = 0, binding = 0) readonly buffer Strips { uint strips[]; };
layout(std430, set = 0, binding = 1) readonly buffer Trail { vec4 trail[]; };
layout(std430, set = 0, binding = 2) readonly buffer Deposits { uvec4 deposits[]; };
layout(std430, set = 0, binding = 3) readonly buffer Density { vec4 density[]; };
layout(std430, set = 0, binding = 4) writeonly buffer NextTrail { vec4 next_trail[]; };
layout(std430, set = 0, binding = 5) buffer PreviousDeposits { uvec4 previous_deposits[]; };

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

// By how much the three taps in a row are more than three times `here`, for each of four texels. What all have in common
// cancels to the last bit, so a constant stays constant. A chart's gutter lies between it and the texture's sides, so
// what is beyond them is never needed; the index is only kept inside the buffer.
vec4 excess(uint quad, vec4 thrice) {
    vec4 before = trail[max(quad, 1u) - 1u];
    vec4 middle = trail[quad];
    vec4 after = trail[min(quad + 1u, params.quad_count - 1u)];
    precise vec4 sum = (from_left(before, middle) + middle) + from_right(middle, after);
    precise vec4 more = sum - thrice;
    return more;
}

void main() {
    uint i = invocation_index();
    if (i >= params.lane_count) return;
    uint quad = 4u * strips[i / 4u] + i % 4u;
    if (quad >= params.quad_count) return;

    vec4 owned = density[quad];
    uint reach = uint(DISTANCE) * params.quads_a_row;
    vec4 here = trail[quad];
    precise vec4 thrice = 3.0 * here;
    precise vec4 more = (excess(max(quad, reach) - reach, thrice) + excess(quad, thrice))
        + excess(min(quad + reach, params.quad_count - 1u), thrice);
    precise vec4 rate = (params.diffusion * min(owned, vec4(params.most_density))) * (1.0 / 9.0);
    precise vec4 spread = here + rate * more;
    precise vec4 value = (spread + (params.deposit * vec4(deposits[quad])) * owned) * params.decay;
    bvec4 kept = bvec4(uvec4(greaterThanEqual(value, vec4(params.tiny))) & uvec4(greaterThan(owned, vec4(0.0))));
    next_trail[quad] = mix(vec4(0.0), value, kept);
    // Most are zero already, and to look costs less than to write.
    if (previous_deposits[quad] != uvec4(0u)) previous_deposits[quad] = uvec4(0u);
}
