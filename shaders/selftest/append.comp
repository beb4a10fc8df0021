// append: lists even and odd numbers separately, but for multiples of a factor; and all numbers in three lists, by groups of sixteen.
// Reads   factors.
// Writes  listed (appended); counts.
// One invocation a number.
// Overflow: none; each list has room for all numbers.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "index.glsl"
#include "tables.glsl"
#include "append.glsl"

layout(local_size_x = 64) in;
layout(push_constant) uniform Params { uint count; } params;
READS(uint, 2) factors;
layout(std430, binding = 0) buffer Counts { uint counts[]; };
layout(std430, binding = 1) writeonly buffer Listed { uint listed[]; };

void main() {
    uint i = invocation_index();
    if (i >= params.count) return;
    uint which = 2u + i / 16u % 3u;
    append_to_one_of(counts, which, third)
    listed[which * params.count + third] = i;
    if (i % fetch1(factors, 0u) == 0u) return;
    // Neighbours append to different lists: in a branch, the active invocations append together.
    if (i % 2u == 0u) {
        append_to(counts[0], place)
        listed[place] = i;
    } else {
        append_to(counts[1], place)
        listed[params.count + place] = i;
    }
}
