// spin: keeps the device busy for as many rounds as asked.
// Reads   values.
// Writes  values.
// One invocation per element.
// Overflow: wraps.
#version 460
#include "index.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = 0) buffer Values { uint values[]; };
layout(push_constant) uniform Params { uint count; uint rounds; } params;

void main() {
    uint i = invocation_index();
    if (i >= params.count) return;
    uint x = values[i];
    // Rounds are limited: loops.glsl says why; ask for fewer.
    for (uint n = 0u; n < params.rounds; n++) {
        x = x * 1664525u + values[x % params.count] + n;
    }
    values[i] = x;
}
