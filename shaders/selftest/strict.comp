// strict: every function of strict.glsl and vectors.glsl, to be compared with the twins.
// Reads   words.
// Writes  found, 16 numbers a word.
// One invocation per word.
// Overflow: none.
#version 460
#include "index.glsl"
#include "vectors.glsl"

layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer Words { uvec4 words[]; };  // one an invocation
layout(std430, binding = 1) writeonly buffer Found { vec4 found[]; };  // four an invocation

layout(push_constant) uniform Params {
    uint count;
} params;

void main() {
    uint i = invocation_index();
    if (i >= params.count) return;
    uvec4 word = words[i];
    vec4 x = uintBitsToFloat(word);
    vec3 v = x.xyz;
    vec3 w = x.yzw;
    found[4u * i] = vec4(reciprocal(x.x), quotient(x.x, x.y), share(x.x, x.y), inverse_root(x.x));
    found[4u * i + 1u] = vec4(root(x.x), turn_of(word.x), logarithm(abs(x.x)));
    found[4u * i + 2u] = vec4(angle_of_vector(x.x, x.y), direction_or(v, vec3(1.0, 0.0, 0.0)));
    found[4u * i + 3u] = vec4(dot_of(v, w), cross_of(v, w).y, length_of(v), direction_or(x.zw, vec2(1.0, 0.0)).x);
}
