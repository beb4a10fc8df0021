// sort: where particles come in the order in which they lie together in the atlas. Twin of src/sim/step/sort.rs.
// The includer declares `particles` (texel buffer), `strips` (strip_table.glsl) and `params` first.

#ifndef MYXO_SORT
#define MYXO_SORT

#include "atlas.glsl"
#include "strip_table.glsl"

// With windows, objects come one after the other; else tiles of the atlas alone count.
uint bin_of(uvec4 particle) {
    uint triangle = particle.x;
    AtlasMap map = atlas_map_of(triangle);
    uvec2 texel = uvec2(atlas_position(map, uintBitsToFloat(particle.y), uintBitsToFloat(particle.z)));
    uint tile = (texel.y >> params.tile_shift) * params.tiles_a_row + (texel.x >> params.tile_shift);
    uint object = WINDOWS ? shape_words(triangle).w : 0u;
    return object * params.tile_count + tile;
}

#endif
