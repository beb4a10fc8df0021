// limit_pick: finds half of the largest key with which a particle leaves: the bin at which the number of particles reaches the limit.
// Reads   bins, flow.
// Writes  flow; bins, which are zero afterwards.
// One group: each invocation adds up a run of bins, then all add up the runs before theirs.
// Overflow: cannot happen; more are counted than may leave.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"

layout(local_size_x = 256) in;

layout(push_constant) uniform Params {
    uint capacity;
    uint is_low;
} params;

layout(std430, set = 0, binding = 0) buffer FlowBlock { Flow flow[]; };
layout(std430, set = 0, binding = 1) buffer Bins { uint bins[]; };

#include "limit.glsl"

shared uint sums[gl_WorkGroupSize.x];

void main() {
    uint me = invocation_index();
    if (me >= gl_WorkGroupSize.x) return;
    const uint run = BINS / gl_WorkGroupSize.x;
    uint first = me * run;
    uint sum = 0u;
    for (uint i = first; i < first + run; i += 1u) sum += bins[i];
    sums[me] = sum;
    uint room = params.is_low == 0u ? params.capacity : flow[0].rest;
    uint upper = params.is_low == 0u ? 0u : flow[0].limit;
    // What is read above is written below.
    memoryBarrierBuffer();
    barrier();
    uint before = 0u;
    for (uint i = 0u; i < me; i += 1u) before += sums[i];
    for (uint i = first; i < first + run; i += 1u) {
        uint count = bins[i];
        if (before < room && room <= before + count) {
            flow[0].limit = params.is_low == 0u ? i * BINS : upper + i;
            flow[0].rest = room - before;
        }
        before += count;
        bins[i] = 0u;
    }
}
