// scale: multiplies and shifts every element; a test of the plumbing.
// Reads   source.
// Writes  target.
// One invocation per element.
// Overflow: none.
#version 460
#include "index.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint SHIFT = 5; // Added to every element.
layout(constant_id = 1) const bool NEGATE = false; // Changes the sign at the end.

layout(std430, binding = 3) readonly buffer Source { float source[]; };  // one an invocation
layout(std430, binding = 7) writeonly buffer Target { float target[]; };  // one an invocation

layout(push_constant) uniform Params {
    uint count; // Elements.
    vec2 factor; // The product of both is applied.
} params;

void main() {
    uint i = invocation_index();
    if (i >= params.count) return;
    float value = source[i] * params.factor.x * params.factor.y + float(SHIFT);
    target[i] = NEGATE ? -value : value;
}
