// atlas: where a point on the surface lies in the world atlas. Twin of src/sim/field.rs.

#ifndef MYXO_ATLAS
#define MYXO_ATLAS

#include "strict.glsl"

// Atlas position, in texels, of a point on the surface.
vec2 atlas_position(AtlasMap map, float u, float v) {
    precise vec2 position = (map.origin + u * map.du) + v * map.dv;
    return position;
}

// The weights of B and C at an atlas position.
vec2 weights_at(AtlasMap map, vec2 position) {
    precise vec2 way = position - map.origin;
    precise float area = map.du.x * map.dv.y - map.du.y * map.dv.x;
    float by = reciprocal(area);
    precise float u = (way.x * map.dv.y - way.y * map.dv.x) * by;
    precise float v = (map.du.x * way.y - map.du.y * way.x) * by;
    return vec2(u, v);
}

// The texel that holds a point.
uint texel_at(vec2 position, uint pitch) {
    uvec2 texel = whole(position);
    return texel.y * pitch + texel.x;
}

#endif
