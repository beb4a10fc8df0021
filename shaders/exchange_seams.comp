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
    // Four weights of 16 bits, in units of 1 / 32768.
    precise float value = float(seam.weight[0] & 0xffffu) * trail[seam.source[0]];
    value += float(seam.weight[0] >> 16u) * trail[seam.source[1]];
    value += float(seam.weight[1] & 0xffffu) * trail[seam.source[2]];
    value += float(seam.weight[1] >> 16u) * trail[seam.source[3]];
    precise float filled = value * (1.0 / 32768.0);
    trail[seam.texel] = filled;
}
