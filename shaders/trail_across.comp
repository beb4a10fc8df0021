// trail_across: where the trail crosses contacts, texels that another object covers take the trail of their place on that object, so that
// beside the line in which two surfaces meet each one spreads into the other.
// Reads   samples, distances, across, density, trail of owned texels.
// Writes  trail, at covered texels. It uses the trail of texels that nothing covers alone, so no invocation uses what another one writes.
// One invocation per sample; those of texels that nothing covers return at once.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"
#include "tables.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Params {
    uint sample_count;
    uint pitch;       // texels from one atlas row to the next
    float threshold;  // world length of signed distance below which a place is covered
    float deepest;    // the same up to which there are no places on other objects
} params;

READS(uvec4, 0) samples;  // one an invocation
READS(float, 1) distances;
READS(uint, 2) across;
READS(float, 3) trail_texels;
WRITES(float, 4) trail_low;
WRITES(float, 5) trail_high;
READS(float, 6) density_texels;

#include "texels.glsl"
#include "bilinear.glsl"
#include "across.glsl"

// 1 if a texel is owned, and nothing covers it. Gutters need not be filled between passes, and may be filled from covered texels.
float open_at(uint texel) {
    return texel_of(density, texel) > 0.0 && fetch1(distances, texel) >= params.threshold ? 1.0 : 0.0;
}

float trail_of(uint texel, float open) {
    return open > 0.0 ? texel_of(trail, texel) : 0.0;
}

// Takes the trail between the four texels round a place, as far as they are open; where none is, the texel keeps its own.
void take(uint texel, uint place) {
    Blend blend = blend_at(unpacked_position(place, params.pitch), params.pitch);
    uint first = blend.texel;
    uint below = first + params.pitch;
    vec4 open = vec4(open_at(first), open_at(first + 1u), open_at(below), open_at(below + 1u));
    vec4 values = vec4(
        trail_of(first, open.x), trail_of(first + 1u, open.y),
        trail_of(below, open.z), trail_of(below + 1u, open.w));
    precise vec2 rest = 1.0 - blend.way;
    precise vec2 upper = vec2(rest.x, blend.way.x) * rest.y;
    precise vec2 lower = vec2(rest.x, blend.way.x) * blend.way.y;
    precise vec4 weights = vec4(upper, lower) * open;
    precise float total = (weights.x + weights.y) + (weights.z + weights.w);
    if (total <= 0.0) return;
    // The difference to one of them is blended, so that a constant stays constant to the last bit.
    float base = open.x > 0.0 ? values.x : open.y > 0.0 ? values.y : open.z > 0.0 ? values.z : values.w;
    precise vec4 more = weights * (values - base);
    precise float sum = (more.x + more.y) + (more.z + more.w);
    float by_total = reciprocal(total);
    precise float value = base + sum * by_total;
    store_texel(trail, texel, vec4(settled(value)))
}

void main() {
    uint i = invocation_index();
    if (i >= params.sample_count) return;
    uint texel = fetch4(samples, i).w;
    float distance = fetch1(distances, texel);
    bool is_covered = params.deepest < distance && distance < params.threshold;
    if (!is_covered) return;
    uint place = fetch1(across, texel);
    if (place != NONE) take(texel, place);
}
