// walk: the straightest path on the surface, in the tangent frame. Twin of src/sim/twin/walk.rs.
// Straight in each triangle; over an edge the point keeps its place on the edge and the heading turns by the stored
// rotation. No world coordinates, no trigonometry, so nothing drifts off the surface.
// The includer declares `triangles` (Triangle[]) and `halfedges` (HalfEdge[]) first.

#ifndef MYXO_WALK
#define MYXO_WALK

const uint WALK_DONE = 0u;
const uint WALK_BORDER = 1u;
const uint WALK_OUT_OF_ATTEMPTS = 2u;

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
};

Walker walker_at(uint triangle, float u, float v, vec2 heading, float length) {
    precise float weight_a = (1.0 - u) - v;
    return Walker(triangle, max(weight_a, 0.0), u, v, heading.x, heading.y, length, NONE, WALK_DONE);
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
        precise float a = max(w.weight_a + rate_a * distance, 0.0);
        precise float b = max(w.weight_b + rate_b * distance, 0.0);
        precise float c = max(w.weight_c + rate_c * distance, 0.0);
        w.remaining -= distance;
        if (corner == NONE) {
            w.weight_a = a; w.weight_b = b; w.weight_c = c;
            w.remaining = 0.0;
            w.status = WALK_DONE;
            return;
        }

        // Where on the half-edge, measured from its start.
        precise float along = corner == 0u ? b : corner == 1u ? c : a;
        along = min(along, 1.0);
        HalfEdge edge = halfedges[3u * w.triangle + corner];
        bool at_border = edge.twin == NONE;
        bool stops = at_border && !reflects;
        if (stops || attempts == 0u) {
            precise float start = 1.0 - along;
            w.weight_a = corner == 0u ? start : corner == 2u ? along : 0.0;
            w.weight_b = corner == 1u ? start : corner == 0u ? along : 0.0;
            w.weight_c = corner == 2u ? start : corner == 1u ? along : 0.0;
            w.status = stops ? WALK_BORDER : WALK_OUT_OF_ATTEMPTS;
            return;
        }
        attempts -= 1u;

        // At a border the half-edge is its own twin: the place stays, and (cos, sin) is the direction of the edge,
        // doubled, for the reflection.
        uint next_corner = at_border ? corner : edge.twin % 3u;
        w.triangle = at_border ? w.triangle : edge.twin / 3u;
        precise float start = at_border ? 1.0 - along : along;
        precise float end = at_border ? along : 1.0 - along;
        w.weight_a = next_corner == 0u ? start : next_corner == 2u ? end : 0.0;
        w.weight_b = next_corner == 1u ? start : next_corner == 0u ? end : 0.0;
        w.weight_c = next_corner == 2u ? start : next_corner == 1u ? end : 0.0;
        w.entered_by = next_corner;
        float heading_h = at_border ? -w.heading_h : w.heading_h;
        precise float p = edge.cos * w.heading_p - edge.sin * heading_h;
        precise float h = edge.sin * w.heading_p + edge.cos * heading_h;
        w.heading_p = p;
        w.heading_h = h;
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
