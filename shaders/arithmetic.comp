// arithmetic: sums, products and every function of strict.glsl and vectors.glsl at given numbers, to be compared with the host's.
// Reads   words.
// Writes  found, six times four numbers a word.
// One invocation per word.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "index.glsl"
#include "vectors.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Params {
    uint count;
} params;

layout(std430, set = 0, binding = 0) readonly buffer Words { uvec4 words[]; };  // one an invocation
layout(std430, set = 0, binding = 1) writeonly buffer Found { vec4 found[]; };

void main() {
    uint i = invocation_index();
    if (i >= params.count) return;
    uvec4 word = words[i];
    vec4 x = uintBitsToFloat(word);
    vec3 v = x.xyz;
    vec3 w = x.yzw;
    precise float product = x.x * x.y;
    precise float sum = x.x + x.y;
    precise float both = x.x * x.y + x.z;
    precise float less = x.x * x.y - x.z * x.w;
    found[6u * i] = vec4(product, sum, both, less);
    found[6u * i + 1u] = vec4(reciprocal(x.x), quotient(x.x, x.y), share(x.x, x.y), inverse_root(x.x));
    found[6u * i + 2u] = vec4(root(x.x), turn_of(word.x * 0x9e3779b1u), logarithm(abs(x.x)));
    found[6u * i + 3u] = vec4(angle_of_vector(x.x, x.y), direction_or(v, vec3(1.0, 0.0, 0.0)));
    found[6u * i + 4u] = vec4(dot_of(v, w), cross_of(v, w).y, length_of(v), direction_or(x.zw, vec2(1.0, 0.0)).x);
    found[6u * i + 5u] = vec4(settled(x.y), within(x.y, -1.0, 1.0), floor(x.z), cross_of(v, w).z);
}
