// exchange_seams: fills the gutter from the texels across the seams, so that no read ever sees one.
// Reads   seams, owned texels of trail.
// Writes  gutter texels of trail; nothing reads a gutter texel here, but for those beside owned
//         ones that are read four at once: there it is not looked at.
// One invocation a gutter texel.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "index.glsl"

layout(local_size_x = 64) in;


layout(push_constant) uniform Params {
    uint seam_count;
} params;

// Two texels a seam: four that it is filled from; its own, and their weights.
layout(set = 0, binding = 0) uniform usamplerBuffer seams;  // two an invocation
layout(set = 0, binding = 1) uniform samplerBuffer trail_texels;
layout(r32f, set = 0, binding = 2) uniform writeonly imageBuffer trail_low;
layout(r32f, set = 0, binding = 3) uniform writeonly imageBuffer trail_high;

#include "texels.glsl"

void main() {
    uint i = invocation_index();
    if (i >= params.seam_count) return;
    // Four weights of 16 bits, in units of 1 / 32768.
    uvec4 source = texelFetch(seams, int(2u * i));
    uvec4 more = texelFetch(seams, int(2u * i + 1u));
    precise float value = float(more.y & 0xffffu) * texel_of(trail, source.x);
    value += float(more.y >> 16u) * texel_of(trail, source.y);
    value += float(more.z & 0xffffu) * texel_of(trail, source.z);
    value += float(more.z >> 16u) * texel_of(trail, source.w);
    precise float filled = value * (1.0 / 32768.0);
    store_texel(trail, more.x, vec4(filled))
}
