// atlas: where a point on the surface lies in the world atlas. Twin of src/sim/field.rs.

#ifndef MYXO_ATLAS
#define MYXO_ATLAS

// Atlas position, in texels, of a point on the surface.
vec2 atlas_position(AtlasMap map, float u, float v) {
    precise vec2 position = (map.origin + u * map.du) + v * map.dv;
    return position;
}

// The weights of B and C at an atlas position.
vec2 weights_at(AtlasMap map, vec2 position) {
    precise vec2 way = position - map.origin;
    precise float area = map.du.x * map.dv.y - map.du.y * map.dv.x;
    precise float u = (way.x * map.dv.y - way.y * map.dv.x) / area;
    precise float v = (map.du.x * way.y - map.du.y * way.x) / area;
    return vec2(u, v);
}

// The texel that holds a point.
uint texel_at(vec2 position, uint pitch) {
    return uint(position.y) * pitch + uint(position.x);
}

#endif
