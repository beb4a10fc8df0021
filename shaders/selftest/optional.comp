// optional: copies every element; with other constants it reads and writes more.
// Reads   source, floats, words.
// Writes  target, sums.
// One invocation per element.
// Overflow: none.
#version 460
#include "index.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 0) const bool READS = false;
layout(constant_id = 1) const bool ADDS = false;

layout(std430, binding = 0) readonly buffer Source { uint source[]; };  // one an invocation
layout(std430, binding = 1) writeonly buffer Target { uint target[]; };  // one an invocation
layout(binding = 2) uniform samplerBuffer floats;  // may be absent
layout(binding = 3) uniform usamplerBuffer words;  // may be absent
layout(std430, binding = 4) readonly buffer More { uint more[]; };  // may be absent
layout(std430, binding = 5) buffer Sums { uint sums[]; };  // may be absent

layout(push_constant) uniform Params { uint count; } params;

void main() {
    uint i = invocation_index();
    if (i >= params.count) return;
    uint value = source[i];
    if (READS) value += uint(texelFetch(floats, int(i)).x) + texelFetch(words, int(i)).x + more[i];
    if (ADDS) atomicAdd(sums[i], value);
    target[i] = value;
}
