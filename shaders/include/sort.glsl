// sort: the places of particles in the order that keeps those near each other in the atlas together. Twin of src/sim/sorting.rs and
// src/sim/step/sort.rs.
// The includer declares `strips` (strip_table.glsl), `windows` and `params` with `particle_count`, `first`,
// `tile_shift` and `part_bits` first.

#ifndef MYXO_SORT
#define MYXO_SORT

#include "atlas.glsl"
#include "ring.glsl"
#include "strip_table.glsl"

// The particle's part of its bin, numbered through all bins. For the kernels that sort each part is a bin.
uint bin_of(uvec4 particle) {
    AtlasMap map = atlas_map_of(particle.x);
    uvec2 bins_of_tiles = tile_bins_of(particle.x);
    vec2 position = atlas_position(map, uintBitsToFloat(particle.y), uintBitsToFloat(particle.z));
    uvec2 texel = whole(position);
    uvec2 tile = texel >> params.tile_shift;
    uint bin = bins_of_tiles.x + tile.x * (bins_of_tiles.y & 0xffffu) + tile.y * (bins_of_tiles.y >> 16u);
    uvec2 part = (texel >> (params.tile_shift - params.part_bits)) & ((1u << params.part_bits) - 1u);
    return (((bin << params.part_bits) + part.y) << params.part_bits) + part.x;
}

// The slot of number i of the segment. Without windows there is one that begins at slot 0.
uint slot_of(uint i) {
    return ring_slot(windows[0].start, params.first + i, params.particle_count);
}

#endif
