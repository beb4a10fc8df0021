// bloom_first: the bright light of a picture, cell by cell of 4 x 4 pixels: the finest level of the bloom.
// Reads   picture.
// Writes  bloom (its first level), flaws (atomically: pixels that were marked).
// One invocation per cell.
// Overflow: cannot happen; a cell has an element of its own, and pixels beyond the picture's edge are dark.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "index.glsl"
#include "tables.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Params {
    uint cell_count;
    uint across;      // cells in a row
    uint width;       // of the picture, pixels
    uint height;
    float threshold;  // light, 0 to 1, from which on pixels bloom
    float slope;      // over 1 / slope more they come to bloom wholly
    uint is_opaque;   // 1: every pixel has the alpha 255, unless its light was not a number
} params;

READS(uvec4, 0) picture;
WRITES(vec4, 1) bloom;
layout(std430, set = 0, binding = 2) buffer Flaws { uint flaws[]; };

#include "strict.glsl"
#include "developing.glsl"

void main() {
    uint i = invocation_index();
    if (i >= params.cell_count) return;
    uint column = i % params.across;
    uint row = i / params.across;
    vec3 sum = vec3(0.0);
    uint marked = 0u;
    for (uint y = 0u; y < 4u; y++) {
        uint line = 4u * row + y;
        uvec4 words = fetch4(picture, min(line, params.height - 1u) * params.across + column);
        for (uint x = 0u; x < 4u; x++) {
            bool is_inside = line < params.height && 4u * column + x < params.width;
            precise vec3 seen = bytes_of(words[x]) * PER_BYTE;
            // Nearly the light: the exponent of sRGB is 2.2 on the whole.
            precise vec3 light = seen * seen;
            float most = max(light.x, max(light.y, light.z));
            precise float over = most - params.threshold;
            precise float rise = over * params.slope;
            float share = is_inside ? within(rise, 0.0, 1.0) : 0.0;
            precise float weight = share * share;
            precise vec3 bright = light * weight;
            precise vec3 more = sum + bright;
            sum = more;
            marked += uint(is_inside && words[x] >> 24u != 255u);
        }
    }
    precise vec3 mean = sum * (1.0 / 16.0);
    store4(bloom, i, vec4(mean, 0.0));
    if (params.is_opaque * marked > 0u) atomicAdd(flaws[0], marked);
}
