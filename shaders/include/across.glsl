// across: atlas positions on other objects, packed into a word, 16 bits for each of X and Y: quarters of a texel, or halves
// where there are so many that quarters do not fit.
// Twin of src/sim/field.rs.

#ifndef MYXO_ACROSS
#define MYXO_ACROSS

#include "atlas.glsl"

float parts_of_texel(uint pitch) {
    return pitch > 16384u ? 2.0 : 4.0;
}

uint packed_position(vec2 position, uint pitch) {
    float parts = parts_of_texel(pitch);
    return uint(position.x * parts) | uint(position.y * parts) << 16u;
}

// The middle of that part.
vec2 unpacked_position(uint word, uint pitch) {
    return (vec2(float(word & 0xffffu), float(word >> 16u)) + 0.5) / parts_of_texel(pitch);
}

#endif
