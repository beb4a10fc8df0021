// across: atlas positions on other objects, packed into a word, 16 bits for each of X and Y: quarters of a texel, or halves in atlases so
// large that quarters do not fit. Twin of src/sim/field.rs.

#ifndef MYXO_ACROSS
#define MYXO_ACROSS

#include "atlas.glsl"

float parts_of_texel(uint pitch) {
    return pitch > 16384u ? 2.0 : 4.0;
}

uint packed_position(vec2 position, uint pitch) {
    precise vec2 in_parts = position * parts_of_texel(pitch);
    uvec2 part = whole(in_parts);
    return part.x | part.y << 16u;
}

// The middle of that part.
vec2 unpacked_position(uint word, uint pitch) {
    float size = pitch > 16384u ? 0.5 : 0.25;
    precise vec2 middle = (vec2(float(word & 0xffffu), float(word >> 16u)) + 0.5) * size;
    return middle;
}

#endif
