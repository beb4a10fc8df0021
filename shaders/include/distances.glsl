// distances: reading signed distances between texel centres, as `field.glsl` reads the trail. Twin of
// src/sim/field.rs.
// The includer declares `distances` first, a table of floats.

#ifndef MYXO_DISTANCES
#define MYXO_DISTANCES

#include "tables.glsl"
#include "bilinear.glsl"

float distances_of(uint texel) {
    return fetch1(distances, texel);
}

// Bilinear over the four texels around, gutter texels among them.
float distance_at(vec2 position, uint pitch) {
    Blend blend = blend_at(position, pitch);
    uint texel = blend.texel;
    vec4 values = vec4(
        distances_of(texel), distances_of(texel + 1u),
        distances_of(texel + pitch), distances_of(texel + pitch + 1u));
    return blended(values, blend.way);
}

#endif
