// sort_scan: turns the number of particles of each bin into the number before it.
// Reads   bins, sums.
// Writes  places; bins, which are zero afterwards.
// One group per stretch of bins: its invocations add up the sums of the stretches before it, then each a run of bins, and then the runs
// before theirs.
// Overflow: cannot happen; the sum is that of all particles.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "index.glsl"

layout(local_size_x = 128) in;

layout(push_constant) uniform Params {
    uint bin_count;
} params;

layout(std430, set = 0, binding = 0) buffer Bins { uint bins[]; };
layout(std430, set = 0, binding = 1) readonly buffer Sums { uint sums[]; };
layout(std430, set = 0, binding = 2) writeonly buffer Places { uint places[]; };

#include "stretch.glsl"

shared uint before_stretch;
shared uint of_runs[gl_WorkGroupSize.x];

void main() {
    uint me = gl_LocalInvocationID.x;
    uint first = first_bin();
    uint stretch = first / STRETCH;
    if (stretch * STRETCH >= params.bin_count) return;
    if (me == 0u) before_stretch = 0u;
    barrier();
    uint share = 0u;
    for (uint k = me; k < stretch; k += gl_WorkGroupSize.x) share += sums[k];
    atomicAdd(before_stretch, share);
    uint counts[RUN];
    uint sum = 0u;
    for (uint k = 0u; k < RUN; k += 1u) {
        counts[k] = first + k < params.bin_count ? bins[first + k] : 0u;
        sum += counts[k];
    }
    of_runs[me] = sum;
    barrier();
    uint before = before_stretch;
    for (uint i = 0u; i < me; i += 1u) before += of_runs[i];
    for (uint k = 0u; k < RUN; k += 1u) {
        if (first + k < params.bin_count) {
            places[first + k] = before;
            bins[first + k] = 0u;
        }
        before += counts[k];
    }
}
