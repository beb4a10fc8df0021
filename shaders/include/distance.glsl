// distance: constants and functions of the kernels of signed distance. Twin of src/sim/step/distance.rs.

#ifndef MYXO_DISTANCE
#define MYXO_DISTANCE

#include "vectors.glsl"

// As in src/sim/distance.rs: neighbouring samples share one hint for each other object: a face that is near.
const uint TILE_SAMPLES = 16u;

// Instead of a face: all of a tile is beyond reach, outside or inside of a closed object; or unknown.
const uint TILE_OUTSIDE = 0xffffffffu;
const uint TILE_INSIDE = 0xfffffffeu;
const uint TILE_UNKNOWN = 0xfffffffdu;

// State of a tile: its hints do not decide all pairs.
const uint TILE_UNDECIDED = 0xfffffffcu;

// Faces that a tile has room for, of all pairs together.
const uint TILE_CANDIDATES = 32u;

// A hint from here on, but for those above, is no face but a part of the tile's candidates: LIST + 256 * first + end.
const uint LIST = 1u << 28u;

// A place in the space of a pair's other object.
vec3 place_in_other(ObjectPair pair, vec3 place) {
    return vec3(along(pair.x, place), along(pair.y, place), along(pair.z, place));
}

// The signed distance to an object whose nearest face is known, clamped to reach, as it is compared with that to others.
// Deep inside a closed object is deep inside; far over an open sheet there is no side.
float clamped_distance(float distance, bool outside, bool is_closed, float reach) {
    bool within = distance < reach;
    float clamped = within ? distance : reach;
    return outside || !(within || is_closed) ? clamped : -clamped;
}

#endif
