// exchange_seams: fills the gutter from the texels across the seams, so that no read ever sees one.
// Reads   seams, owned texels of trail.
// Writes  gutter texels of trail; nothing reads a gutter texel here.
// One invocation a gutter texel.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Params {
    uint seam_count;
} params;

layout(std430, set = 0, binding = 0) readonly buffer Seams { Seam seams[]; };
layout(std430, set = 0, binding = 1) buffer Trail { float trail[]; };

void main() {
    uint i = invocation_index();
    if (i >= params.seam_count) return;
    Seam seam = seams[i];
    precise float value = seam.weight[0] * trail[seam.source[0]];
    value += seam.weight[1] * trail[seam.source[1]];
    value += seam.weight[2] * trail[seam.source[2]];
    value += seam.weight[3] * trail[seam.source[3]];
    trail[seam.texel] = value;
}
