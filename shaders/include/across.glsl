// across: atlas positions on other objects, packed into a word: quarters of a texel, 16 bits for each of X and Y.
// Twin of src/sim/twin/trail.rs.

#ifndef MYXO_ACROSS
#define MYXO_ACROSS

#include "atlas.glsl"

uint packed_position(vec2 position) {
    return uint(position.x * 4.0) | uint(position.y * 4.0) << 16u;
}

// The middle of that quarter.
vec2 unpacked_position(uint word) {
    return (vec2(float(word & 0xffffu), float(word >> 16u)) + 0.5) * 0.25;
}

#endif
