// exchange_seams: fills the gutter from the texels across the seams, so that no read ever sees one.
// Reads   seams, owned texels of trail.
// Writes  gutter texels of trail; no gutter texel is used here; some are read together with owned texels, as part of a quad, and ignored.
// One invocation per gutter texel.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "index.glsl"
#include "tables.glsl"

layout(local_size_x = 64) in;


layout(push_constant) uniform Params {
    uint seam_count;
} params;

// Two texels per seam: four that it is filled from; its own, and their weights.
READS(uvec4, 0) seams;  // two an invocation
READS(float, 1) trail_texels;
WRITES(float, 2) trail_low;
WRITES(float, 3) trail_high;

#include "texels.glsl"

void main() {
    uint i = invocation_index();
    if (i >= params.seam_count) return;
    // Four weights of 16 bits, in units of 1 / 32768.
    uvec4 source = fetch4(seams, 2u * i);
    uvec4 more = fetch4(seams, 2u * i + 1u);
    precise float value = float(more.y & 0xffffu) * texel_of(trail, source.x);
    value += float(more.y >> 16u) * texel_of(trail, source.y);
    value += float(more.z & 0xffffu) * texel_of(trail, source.z);
    value += float(more.z >> 16u) * texel_of(trail, source.w);
    precise float filled = value * (1.0 / 32768.0);
    store_texel(trail, more.x, vec4(filled))
}
