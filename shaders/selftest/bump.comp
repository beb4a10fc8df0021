// bump: adds to every element, in place.
// Reads   values.
// Writes  values.
// One invocation per element.
// Overflow: wraps.
#version 460
#include "index.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = 0) buffer Values { uint values[]; };
layout(push_constant) uniform Params { uint count; uint amount; } params;

void main() {
    uint i = invocation_index();
    if (i >= params.count) return;
    values[i] += params.amount;
}
