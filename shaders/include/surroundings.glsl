// surroundings: facts about each texel, packed into half a word so that one read returns all: 8 bits of outlook, which is the
// distance up to which places of its hue can be reached straight; whether other objects are near, cover it, or are in sight; and
// 5 bits of hue, which differs between charts that lie near each other.
// Twin of src/sim/surroundings.rs.

#ifndef MYXO_SURROUNDINGS
#define MYXO_SURROUNDINGS

#include "vectors.glsl"

const uint OUTLOOK = 255u;
const uint HUE = 0xf800u;
// A step from here may lead to a place where particles change objects.
const uint NEAR = 256u;
// Walks that get here continue on another object.
const uint COVERED = 512u;
// Sensors that walk from here may get to where another object covers the surface.
const uint IN_SIGHT = 1024u;

// Does the path between two such places, `way` in texels, stay on the surface?
bool is_clear(vec2 way, float unit, uint start, uint end) {
    precise float farthest = unit * float(max(start & OUTLOOK, end & OUTLOOK));
    precise float most = farthest * farthest;
    return (start & HUE) != 0u && ((start ^ end) & HUE) == 0u && dot_of(way, way) <= most;
}

// The surroundings of a texel, from the word that it shares with another one.
uint surroundings_in(uint word, uint texel) {
    return (word >> (16u * (texel & 1u))) & 0xffffu;
}

// Others write the other half of the word at the same time. Few texels change, so few are written.
#define MARK(surroundings, texel, marked) \
{ \
    uint changed = (surroundings_in(surroundings[(texel) >> 1u], texel) ^ (marked)) & (NEAR | COVERED | IN_SIGHT); \
    if (changed != 0u) atomicXor(surroundings[(texel) >> 1u], changed << (16u * ((texel) & 1u))); \
}

// Marks of a texel at a distance: places as deep as `deepest` or deeper, and those not below the threshold, are
// not covered.
uint marks_at(float distance, float deepest, float threshold, float near, float sight) {
    uint how_near = (distance < near ? NEAR : 0u) | (distance < sight ? IN_SIGHT : 0u);
    return how_near | (deepest < distance && distance < threshold ? COVERED : 0u);
}

#endif
