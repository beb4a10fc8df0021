// sign: on which side of a surface a place lies, by one of three rules. Twin of src/mesh/trees/sides.rs.
// The includer declares `dipoles` first, a table of two words; `SIGN_RULE`, one of the constants below; and what
// bvh.glsl needs.
//
// Pseudonormals are right on every closed mesh without crossings (Baerentzen and Aanaes 2005). Winding numbers are right also on meshes
// with holes, at a cost. The third rule is wrong in creases; it serves for comparison.

#ifndef MYXO_SIGN
#define MYXO_SIGN

#include "tables.glsl"
#include "bvh.glsl"
#include "loops.glsl"

const uint SIGN_PSEUDONORMAL = 0u;
const uint SIGN_WINDING = 1u;
const uint SIGN_FACING = 2u;

// From how many radii away faces together count as one dipole (Barill et al. 2018).
const float DIPOLE_FAR = 2.0;

// Is a place outside, by the pseudonormal of the feature that is nearest to it?
// The vector from a corner of the feature gives the same sign as that from the nearest point, and is rounded less.
bool outside_by_pseudonormal(uint slot, vec3 place, uint feature, uint first_vertex_normal) {
    vec3 ab = face_word(slot, 1u);
    vec3 ac = face_word(slot, 2u);
    uint triangle = triangle_of(slot);
    precise vec3 way = place - face_word(slot, 0u);
    bool from_b = feature == FEATURE_EDGE + 1u || feature == FEATURE_CORNER + 1u;
    bool from_c = feature == FEATURE_CORNER + 2u;
    way = from_b ? way - ab : from_c ? way - ac : way;
    vec3 normal = cross_of(ab, ac);
    if (feature >= FEATURE_CORNER) {
        uint vertex = fetch1(corners, 3u * triangle + (feature - FEATURE_CORNER));
        normal = uintBitsToFloat(fetch4(pseudonormals, first_vertex_normal + vertex).xyz);
    } else if (feature >= FEATURE_EDGE) {
        normal = uintBitsToFloat(fetch4(pseudonormals, 3u * triangle + (feature - FEATURE_EDGE)).xyz);
    }
    return dot_of(way, normal) >= 0.0;
}

// The solid angle of one face, positive from behind (van Oosterom and Strackee 1983).
float solid_angle(uint slot, vec3 place) {
    precise vec3 a = face_word(slot, 0u) - place;
    precise vec3 b = a + face_word(slot, 1u);
    precise vec3 c = a + face_word(slot, 2u);
    float length_a = length_of(a);
    float length_b = length_of(b);
    float length_c = length_of(c);
    float volume = dot_of(a, cross_of(b, c));
    precise float rest = ((length_a * length_b) * length_c + dot_of(a, b) * length_c)
        + (dot_of(b, c) * length_a + dot_of(c, a) * length_b);
    precise float angle = 2.0 * angle_of_vector(volume, rest);
    return abs(volume) < LEAST_SIZE ? 0.0 : angle;
}

// The solid angle of all faces of a tree; 4 pi from inside a closed mesh, 0 from outside.
float solid_angle_of_tree(uint root, vec3 place) {
    // One node is popped and two are pushed.
    uint stack[GREATEST_DEPTH + 1u];
    stack[0] = root;
    uint top = 1u;
    precise float sum = 0.0;
    while (top > 0u) {
        top--;
        uint node = stack[top];
        uvec4 centre = fetch4(dipoles, 2u * node);
        precise vec3 way = uintBitsToFloat(centre.xyz) - place;
        float square = dot_of(way, way);
        precise float near = DIPOLE_FAR * uintBitsToFloat(centre.w);
        precise float near_square = near * near;
        uint link = fetch4(nodes, 2u * node).w;
        if (square > near_square) {
            vec3 normal = uintBitsToFloat(fetch4(dipoles, 2u * node + 1u).xyz);
            float by = inverse_root(square);
            precise float part = ((dot_of(normal, way) * by) * by) * by;
            sum += part;
        } else if (link < LEAF) {
            stack[top] = link;
            stack[top + 1u] = link + 1u;
            top += 2u;
        } else {
            uint end = (link % LEAF) + link / LEAF;
            for (uint slot = link % LEAF; slot < end; slot++) {
                sum += solid_angle(slot, place);
            }
        }
    }
    return sum;
}

// Does a face look towards a place?
bool faces_place(uint slot, vec3 place) {
    precise vec3 way = place - face_word(slot, 0u);
    return dot_of(way, cross_of(face_word(slot, 1u), face_word(slot, 2u))) > 0.0;
}

// Of the faces that are as near as the nearest, but for rounding, does any face look towards a place?
bool any_nearest_faces_place(uint root, vec3 place, float distance) {
    uint stack[GREATEST_DEPTH + 1u];
    stack[0] = root;
    uint top = 1u;
    uvec4 root_low = fetch4(nodes, 2u * root);
    float limit = limit_of(distance, slack_of(root_low, fetch4(nodes, 2u * root + 1u)));
    bool any_does = false;
    while (top > 0u && !any_does) {
        top--;
        uint node = stack[top];
        uvec4 low = fetch4(nodes, 2u * node);
        vec3 high = uintBitsToFloat(fetch4(nodes, 2u * node + 1u).xyz);
        bool is_far = box_square(place, uintBitsToFloat(low.xyz), high) > limit;
        if (!is_far && low.w < LEAF) {
            stack[top] = low.w;
            stack[top + 1u] = low.w + 1u;
            top += 2u;
        } else if (!is_far) {
            uint end = (low.w % LEAF) + low.w / LEAF;
            for (uint slot = low.w % LEAF; slot < end; slot++) {
                any_does = any_does || (nearest_on_face(slot, place).z <= limit && faces_place(slot, place));
            }
        }
    }
    return any_does;
}

// Is a place outside an object? `tree` is the first node of its tree, `slot` the nearest face, and `point` the nearest point on it.
bool is_outside(uint tree, uint slot, vec3 place, vec4 point, uint first_vertex_normal) {
    bool outside = true;
    if (SIGN_RULE == SIGN_WINDING) outside = solid_angle_of_tree(tree, place) < 6.28318530718;  // half of the whole sphere
    if (SIGN_RULE == SIGN_FACING) outside = any_nearest_faces_place(tree, place, root(point.z));
    // The nearest feature needs no search, so it decides also if a search has not ended.
    bool by_feature = SIGN_RULE == SIGN_PSEUDONORMAL || !searches_ended();
    // Features are 0 to 6, exactly.
    return by_feature ? outside_by_pseudonormal(slot, place, uint(point.w), first_vertex_normal) : outside;
}

#endif
