// trail: reading the trail between texel centres. Twin of src/sim/twin/trail.rs.
// The includer declares `trail` first, and what texels.glsl asks for.

#ifndef MYXO_TRAIL
#define MYXO_TRAIL

#include "atlas.glsl"
#include "texels.glsl"

float trail_of(uint texel) {
    return texel_of(trail, texel);
}

// Bilinear over the four texels around. Gutter texels are filled, so no triangle needs its neighbours' texels.
float trail_at(vec2 position, uint pitch) {
    precise vec2 corner = position - 0.5;
    vec2 low = floor(corner);
    precise vec2 f = corner - low;
    uint texel = uint(low.y) * pitch + uint(low.x);
    precise float top = trail_of(texel) + f.x * (trail_of(texel + 1u) - trail_of(texel));
    precise float bottom = trail_of(texel + pitch) + f.x * (trail_of(texel + pitch + 1u) - trail_of(texel + pitch));
    precise float value = top + f.y * (bottom - top);
    return value;
}

#endif
