// nearest: the point of a triangle that is nearest to a place, and on which side of the surface the place lies. Twin of
// src/sim/twin/nearest.rs.
// The includer declares first: `faces` and `pseudonormals`, texel buffers of three words and one; and `corners` (uint[]).

#ifndef MYXO_NEAREST
#define MYXO_NEAREST

// What of a triangle is nearest: its inside, an edge (by its first corner) or a corner.
const uint FEATURE_FACE = 0u;
const uint FEATURE_EDGE = 1u;
const uint FEATURE_CORNER = 4u;

// The order of sums is the twin's; dot() may take any.
float dot_of(vec3 a, vec3 b) {
    precise float sum = (a.x * b.x + a.y * b.y) + a.z * b.z;
    return sum;
}

vec3 cross_of(vec3 a, vec3 b) {
    precise vec3 product = a.yzx * b.zxy - a.zxy * b.yzx;
    return product;
}

// The square of the length of way - u ab - v ac.
float square_of(vec3 way, vec3 ab, vec3 ac, float u, float v) {
    precise vec3 rest = (way - u * ab) - v * ac;
    return dot_of(rest, rest);
}

// The weights of B and C of the nearest point, the square of the distance and the feature that it lies on (as a float).
// One way through: devices that run both sides of every branch would pay for each region. The inside counts where the
// place projects into it; else the nearest of three points, one on each edge.
vec4 nearest_in_face(vec3 way, vec3 ab, vec3 ac) {
    float ab_way = dot_of(ab, way);
    float ac_way = dot_of(ac, way);
    float ab_ab = dot_of(ab, ab);
    float ab_ac = dot_of(ab, ac);
    float ac_ac = dot_of(ac, ac);

    precise float t_ab = clamp(ab_way / ab_ab, 0.0, 1.0);
    precise float t_ca = clamp(ac_way / ac_ac, 0.0, 1.0);
    precise float bc_way = (ac_way - ab_way) + (ab_ab - ab_ac);
    precise float bc_bc = (ab_ab - ab_ac) + (ac_ac - ab_ac);
    precise float t_bc = clamp(bc_way / bc_bc, 0.0, 1.0);
    precise float rest_bc = 1.0 - t_bc;
    float square_ab = square_of(way, ab, ac, t_ab, 0.0);
    float square_bc = square_of(way, ab, ac, rest_bc, t_bc);
    float square_ca = square_of(way, ab, ac, 0.0, t_ca);

    bool is_bc = square_bc < square_ab;
    float u = is_bc ? rest_bc : t_ab;
    float v = is_bc ? t_bc : 0.0;
    float square = is_bc ? square_bc : square_ab;
    bool is_ca = square_ca < square;
    u = is_ca ? 0.0 : u;
    v = is_ca ? t_ca : v;
    square = is_ca ? square_ca : square;
    uint feature = u == 0.0 && v == 0.0 ? FEATURE_CORNER
        : u == 1.0 ? FEATURE_CORNER + 1u
        : v == 1.0 ? FEATURE_CORNER + 2u
        : is_ca ? FEATURE_EDGE + 2u
        : is_bc ? FEATURE_EDGE + 1u : FEATURE_EDGE;

    precise float area = ab_ab * ac_ac - ab_ac * ab_ac;
    precise float inner_u = (ac_ac * ab_way - ab_ac * ac_way) / area;
    precise float inner_v = (ab_ab * ac_way - ab_ac * ab_way) / area;
    precise float inner_w = (1.0 - inner_u) - inner_v;
    float inner_square = square_of(way, ab, ac, inner_u, inner_v);
    // Of a needle, the inside is known less well than the edges.
    bool is_inner = inner_u > 0.0 && inner_v > 0.0 && inner_w > 0.0 && inner_square < square;
    return is_inner ? vec4(inner_u, inner_v, inner_square, float(FEATURE_FACE)) : vec4(u, v, square, float(feature));
}

vec3 face_word(uint slot, uint k) {
    return uintBitsToFloat(texelFetch(faces, int(3u * slot + k)).xyz);
}

uint triangle_of(uint slot) {
    return texelFetch(faces, int(3u * slot)).w;
}

// Is a face nearer than the nearest so far? Of equally near ones it is the one with the lowest triangle, so that the
// order in which they are looked at does not show.
bool is_nearer(float square, uint triangle, float best_square, uint best_triangle) {
    return square < best_square || (square == best_square && triangle < best_triangle);
}

// The nearest point of one face, as nearest_in_face says it.
vec4 nearest_on_face(uint slot, vec3 place) {
    precise vec3 way = place - face_word(slot, 0u);
    return nearest_in_face(way, face_word(slot, 1u), face_word(slot, 2u));
}

// Is a place outside, by the pseudonormal of the feature that is nearest to it?
// The way from a corner of the feature does as well as that from the nearest point, and is rounded less.
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
        uint vertex = corners[3u * triangle + (feature - FEATURE_CORNER)];
        normal = uintBitsToFloat(texelFetch(pseudonormals, int(first_vertex_normal + vertex)).xyz);
    } else if (feature >= FEATURE_EDGE) {
        normal = uintBitsToFloat(texelFetch(pseudonormals, int(3u * triangle + (feature - FEATURE_EDGE))).xyz);
    }
    return dot_of(way, normal) >= 0.0;
}

#endif
