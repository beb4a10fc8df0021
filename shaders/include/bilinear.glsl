// bilinear: interpolation between texel centres. Twin: `trail_at` of src/sim/field.rs.

#ifndef MYXO_BILINEAR
#define MYXO_BILINEAR

#include "strict.glsl"

// The upper left one of the four texels round a position, and how far right of its centre and below it the position is.
struct Blend { uint texel; vec2 way; };

Blend blend_at(vec2 position, uint pitch) {
    precise vec2 corner = position - 0.5;
    vec2 low = floor(corner);
    precise vec2 way = corner - low;
    uvec2 texel = whole(low);
    return Blend(texel.y * pitch + texel.x, way);
}

// Blends the values of the upper two texels and of the lower two.
float blended(vec4 values, vec2 way) {
    precise float top = values.x + way.x * (values.y - values.x);
    precise float bottom = values.z + way.x * (values.w - values.z);
    precise float value = top + way.y * (bottom - top);
    return value;
}

#endif
