// candidate: the signed distance to one other object, as the kernels `distance`, `distance_brute` and `distance_merge` compare it with that
// to others. Twin of src/sim/step/distance.rs. The includer declares what sign.glsl needs.

#ifndef MYXO_CANDIDATE
#define MYXO_CANDIDATE

#include "sign.glsl"
#include "distance.glsl"

// `slot` is the face that is nearest to the place, and `point` the nearest point on it.
float candidate_distance(ObjectPair pair, uint slot, vec3 place, vec4 point, float reach, uint first_vertex_normal) {
    float distance = root(point.z);
    // A place on the surface is outside: of two objects in one place, neither covers the other.
    bool outside = distance <= slack_of_tree(pair.first_node)
        || is_outside(pair.first_node, slot, place, point, first_vertex_normal);
    return clamped_distance(distance, outside, pair.is_closed == 1u, reach);
}

#endif
