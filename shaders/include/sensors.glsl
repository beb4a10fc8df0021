// sensors: the readings of the three sensors of a particle, for any kind of binding of the trail. Twin of examples/choices/twins.rs.
// The includer declares `params` and defines SENSED(position) first, or TRAIL_OF(column, row) for a single texel.

#ifndef MYXO_SENSORS
#define MYXO_SENSORS

#include "bilinear.glsl"

layout(set = 0, binding = 0) uniform samplerBuffer places;
layout(std430, set = 0, binding = 1) writeonly buffer Values { float values[]; };

#ifdef TRAIL_OF
// Bilinear over the four texels around, as in field.glsl.
float between(vec2 position) {
    precise vec2 corner = position - 0.5;
    uvec2 low = uvec2(floor(corner));
    precise vec2 way = corner - floor(corner);
    vec4 values = vec4(
        TRAIL_OF(low.x, low.y), TRAIL_OF(low.x + 1u, low.y),
        TRAIL_OF(low.x, low.y + 1u), TRAIL_OF(low.x + 1u, low.y + 1u));
    return blended(values, way);
}
#define SENSED(position) between(position)
#endif

// Two texels per particle: left and middle, right and nothing.
void read_sensors(uint i) {
    vec4 first = texelFetch(places, int(2u * i));
    vec4 second = texelFetch(places, int(2u * i + 1u));
    precise float sum = (SENSED(first.xy) + SENSED(first.zw)) + SENSED(second.xy);
    values[i] = sum;
}

#endif
