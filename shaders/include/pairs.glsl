// pairs: the pairs of objects, read as texels, which CPU drivers read faster than storage buffers. Twin: ObjectPair of
// src/sim/types.rs.
// The includer declares `pairs` first, a table of four words.

#ifndef MYXO_PAIRS
#define MYXO_PAIRS

#include "tables.glsl"

ObjectPair pair_at(uint p) {
    uvec4 rest = fetch4(pairs, 4u * p + 3u);
    return ObjectPair(
        uintBitsToFloat(fetch4(pairs, 4u * p)),
        uintBitsToFloat(fetch4(pairs, 4u * p + 1u)),
        uintBitsToFloat(fetch4(pairs, 4u * p + 2u)),
        rest.x, rest.y, rest.z, rest.w);
}

#endif
