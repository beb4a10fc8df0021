// sort_scan: turns the number of particles of each bin into the number before it.
// Reads   bins.
// Writes  bins.
// One group, which takes the bins in rounds: each invocation adds up a few side by side, then all add up those before theirs.
// Overflow: cannot happen; the sum is that of all particles.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "index.glsl"

layout(local_size_x = 128) in;

layout(push_constant) uniform Params {
    uint bin_count;
} params;

layout(std430, set = 0, binding = 0) buffer Bins { uint bins[]; };

// Bins that an invocation takes in a round.
const uint RUN = 16u;

shared uint sums[gl_WorkGroupSize.x];

void main() {
    uint me = invocation_index();
    if (me >= gl_WorkGroupSize.x) return;
    uint before_round = 0u;
    for (uint round = 0u; round < params.bin_count; round += RUN * gl_WorkGroupSize.x) {
        uint first = round + RUN * me;
        uint counts[RUN];
        uint sum = 0u;
        for (uint k = 0u; k < RUN; k += 1u) {
            counts[k] = first + k < params.bin_count ? bins[first + k] : 0u;
            sum += counts[k];
        }
        sums[me] = sum;
        barrier();
        uint before = before_round;
        for (uint i = 0u; i < gl_WorkGroupSize.x; i += 1u) {
            before += i < me ? sums[i] : 0u;
            before_round += sums[i];
        }
        for (uint k = 0u; k < RUN; k += 1u) {
            if (first + k < params.bin_count) bins[first + k] = before;
            before += counts[k];
        }
        // The next round's sums overwrite these, which have been read.
        barrier();
    }
}
