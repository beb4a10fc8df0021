// sort: where particles come in the order in which they lie together in the atlas. Twin of src/sim/twin/sort.rs.
// The includer declares `particles` (texel buffer), `triangles`, `atlas_maps` and `params` first.

#ifndef MYXO_SORT
#define MYXO_SORT

#include "atlas.glsl"

// With windows, objects come one after the other; else tiles of the atlas alone count.
uint bin_of(uvec4 particle) {
    uint triangle = particle.x;
    AtlasMap map = AtlasMap(
        texelFetch(atlas_maps, int(3u * triangle)).xy,
        texelFetch(atlas_maps, int(3u * triangle + 1u)).xy,
        texelFetch(atlas_maps, int(3u * triangle + 2u)).xy);
    uvec2 texel = uvec2(atlas_position(map, uintBitsToFloat(particle.y), uintBitsToFloat(particle.z)));
    uint tile = (texel.y >> params.tile_shift) * params.tiles_a_row + (texel.x >> params.tile_shift);
    uint object = WINDOWS ? texelFetch(triangles, int(triangle)).w : 0u;
    return object * params.tile_count + tile;
}

#endif
