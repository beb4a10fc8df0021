// listed: the tiles whose distances are computed, and their samples, read as texels, which CPU drivers read faster than storage
// buffers. Twin: ListedTile and SurfaceSample of src/sim/types.rs.
// The includer declares `listed` and `samples` first, tables of four words.

#ifndef MYXO_LISTED
#define MYXO_LISTED

#include "tables.glsl"

ListedTile listed_tile(uint place) {
    uvec4 first = fetch4(listed, 2u * place);
    uvec4 second = fetch4(listed, 2u * place + 1u);
    return ListedTile(first.x, first.y, first.z, first.w, second.x, second.y, 0u, 0u);
}

SurfaceSample sample_at(uint i) {
    uvec4 word = fetch4(samples, i);
    return SurfaceSample(uintBitsToFloat(word.xyz), word.w);
}

#endif
