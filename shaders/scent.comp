// scent: sums up again the scent of food and markers that sensors read, from the amounts left of each.
// Reads   scented, falloffs, meals.
// Writes  field, at every texel that any food or marker reaches, gutters too.
// One invocation per texel that is reached.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"
#include "tables.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Params {
    uint scented_count;
} params;

// The texel, and its first entry in the falloff table; one more at the end, with the end of the table.
layout(std430, set = 0, binding = 0) readonly buffer Scented { uvec2 scented[]; };
// The falloff table: the food, and the bits of its falloff there, 1 at its place and 0 at its radius.
layout(std430, set = 0, binding = 1) readonly buffer Falloffs { uvec2 falloffs[]; };
layout(std430, set = 0, binding = 2) readonly buffer Meals { Meal meals[]; };
WRITES(float, 3) field_low;
WRITES(float, 4) field_high;

#include "texels.glsl"

void main() {
    uint i = invocation_index();
    if (i >= params.scented_count) return;
    uint texel = scented[i].x;
    uint end = scented[i + 1u].y;
    precise float sum = 0.0;
    for (uint k = scented[i].y; k < end; k++) {
        uvec2 entry = falloffs[k];
        sum += meals[entry.x].scent * uintBitsToFloat(entry.y);
    }
    store_texel(field, texel, vec4(sum))
}
