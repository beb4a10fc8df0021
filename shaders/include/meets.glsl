// meets: whether two triangles are so near to one another that their distance matters. Twin of
// src/sim/step/distance_raster.rs.
// The includer declares what bvh.glsl needs.

#ifndef MYXO_MEETS
#define MYXO_MEETS

#include "tables.glsl"
#include "bvh.glsl"

// Returns whether a triangle in the ball round `centre`, in the other object's space, may have places whose distance to a triangle
// in the ball `other_bound` matters. Beyond the reach only places in the other object's box have a side. Rounding takes a margin.
bool meet(uint root, vec3 centre, float radius, vec4 other_bound, float reach, float farthest) {
    uvec4 low = fetch4(nodes, 2u * root);
    uvec4 high = fetch4(nodes, 2u * root + 1u);
    float slack = 4.0 * slack_of(low, high);
    precise float to_box = 1.001 * radius + slack;
    bool may_be_inside = box_square(centre, uintBitsToFloat(low.xyz), uintBitsToFloat(high.xyz)) <= to_box * to_box;
    precise float limit = 1.001 * (radius + other_bound.w + (may_be_inside ? farthest : reach)) + slack;
    precise vec3 way = centre - other_bound.xyz;
    return dot_of(way, way) <= limit * limit;
}

#endif
