// field: reading the trail, and what is laid beside it, between texel centres. Twin: `trail_at` of src/sim/field.rs.

#ifndef MYXO_FIELD
#define MYXO_FIELD

#include "atlas.glsl"
#include "bilinear.glsl"
#include "texels.glsl"

// Bilinear over the four texels around. Gutter texels are filled, so no triangle needs its neighbours' texels.
float field_at(samplerBuffer field_texels, vec2 position, uint pitch) {
    Blend blend = blend_at(position, pitch);
    uint texel = blend.texel;
    vec4 values = vec4(
        texel_of(field, texel), texel_of(field, texel + 1u),
        texel_of(field, texel + pitch), texel_of(field, texel + pitch + 1u));
    return blended(values, blend.way);
}

#endif
