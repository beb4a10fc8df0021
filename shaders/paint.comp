// paint: one dab of a brush on a field of the surface: the trail, or the bias that sensors read with it.
// Reads   dab, field.
// Writes  field, at the texels of the dab; each texel is listed once.
// One invocation per texel of the dab.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "index.glsl"
#include "tables.glsl"

layout(local_size_x = 64) in;


layout(push_constant) uniform Params {
    uint texel_count;
    float fade;      // share of the field that is taken away where the weight is 1
    float amount;    // what is added there
    float lowest;    // lower bound of the field
    float highest;   // upper bound, unless it was higher before
    float no_go;     // a field below this is no-go, which fading removes wholly
} params;

// The texel, and the bits of its weight, 0 to 1.
layout(std430, set = 0, binding = 0) readonly buffer Dab { uvec2 dab[]; };  // one an invocation
READS(float, 1) field_texels;
WRITES(float, 2) field_low;
WRITES(float, 3) field_high;

#include "strict.glsl"
#include "texels.glsl"

// As TINY_TRAIL in src/sim/spread.rs.
const float FAINTEST = 1.0e-20;

void main() {
    uint i = invocation_index();
    if (i >= params.texel_count) return;
    uint texel = dab[i].x;
    float weight = uintBitsToFloat(dab[i].y);
    float before = texel_of(field, texel);
    precise float kept = before * (1.0 - params.fade * weight);
    bool is_freed = before < params.no_go && params.fade > 0.0;
    precise float value = (is_freed ? 0.0 : kept) + params.amount * weight;
    value = within(value, params.lowest, max(before, params.highest));
    // Repeated erasing would give values so small that some devices flush them to zero.
    store_texel(field, texel, vec4(abs(value) < FAINTEST ? 0.0 : value))
}
