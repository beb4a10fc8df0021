// walk: the straightest path on the surface, in the tangent frame. Twin of src/sim/walker.rs.
// Straight in each triangle; over an edge the point keeps its place on the edge and the heading turns by the stored
// rotation. No world coordinates, no trigonometry, so nothing drifts off the surface.
// The includer declares `triangles` and `halfedges` first: tables of the structs' four words; and `const bool WALK_CARRIES`.
//
// Each crossing rounds, and over hundreds of edges that adds up to a millionth of the way, which is small enough for particles. With
// WALK_CARRIES, the rounding errors of a walker's numbers are carried along, and long walks are as exact as short ones.

#ifndef MYXO_WALK
#define MYXO_WALK

#include "tables.glsl"
#include "exact.glsl"
#include "strict.glsl"

const uint WALK_DONE = 0u;
const uint WALK_BORDER = 1u;
const uint WALK_OUT_OF_ATTEMPTS = 2u;

// The step of HalfEdge.fine: 32,767 of them are half of the largest value of a cosine's last bit.
const float FINE_STEP = 9.095225e-13;

struct Walker {
    uint triangle;
    float weight_a;   // the three barycentric weights; u is weight_b, v is weight_c
    float weight_b;
    float weight_c;
    float heading_p;
    float heading_h;
    float remaining;  // world length still to walk
    uint entered_by;  // corner whose half-edge it came in by, NONE at the start
    uint status;
    float carry_a;    // the rounding errors of the numbers above, with WALK_CARRIES
    float carry_b;
    float carry_c;
    float carry_p;
    float carry_h;
    float carry_remaining;
};

