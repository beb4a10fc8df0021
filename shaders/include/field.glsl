// field: reading the trail, and other fields of the atlas, between texel centres. Twin: `trail_at` of src/sim/field.rs.

#ifndef MYXO_FIELD
#define MYXO_FIELD

#include "atlas.glsl"
#include "bilinear.glsl"
#include "texels.glsl"

// Declares the function NAME_at, bilinear over the four texels around. Gutter texels are filled, so no triangle needs its
// neighbours' texels.
#define FIELD(name) \
    float name##_at(vec2 position, uint pitch) { \
        Blend blend = blend_at(position, pitch); \
        uint texel = blend.texel; \
        vec4 values = vec4( \
            texel_of(name, texel), texel_of(name, texel + 1u), \
            texel_of(name, texel + pitch), texel_of(name, texel + pitch + 1u)); \
        return blended(values, blend.way); \
    }

#endif
