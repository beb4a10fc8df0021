// walk: the straightest path on the surface, in the tangent frame. Twin of src/sim/twin/walk.rs.
// Straight in each triangle; over an edge the point keeps its place on the edge and the heading turns by the stored
// rotation. No world coordinates, no trigonometry, so nothing drifts off the surface.
// The includer declares `triangles` (Triangle[]), `halfedges` (HalfEdge[]) and `const bool WALK_CARRIES` first.
//
// Each crossing rounds, and over many edges that adds up to some 1e-6 of the way. Particles do not mind. Where
// WALK_CARRIES, what rounding drops of a walker's numbers is carried along, and long walks are as good as short ones.

#ifndef MYXO_WALK
#define MYXO_WALK

#include "exact.glsl"

const uint WALK_DONE = 0u;
const uint WALK_BORDER = 1u;
const uint WALK_OUT_OF_ATTEMPTS = 2u;

// The unit of HalfEdge.fine: half of what the last bit of a cosine may be worth.
const float FINE_UNIT = 1.0 / 33554432.0;

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
    float carry_a;    // what rounding dropped of the numbers above, where WALK_CARRIES
    float carry_b;
    float carry_c;
    float carry_p;
    float carry_h;
    float carry_remaining;
};

Walker walker_at(uint triangle, float u, float v, vec2 heading, float length) {
    precise float weight_a = (1.0 - u) - v;
    return Walker(triangle, max(weight_a, 0.0), u, v, heading.x, heading.y, length, NONE, WALK_DONE,
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
    return vec2(max(sum, 0.0), 0.0);
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

void set_weights(inout Walker w, vec2 a, vec2 b, vec2 c) {
    w.weight_a = a.x; w.weight_b = b.x; w.weight_c = c.x;
    w.carry_a = a.y; w.carry_b = b.y; w.carry_c = c.y;
}

// Puts the walker on the half-edge of a corner: the weights of its start and of its end.
void set_on_edge(inout Walker w, uint corner, vec2 start, vec2 end) {
    const vec2 zero = vec2(0.0);
    set_weights(w,
        corner == 0u ? start : corner == 2u ? end : zero,
        corner == 1u ? start : corner == 0u ? end : zero,
        corner == 2u ? start : corner == 1u ? end : zero);
}

void shorten(inout Walker w, float distance) {
    if (WALK_CARRIES) {
        precise float way = distance - w.carry_remaining;
        precise float left = max(w.remaining - way, 0.0);
        precise float carry = (w.remaining - left) - way;
        w.remaining = left;
        w.carry_remaining = carry;
    } else {
        precise float left = w.remaining - distance;
        w.remaining = left;
    }
}

void turn(inout Walker w, HalfEdge edge) {
    if (WALK_CARRIES) {
        vec2 fine = FINE_UNIT * unpackSnorm2x16(edge.fine);
        vec2 cos_p = exact_product(edge.cos, w.heading_p);
        vec2 sin_p = exact_product(edge.sin, w.heading_p);
        vec2 cos_h = exact_product(edge.cos, w.heading_h);
        vec2 sin_h = exact_product(edge.sin, w.heading_h);
        vec2 p = exact_sum(cos_p.x, -sin_h.x);
        vec2 h = exact_sum(sin_p.x, cos_h.x);
        precise float dropped_p = p.y + (cos_p.y - sin_h.y);
        precise float dropped_h = h.y + (sin_p.y + cos_h.y);
        dropped_p += edge.cos * w.carry_p - edge.sin * w.carry_h;
        dropped_h += edge.sin * w.carry_p + edge.cos * w.carry_h;
        dropped_p += fine.x * w.heading_p - fine.y * w.heading_h;
        dropped_h += fine.y * w.heading_p + fine.x * w.heading_h;
        p = exact_sum(p.x, dropped_p);
        h = exact_sum(h.x, dropped_h);
        w.heading_p = p.x; w.carry_p = p.y;
        w.heading_h = h.x; w.carry_h = h.y;
    } else {
        precise float p = edge.cos * w.heading_p - edge.sin * w.heading_h;
        precise float h = edge.sin * w.heading_p + edge.cos * w.heading_h;
        w.heading_p = p;
        w.heading_h = h;
    }
}

// Walks what remains, over at most `attempts` edges. Reflections at open borders count as crossings.
void walk(inout Walker w, uint attempts, bool reflects) {
    for (;;) {
        Triangle t = triangles[w.triangle];
        precise float rate_c = w.heading_h / t.ch;
        precise float rate_b = (w.heading_p - rate_c * t.cp) / t.ab;
        precise float rate_a = -rate_b - rate_c;

        // The half-edge of corner k lies opposite corner k + 2: it is reached when that corner's weight is zero.
        // The one that the walk came in by is left out: rounding must not send it straight back.
        precise float distance = w.remaining;
        uint corner = NONE;
        if (rate_c < 0.0 && w.entered_by != 0u) {
            precise float d = w.weight_c / -rate_c;
            if (d < distance) { distance = d; corner = 0u; }
        }
        if (rate_a < 0.0 && w.entered_by != 1u) {
            precise float d = w.weight_a / -rate_a;
            if (d < distance) { distance = d; corner = 1u; }
        }
        if (rate_b < 0.0 && w.entered_by != 2u) {
            precise float d = w.weight_b / -rate_b;
            if (d < distance) { distance = d; corner = 2u; }
        }
        vec2 a = moved(w.weight_a, w.carry_a, rate_a, distance);
        vec2 b = moved(w.weight_b, w.carry_b, rate_b, distance);
        vec2 c = moved(w.weight_c, w.carry_c, rate_c, distance);
        shorten(w, distance);
        if (corner == NONE) {
            set_weights(w, a, b, c);
            w.remaining = 0.0;
            w.carry_remaining = 0.0;
            w.status = WALK_DONE;
            return;
        }

        // Where on the half-edge, measured from its start.
        vec2 along = corner == 0u ? b : corner == 1u ? c : a;
        if (WALK_CARRIES) {
            // Of the two weights on the edge, the one that has changed less is known better; in a needle much better.
            float end_rate = corner == 0u ? rate_b : corner == 1u ? rate_c : rate_a;
            float start_rate = corner == 0u ? rate_a : corner == 1u ? rate_b : rate_c;
            if (abs(start_rate) < abs(end_rate)) {
                along = from_other_end(corner == 0u ? a : corner == 1u ? b : c);
            }
            if (along.x < 0.0) { along = vec2(0.0); }
        }
        if (along.x > 1.0) { along = vec2(1.0, 0.0); }
        vec2 rest = from_other_end(along);
        HalfEdge edge = halfedges[3u * w.triangle + corner];
        bool at_border = edge.twin == NONE;
        bool stops = at_border && !reflects;
        if (stops || attempts == 0u) {
            set_on_edge(w, corner, rest, along);
            w.status = stops ? WALK_BORDER : WALK_OUT_OF_ATTEMPTS;
            return;
        }
        attempts -= 1u;

        // At a border the half-edge is its own twin: the place stays, and (cos, sin) is the direction of the edge,
        // doubled, for the reflection.
        uint next_corner = at_border ? corner : edge.twin % 3u;
        w.triangle = at_border ? w.triangle : edge.twin / 3u;
        set_on_edge(w, next_corner, at_border ? rest : along, at_border ? along : rest);
        w.entered_by = next_corner;
        w.heading_h = at_border ? -w.heading_h : w.heading_h;
        w.carry_h = at_border ? -w.carry_h : w.carry_h;
        turn(w, edge);
    }
}

// u and v for storage: inside the triangle whatever the rounding.
vec2 walker_uv(Walker w) {
    float u = clamp(w.weight_b, 0.0, 1.0);
    return vec2(u, clamp(w.weight_c, 0.0, 1.0 - u));
}

// Repeated rotations let the length of a heading drift by rounding; one step of Newton brings it back to 1.
vec2 walker_heading(Walker w) {
    precise float square = w.heading_p * w.heading_p + w.heading_h * w.heading_h;
    precise float scale = 1.5 - 0.5 * square;
    precise vec2 heading = vec2(w.heading_p * scale, w.heading_h * scale);
    return heading;
}

#endif