Walker walker_at(uint triangle, float u, float v, vec2 heading, float length) {
    precise float weight_a = (1.0 - u) - v;
    return Walker(triangle, positive(weight_a), u, v, heading.x, heading.y, length, NONE, WALK_DONE,
        0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
}

// A weight after some way, and its carry.
vec2 moved(float weight, float carry, float rate, float distance) {
    precise float change = rate * distance;
    if (WALK_CARRIES) {
        precise float carried = change + carry;
        vec2 sum = exact_sum(weight, carried);
        return sum.x > 0.0 ? sum : vec2(0.0);
    }
    precise float sum = weight + change;
    return vec2(positive(sum), 0.0);
}

// One minus a place on an edge, and its carry.
vec2 from_other_end(vec2 along) {
    if (WALK_CARRIES) {
        vec2 rest = exact_sum(1.0, -along.x);
        precise float carry = rest.y - along.y;
        return vec2(rest.x, carry);
    }
    precise float rest = 1.0 - along.x;
    return vec2(rest, 0.0);
}

// The remaining length after a distance, and its carry.
vec2 shortened(float remaining, float carry, float distance) {
    if (WALK_CARRIES) {
        precise float way = distance - carry;
        precise float rest = remaining - way;
        float left = positive(rest);
        precise float dropped = (remaining - left) - way;
        return vec2(left, dropped);
    }
    precise float left = remaining - distance;
    return vec2(left, 0.0);
}

// A heading and its carry after a rotation: p, h, and the rounding error of each.
vec4 turned_by(vec2 heading, vec2 carry, vec2 rotation, uint fine) {
    if (WALK_CARRIES) {
        precise vec2 more = FINE_STEP * vec2(float(int(fine << 16u) >> 16), float(int(fine) >> 16));
        vec2 cos_p = exact_product(rotation.x, heading.x);
        vec2 sin_p = exact_product(rotation.y, heading.x);
        vec2 cos_h = exact_product(rotation.x, heading.y);
        vec2 sin_h = exact_product(rotation.y, heading.y);
        vec2 p = exact_sum(cos_p.x, -sin_h.x);
        vec2 h = exact_sum(sin_p.x, cos_h.x);
        precise float dropped_p = p.y + (cos_p.y - sin_h.y);
        precise float dropped_h = h.y + (sin_p.y + cos_h.y);
        dropped_p += rotation.x * carry.x - rotation.y * carry.y;
        dropped_h += rotation.y * carry.x + rotation.x * carry.y;
        dropped_p += more.x * heading.x - more.y * heading.y;
        dropped_h += more.y * heading.x + more.x * heading.y;
        p = exact_sum(p.x, dropped_p);
        h = exact_sum(h.x, dropped_h);
        return vec4(p.x, h.x, p.y, h.y);
    }
    precise float p = rotation.x * heading.x - rotation.y * heading.y;
    precise float h = rotation.y * heading.x + rotation.x * heading.y;
    return vec4(p, h, 0.0, 0.0);
}

// Walks what remains, over at most `attempts` edges. Reflections at open borders count as crossings.
// The loop has one path and one exit: devices that run both sides of every branch pay for each of them.
void walk(inout Walker w, uint attempts, bool reflects) {
    bool crosses = true;
    while (crosses) {
        vec3 shape = uintBitsToFloat(fetch4(triangles, w.triangle).xyz);
        float ab = shape.x;
        float cp = shape.y;
        float ch = shape.z;
        float rate_c = quotient(w.heading_h, ch);
        precise float rest_p = w.heading_p - rate_c * cp;
        float rate_b = quotient(rest_p, ab);
        precise float rate_a = -rate_b - rate_c;

        // The half-edge of corner k lies opposite corner k + 2: it is reached when that corner's weight is zero.
        // The half-edge that the walk entered by is excluded: rounding must not send it straight back. If a walk approaches an edge so
        // slowly that its rate counts as zero, it does not reach that edge.
        bool towards_ab = rate_c < -LEAST_SIZE && w.entered_by != 0u;
        bool towards_bc = rate_a < -LEAST_SIZE && w.entered_by != 1u;
        bool towards_ca = rate_b < -LEAST_SIZE && w.entered_by != 2u;
        float to_ab = towards_ab ? quotient(w.weight_c, -rate_c) : w.remaining;
        float to_bc = towards_bc ? quotient(w.weight_a, -rate_a) : w.remaining;
        float to_ca = towards_ca ? quotient(w.weight_b, -rate_b) : w.remaining;
        float distance = min(min(to_ab, to_bc), min(to_ca, w.remaining));
        bool ends = distance == w.remaining;
        uint corner = to_ab == distance ? 0u : to_bc == distance ? 1u : 2u;

        vec2 a = moved(w.weight_a, w.carry_a, rate_a, distance);
        vec2 b = moved(w.weight_b, w.carry_b, rate_b, distance);
        vec2 c = moved(w.weight_c, w.carry_c, rate_c, distance);
        vec2 remaining = shortened(w.remaining, w.carry_remaining, distance);

        // The position on the half-edge, measured from its start. On the twin, start and end are exchanged; at an open border the
        // half-edge is its own twin.
        uvec4 edge = fetch4(halfedges, 3u * w.triangle + corner);
        uint twin = edge.x;
        vec2 rotation = uintBitsToFloat(edge.yz);
        bool at_border = twin == NONE;
        bool stops = ends || attempts == 0u || (at_border && !reflects);
        bool stays = stops || at_border;
        vec2 along = corner == 0u ? b : corner == 1u ? c : a;
        if (WALK_CARRIES) {
            // The weight that has changed less is the more exact one of the two on the edge; in a needle it is far more exact.
            float end_rate = corner == 0u ? rate_b : corner == 1u ? rate_c : rate_a;
            float start_rate = corner == 0u ? rate_a : corner == 1u ? rate_b : rate_c;
            vec2 from_start = from_other_end(corner == 0u ? a : corner == 1u ? b : c);
            along = abs(start_rate) < abs(end_rate) ? from_start : along;
            along = along.x < 0.0 ? vec2(0.0) : along.x > 1.0 ? vec2(1.0, 0.0) : along;
        }
        along.x = min(along.x, 1.0);
        vec2 rest = from_other_end(along);
        uint next_corner = stays ? corner : twin % 3u;
        vec2 start = stays ? rest : along;
        vec2 end = stays ? along : rest;
        a = ends ? a : next_corner == 0u ? start : next_corner == 2u ? end : vec2(0.0);
        b = ends ? b : next_corner == 1u ? start : next_corner == 0u ? end : vec2(0.0);
        c = ends ? c : next_corner == 2u ? start : next_corner == 1u ? end : vec2(0.0);
        w.weight_a = a.x; w.carry_a = a.y;
        w.weight_b = b.x; w.carry_b = b.y;
        w.weight_c = c.x; w.carry_c = c.y;
        w.remaining = WALK_CARRIES && ends ? 0.0 : remaining.x;
        w.carry_remaining = ends ? 0.0 : remaining.y;
        w.status = ends ? WALK_DONE : at_border && !reflects ? WALK_BORDER : WALK_OUT_OF_ATTEMPTS;
        crosses = !stops;

        // At a border (cos, sin) is the direction of the edge, doubled, which mirrors the heading with its h negated.
        vec2 heading = vec2(w.heading_p, at_border ? -w.heading_h : w.heading_h);
        vec2 carry = vec2(w.carry_p, at_border ? -w.carry_h : w.carry_h);
        vec4 turned = turned_by(heading, carry, rotation, edge.w);
        w.heading_p = crosses ? turned.x : w.heading_p;
        w.heading_h = crosses ? turned.y : w.heading_h;
        w.carry_p = crosses ? turned.z : w.carry_p;
        w.carry_h = crosses ? turned.w : w.carry_h;
        w.triangle = stays ? w.triangle : twin / 3u;
        w.entered_by = crosses ? next_corner : w.entered_by;
        attempts -= 1u;
    }
}

// u and v for storage: inside the triangle whatever the rounding.
vec2 walker_uv(Walker w) {
    float u = within(w.weight_b, 0.0, 1.0);
    precise float most = 1.0 - u;
    return vec2(u, within(w.weight_c, 0.0, most));
}

// By rounding, repeated rotations change the length of a heading; one Newton step brings it back to 1.
vec2 walker_heading(Walker w) {
    precise float square = w.heading_p * w.heading_p + w.heading_h * w.heading_h;
    precise float scale = 1.5 - 0.5 * square;
    precise vec2 heading = vec2(w.heading_p * scale, w.heading_h * scale);
    return heading;
}

#endif
