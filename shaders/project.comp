// project: adds to the trail what food projects into it, before the trail spreads.
// Reads   projected, meals, deposits, trail.
// Writes  trail, at texels at which food is projected.
// One invocation per such texel; no two have the same.
// Food that is eaten projects less, by the levels of its scent, and in the end nothing.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"
#include "tables.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Params {
    uint projected_count;
    uint pitch;     // texels from one atlas row to the next
    float covered;  // the share that remains where particles are on the texel or beside it
} params;

// As in digest.comp.
const uint LEVELS = 64u;

// The texel, which is owned, and its food.
layout(std430, set = 0, binding = 0) readonly buffer Projected { uvec2 projected[]; };  // one an invocation
layout(std430, set = 0, binding = 1) readonly buffer Meals { Meal meals[]; };
READS(uint, 2) deposits_texels;
READS(float, 3) trail_texels;
WRITES(float, 4) trail_low;
WRITES(float, 5) trail_high;

#include "texels.glsl"

// Did any particle deposit on the texel in this step, or on the eight around it? They lie in its chart or in the gutter.
bool is_covered(uint texel) {
    uint corner = (texel - params.pitch) - 1u;
    uint counted = 0u;
    for (uint k = 0u; k < 9u; k++) {
        counted |= texel_of(deposits, corner + (k / 3u) * params.pitch + k % 3u);
    }
    return counted != 0u;
}

void main() {
    uint i = invocation_index();
    if (i >= params.projected_count) return;
    uint texel = projected[i].x;
    Meal meal = meals[projected[i].y];
    precise float amount = meal.projection * (float(meal.level) * (1.0 / float(LEVELS)));
    precise float damped = amount * params.covered;
    bool is_damped = params.covered < 1.0 && is_covered(texel);
    precise float value = texel_of(trail, texel) + (is_damped ? damped : amount);
    store_texel(trail, texel, vec4(value))
}
