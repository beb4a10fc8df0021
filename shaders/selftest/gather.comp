#version 460
// gather: reads texel buffers.
// Reads   table, pairs.
// Writes  sums.
// One invocation per element.
// Overflow: none.
#include "index.glsl"

layout(local_size_x = 64) in;
layout(binding = 0) uniform samplerBuffer table;
layout(binding = 1) uniform usamplerBuffer pairs;
layout(std430, binding = 2) writeonly buffer Sums { vec4 sums[]; };
layout(push_constant) uniform Params { uint count; } params;

void main() {
    uint i = invocation_index();
    if (i >= params.count) return;
    uvec2 pair = texelFetch(pairs, int(i)).xy;
    sums[i] = texelFetch(table, int(pair.x)) + texelFetch(table, int(pair.y));
}
