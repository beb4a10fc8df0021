// strip_table: reading the table of triangles: edges, shape and place in the atlas of each. src/mesh/strip.rs fills it.
// The includer declares `strips` first, a table of eight times four words per triangle: three edges, the shape, two with its map to the atlas
// and the bins that its particles are sorted into, the texels of its frame's axes, and zeros.

#ifndef MYXO_STRIP_TABLE
#define MYXO_STRIP_TABLE

#include "tables.glsl"

// The words of an edge, by four times its triangle plus its corner.
uvec4 edge_words(uint edge) {
    return fetch4(strips, 8u * (edge >> 2u) + (edge & 3u));
}

// The shape, as float bits, and the object.
uvec4 shape_words(uint triangle) {
    return fetch4(strips, 8u * triangle + 3u);
}

AtlasMap atlas_map_of(uint triangle) {
    vec4 first = uintBitsToFloat(fetch4(strips, 8u * triangle + 4u));
    vec4 second = uintBitsToFloat(fetch4(strips, 8u * triangle + 5u));
    return AtlasMap(first.xy, first.zw, second.xy);
}

// Texels per world unit along the two axes of a triangle's frame.
mat2 texels_of_frame(uint triangle) {
    vec4 words = uintBitsToFloat(fetch4(strips, 8u * triangle + 6u));
    return mat2(words.xy, words.zw);
}

// The bin of the first tile of the atlas, and the step in bins to the next tile, in the row and, in the upper half, in the column.
uvec2 tile_bins_of(uint triangle) {
    return fetch4(strips, 8u * triangle + 5u).zw;
}

#endif
