// atlas: where a point on the surface lies in the world atlas. Twin of src/sim/twin/trail.rs.

#ifndef MYXO_ATLAS
#define MYXO_ATLAS

// Atlas position, in texels, of a point on the surface.
vec2 atlas_position(AtlasMap map, float u, float v) {
    precise vec2 position = (map.origin + u * map.du) + v * map.dv;
    return position;
}

// The texel that holds a point.
uint texel_at(vec2 position, uint pitch) {
    return uint(position.y) * pitch + uint(position.x);
}

#endif
