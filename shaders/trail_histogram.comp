// trail_histogram: histogram of the trail's brightness by area, for the exposure of a picture.
// Reads   trail, density.
// Writes  histogram (atomically; the order does not show).
// One invocation per sampled texel: every stride-th of the atlas.
// Overflow: cannot happen; a bin can hold every sampled texel, each with the largest area that one counts.
#version 460
#include "index.glsl"
#include "tables.glsl"
#include "exposure.glsl"

layout(local_size_x = 256) in;


READS(float, 0) trail_texels;
READS(float, 1) density_texels;
layout(set = 0, binding = 2) buffer Histogram { uint histogram[]; };

layout(push_constant) uniform Params {
    uint sample_count;  // texels that are counted
    uint stride;        // texels from one to the next
} params;

#include "texels.glsl"

void main() {
    uint i = invocation_index();
    if (i >= params.sample_count) return;
    uint texel = i * params.stride;
    // Texels without a triangle, and gutter texels, have no density.
    if (texel_of(density, texel) == 0.0) return;
    uint area = area_of(texel_of(density, texel));
    atomicAdd(histogram[bin_of(texel_of(trail, texel))], area);
}
