// direction: directions of vectors that may have no length: triangles may be so thin that numbers cannot tell their sides apart.
// Twin of src/sim/direction.rs.

#ifndef MYXO_DIRECTION
#define MYXO_DIRECTION

#include "vectors.glsl"

// The smallest number that every device calculates with: a smaller square may count as zero.
const float LEAST_SQUARE = 1.17549435e-38;

// In a triangle's tangent frame: along AB if the vector is too short.
vec2 flat_direction(vec2 way) {
    return dot(way, way) >= LEAST_SQUARE ? normalize(way) : vec2(1.0, 0.0);
}

// Some direction that is at right angles to another one.
vec3 perpendicular(vec3 direction) {
    vec3 axis = abs(direction.x) < 0.5 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0);
    return normalize(cross(direction, axis));
}

#endif
