// copy_words: copies a buffer, to measure the memory bandwidth that kernels reach.
// Reads   source.
// Writes  target.
// One invocation for four words.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "index.glsl"

layout(local_size_x = 256) in;

layout(push_constant) uniform Params {
    uint quad_count;  // four words each
} params;

layout(std430, set = 0, binding = 0) readonly buffer Source { uvec4 source[]; };  // one an invocation
layout(std430, set = 0, binding = 1) writeonly buffer Target { uvec4 target[]; };  // one an invocation

void main() {
    uint i = invocation_index();
    if (i >= params.quad_count) return;
    target[i] = source[i];
}
