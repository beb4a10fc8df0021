// sort_sums: adds up the counts of each stretch of bins.
// Reads   bins.
// Writes  sums.
// One group per stretch; each invocation adds up a run of bins.
// Overflow: cannot happen; the sum is at most that of all particles.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "index.glsl"

layout(local_size_x = 128) in;

layout(push_constant) uniform Params {
    uint bin_count;
} params;

layout(std430, set = 0, binding = 0) readonly buffer Bins { uint bins[]; };
layout(std430, set = 0, binding = 1) writeonly buffer Sums { uint sums[]; };

#include "stretch.glsl"

shared uint sum;

void main() {
    uint me = gl_LocalInvocationID.x;
    uint first = first_bin();
    uint stretch = first / STRETCH;
    if (stretch * STRETCH >= params.bin_count) return;
    if (me == 0u) sum = 0u;
    barrier();
    uint mine = 0u;
    for (uint k = 0u; k < RUN; k += 1u) mine += first + k < params.bin_count ? bins[first + k] : 0u;
    atomicAdd(sum, mine);
    barrier();
    if (me == 0u) sums[stretch] = sum;
}
