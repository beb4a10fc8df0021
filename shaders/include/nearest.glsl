// nearest: the point of a triangle that is nearest to a place. Twin of src/mesh/trees/nearest.rs.
// The includer declares `faces` first, a table of four words.

#ifndef MYXO_NEAREST
#define MYXO_NEAREST

#include "tables.glsl"
#include "vectors.glsl"

// The nearest feature of a triangle: its inside, an edge (by its first corner) or a corner.
const uint FEATURE_FACE = 0u;
const uint FEATURE_EDGE = 1u;
const uint FEATURE_CORNER = 4u;

// A part of 1 by n / d; `by` is 1 / d, rounded so that d times it is not less than 1.
float part_by(float n, float by) {
    precise float part = n * by;
    return n > 0.0 ? min(part, 1.0) : 0.0;
}

// A vector minus u times one edge and v times the other.
vec3 rest_of(vec3 way, vec3 ab, vec3 ac, float u, float v) {
    precise vec3 rest = (way - u * ab) - v * ac;
    return rest;
}

// The weights of B and C of the nearest point, the square of the distance and the feature that it lies on (as a float).
// The sides from A to B and C have 1 over the squares of their lengths in w, `steep` that of the side from B to C; its other words
// are the normal over the square of its length, or zero if the triangle has no inside, so no division is needed here.
// No branches: devices that run both sides of every branch would pay for each region. If the place projects into the triangle, the point is
// inside; otherwise it is the nearest of three points, one on each edge.
vec4 nearest_in_face(vec3 way, vec4 ab_by, vec4 ac_by, vec4 steep) {
    vec3 ab = ab_by.xyz;
    vec3 ac = ac_by.xyz;
    precise vec3 bc = ac - ab;
    precise vec3 from_b = way - ab;
    float t_ab = part_by(dot_of(ab, way), ab_by.w);
    float t_ca = part_by(dot_of(ac, way), ac_by.w);
    float t_bc = part_by(dot_of(bc, from_b), steep.w);
    precise float rest_bc = 1.0 - t_bc;
    precise vec3 from_ab = way - t_ab * ab;
    precise vec3 from_bc = from_b - t_bc * bc;
    precise vec3 from_ca = way - t_ca * ac;
    float square_ab = dot_of(from_ab, from_ab);
    float square_bc = dot_of(from_bc, from_bc);
    float square_ca = dot_of(from_ca, from_ca);

    bool is_bc = square_bc < square_ab;
    float u = is_bc ? rest_bc : t_ab;
    float v = is_bc ? t_bc : 0.0;
    vec3 from_edge = is_bc ? from_bc : from_ab;
    float square = is_bc ? square_bc : square_ab;
    bool is_ca = square_ca < square;
    u = is_ca ? 0.0 : u;
    v = is_ca ? t_ca : v;
    from_edge = is_ca ? from_ca : from_edge;
    square = is_ca ? square_ca : square;
    uint feature = u == 0.0 && v == 0.0 ? FEATURE_CORNER
        : u == 1.0 ? FEATURE_CORNER + 1u
        : v == 1.0 ? FEATURE_CORNER + 2u
        : is_ca ? FEATURE_EDGE + 2u
        : is_bc ? FEATURE_EDGE + 1u : FEATURE_EDGE;

    // Continues from the nearest edge, by cross products with the normal, which keeps the precision for needle-shaped triangles.
    vec3 turned = cross_of(steep.xyz, from_edge);
    float more_u = dot_of(ac, turned);
    float more_v = -dot_of(ab, turned);
    precise float inner_u = u + more_u;
    precise float inner_v = v + more_v;
    precise float inner_w = (1.0 - inner_u) - inner_v;
    vec3 from_inner = rest_of(from_edge, ab, ac, more_u, more_v);
    float inner_square = dot_of(from_inner, from_inner);
    bool is_inner = inner_u > 0.0 && inner_v > 0.0 && inner_w > 0.0 && inner_square < square;
    return is_inner ? vec4(inner_u, inner_v, inner_square, float(FEATURE_FACE)) : vec4(u, v, square, float(feature));
}

vec3 face_word(uint slot, uint k) {
    return uintBitsToFloat(fetch4(faces, 4u * slot + k).xyz);
}

// `way` leads to the place from the face's first corner.
vec4 nearest_by_way(uint slot, vec3 way) {
    vec4 ab_by = uintBitsToFloat(fetch4(faces, 4u * slot + 1u));
    vec4 ac_by = uintBitsToFloat(fetch4(faces, 4u * slot + 2u));
    vec4 steep = uintBitsToFloat(fetch4(faces, 4u * slot + 3u));
    return nearest_in_face(way, ab_by, ac_by, steep);
}

uint triangle_of(uint slot) {
    return fetch4(faces, 4u * slot).w;
}

// Is a face nearer than the nearest so far? Of equally near ones the one with the lowest triangle counts as nearer, so that the order of
// the search does not matter.
bool is_nearer(float square, uint triangle, float best_square, uint best_triangle) {
    return square < best_square || (square == best_square && triangle < best_triangle);
}

// The nearest point of one face, in the form of nearest_in_face.
vec4 nearest_on_face(uint slot, vec3 place) {
    precise vec3 way = place - face_word(slot, 0u);
    return nearest_by_way(slot, way);
}

#endif
