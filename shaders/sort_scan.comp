// sort_scan: from how many particles each bin has to how many lie before it.
// Reads   bins.
// Writes  bins.
// One group: each invocation adds up a run of bins, then all add up the runs before theirs.
// Overflow: cannot happen; the sum is that of all particles.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "index.glsl"

layout(local_size_x = 128) in;

layout(push_constant) uniform Params {
    uint bin_count;
} params;

layout(std430, set = 0, binding = 0) buffer Bins { uint bins[]; };

shared uint sums[gl_WorkGroupSize.x];

void main() {
    if (invocation_index() >= gl_WorkGroupSize.x) return;
    uint run = (params.bin_count + gl_WorkGroupSize.x - 1u) / gl_WorkGroupSize.x;
    uint me = invocation_index();
    uint first = min(me * run, params.bin_count);
    uint end = min(first + run, params.bin_count);
    uint sum = 0u;
    for (uint i = first; i < end; i += 1u) sum += bins[i];
    sums[me] = sum;
    barrier();
    uint before = 0u;
    for (uint i = 0u; i < me; i += 1u) before += sums[i];
    for (uint i = first; i < end; i += 1u) {
        uint count = bins[i];
        bins[i] = before;
        before += count;
    }
}
