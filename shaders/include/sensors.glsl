// sensors: what three sensors of a particle read together, whichever way the trail is bound. Twin of src/sim/twin/choices.rs.
// The includer declares `params` and defines SENSED(position) first, or TRAIL_OF(column, row) for a single texel.

#ifndef MYXO_SENSORS
#define MYXO_SENSORS

layout(set = 0, binding = 0) uniform samplerBuffer places;
layout(std430, set = 0, binding = 1) writeonly buffer Values { float values[]; };

#ifdef TRAIL_OF
// Bilinear over the four texels around, as in trail.glsl.
float between(vec2 position) {
    precise vec2 corner = position - 0.5;
    vec2 low = floor(corner);
    precise vec2 f = corner - low;
    uint x = uint(low.x);
    uint y = uint(low.y);
    float here = TRAIL_OF(x, y);
    float below = TRAIL_OF(x, y + 1u);
    precise float top = here + f.x * (TRAIL_OF(x + 1u, y) - here);
    precise float bottom = below + f.x * (TRAIL_OF(x + 1u, y + 1u) - below);
    precise float value = top + f.y * (bottom - top);
    return value;
}
#define SENSED(position) between(position)
#endif

// Two texels a particle: left and middle, right and nothing.
void read_sensors(uint i) {
    vec4 first = texelFetch(places, int(2u * i));
    vec4 second = texelFetch(places, int(2u * i + 1u));
    precise float sum = (SENSED(first.xy) + SENSED(first.zw)) + SENSED(second.xy);
    values[i] = sum;
}

#endif
