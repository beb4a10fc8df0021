// diffuse: the trail spreads, takes up the deposits, decays; values that are too small to be visible become zero.
// Reads   blocks, trail, deposits, density; where objects differ in their rates, objects and rates.
// Writes  next_trail for owned texels, zero for others of the blocks; previous_deposits, cleared for the next step.
// One invocation per four texels (a quad) of four rows; four of them are a block, whose rows are cache lines. Blocks
// without any texel in use are not listed. The rows are as far apart as the taps, so each row's sums serve three times.
// Reads go through tables. Writes go to storage blocks, which CPU drivers are faster with, or to texel buffers,
// which hold more.
// Texels beside a seam get wrong values here: diffuse_seams overwrites them.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"
#include "tables.glsl"
#include "texels.glsl"

layout(local_size_x = 64) in;

layout(constant_id = 0) const int DISTANCE = 1;  // texels between the taps, 1 to 4
// Objects differ in how much is left on them, or in how it spreads or decays.
layout(constant_id = 1) const bool OWN_RATES = false;

layout(push_constant) uniform Params {
    uint lane_count;     // four per block
    uint quad_count;     // texels / 4
    uint quads_a_row;    // pitch / 4
    float diffusion;     // 0: nothing spreads, 1: the mean of the nine taps
    float most_density;  // smaller texels spread no faster than one of this density
    float deposit;       // trail units that one particle leaves on a texel of mean area
    float decay;         // what remains after a step
    float tiny;          // values below this become zero: denormals are slow, and invisible
    uint first_rates;    // of the pass, one an object, with OWN_RATES: they take the place of diffusion, deposit and decay
} params;

READS(uint, 0) blocks;  // their first quads
READS(vec4, 1) trail_quads;
READS(uvec4, 2) deposits_quads;
READS(vec4, 3) density_quads;
layout(std430, set = 0, binding = 4) writeonly buffer NextTrail { vec4 next_trail_block[]; };
layout(std430, set = 0, binding = 5) writeonly buffer PreviousDeposits { uvec4 previous_deposits_block[]; };
WRITES(vec4, 6) next_trail_quads;
WRITES(uvec4, 7) previous_deposits_quads;
READS(uvec4, 8) objects_quads;  // may be absent
layout(std430, set = 0, binding = 9) readonly buffer Rates { TrailRates rates[]; };  // may be absent

#include "rates.glsl"

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

// The three taps in a row around each of four texels. A chart's gutter lies between it and the texture's sides, so what is
// beyond them is never needed; the index is only kept inside the buffer.
vec4 row_sum(uint quad, vec4 middle) {
    vec4 before = quad_of(trail, max(quad, 1u) - 1u);
    vec4 after = quad_of(trail, min(quad + 1u, params.quad_count - 1u));
    precise vec4 sum = (from_left(before, middle) + middle) + from_right(middle, after);
    return sum;
}

// The rates of four texels.
struct QuadRates { vec4 diffusion; vec4 deposit; vec4 decay; };

QuadRates rates_of(uint quad) {
    uvec4 object = uvec4(0u);
    if (OWN_RATES) object = quad_of(objects, quad);
    TrailRates a = rates_on(object.x);
    TrailRates b = rates_on(object.y);
    TrailRates c = rates_on(object.z);
    TrailRates d = rates_on(object.w);
    return QuadRates(
        vec4(a.diffusion, b.diffusion, c.diffusion, d.diffusion),
        vec4(a.deposit, b.deposit, c.deposit, d.deposit),
        vec4(a.decay, b.decay, c.decay, d.decay));
}

void write(uint quad, vec4 here, vec4 above, vec4 beside, vec4 below) {
    vec4 owned = quad_of(density, quad);
    QuadRates own = rates_of(quad);
    // The common part cancels to the last bit, so a constant stays constant.
    precise vec4 thrice = 3.0 * here;
    precise vec4 more = ((above - thrice) + (beside - thrice)) + (below - thrice);
    precise vec4 rate = (own.diffusion * min(owned, vec4(params.most_density))) * (1.0 / 9.0);
    precise vec4 spread = here + rate * more;
    vec4 counted = vec4(quad_of(deposits, quad));
    precise vec4 value = (spread + (own.deposit * counted) * owned) * own.decay;
    bvec4 kept = bvec4(uvec4(greaterThanEqual(value, vec4(params.tiny))) & uvec4(greaterThan(owned, vec4(0.0))));
    vec4 next = mix(vec4(0.0), value, kept);
    store_quad(next_trail, quad, next)
    store_quad(previous_deposits, quad, uvec4(0u))
}

void main() {
    uint i = invocation_index();
    if (i >= params.lane_count) return;
    uint last = params.quad_count - 1u;
    uint reach = uint(DISTANCE) * params.quads_a_row;
    uint quad = fetch1(blocks, i / 4u) + i % 4u;
    uint up = max(quad, reach) - reach;
    vec4 above = row_sum(up, quad_of(trail, up));
    uint at = min(quad, last);
    vec4 here = quad_of(trail, at);
    vec4 beside = row_sum(at, here);
    for (uint row = 0u; row < 4u; row++) {
        uint down = min(quad + reach, last);
        vec4 next = quad_of(trail, down);
        vec4 below = row_sum(down, next);
        if (quad < params.quad_count) write(quad, here, above, beside, below);
        above = beside;
        beside = below;
        here = next;
        quad += reach;
    }
}
