// frame: triangles in the space of their object, and their nearest points. Twin of src/sim/ground.rs.
// The includer declares `corners` and `vertices` first, tables: vertex indices one by one and a texel per vertex.

#ifndef MYXO_FRAME
#define MYXO_FRAME

#include "tables.glsl"
#include "direction.glsl"

// A triangle's corner A, the axes of its tangent frame and its unit normal, object space.
struct Frame { vec3 origin; vec3 p; vec3 h; vec3 normal; };

vec3 corner_position(uint triangle, uint corner) {
    uint vertex = fetch1(corners, 3u * triangle + corner);
    return uintBitsToFloat(fetch4(vertices, vertex).xyz);
}

Frame frame_of(uint triangle) {
    vec3 a = corner_position(triangle, 0u);
    precise vec3 ab = corner_position(triangle, 1u) - a;
    precise vec3 ac = corner_position(triangle, 2u) - a;
    vec3 p = direction_or(ab, vec3(1.0, 0.0, 0.0));
    vec3 normal = direction_or(cross_of(ab, ac), perpendicular(p));
    return Frame(a, p, cross_of(normal, p), normal);
}

// The weights of B and C at the point of a triangle that is nearest to (x, y) of its tangent frame.
vec2 nearest_weights(float ab, float cp, float ch, float x, float y) {
    float v = quotient(y, ch);
    precise float along = x - v * cp;
    float u = quotient(along, ab);
    precise float both = u + v;
    if (u >= 0.0 && v >= 0.0 && both <= 1.0) return vec2(u, v);
    // The nearest point of each edge, as a share of the way along it.
    precise float from_b = x - ab;
    precise float bc_x = cp - ab;
    float on_ab = share(x, ab);
    float on_bc = share(dot_of(vec2(from_b, y), vec2(bc_x, ch)), dot_of(vec2(bc_x, ch), vec2(bc_x, ch)));
    float on_ac = share(dot_of(vec2(x, y), vec2(cp, ch)), dot_of(vec2(cp, ch), vec2(cp, ch)));
    precise vec2 to_ab = vec2(x - on_ab * ab, y);
    precise vec2 to_bc = vec2(from_b, y) - on_bc * vec2(bc_x, ch);
    precise vec2 to_ac = vec2(x, y) - on_ac * vec2(cp, ch);
    float ab_square = dot_of(to_ab, to_ab);
    float bc_square = dot_of(to_bc, to_bc);
    float ac_square = dot_of(to_ac, to_ac);
    precise float rest_bc = 1.0 - on_bc;
    if (ab_square <= bc_square && ab_square <= ac_square) return vec2(on_ab, 0.0);
    return bc_square <= ac_square ? vec2(rest_bc, on_bc) : vec2(0.0, on_ac);
}

#endif
