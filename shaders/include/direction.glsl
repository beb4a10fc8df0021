// direction: directions in and across tangent frames. Twin of src/sim/direction.rs.

#ifndef MYXO_DIRECTION
#define MYXO_DIRECTION

#include "vectors.glsl"

// In a triangle's tangent frame: along AB if the vector is too short.
vec2 flat_direction(vec2 way) {
    return direction_or(way, vec2(1.0, 0.0));
}

// Some direction that is at right angles to another one.
vec3 perpendicular(vec3 direction) {
    vec3 axis = abs(direction.x) < 0.5 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0);
    return direction_or(cross_of(direction, axis), axis);
}

#endif
