// walk: the straightest path on the surface, in the tangent frame. Twin of src/sim/twin/walk.rs.
// Straight in each triangle; over an edge the point keeps its place on the edge and the heading turns by the stored
// rotation. No world coordinates, no trigonometry, so nothing drifts off the surface.
// The includer declares `triangles` and `halfedges` first: texel buffers of the structs' four words, which CPU drivers
// read faster than storage buffers.

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
// One way through the loop and one way out: devices that run both sides of every branch pay for each of them.
void walk(inout Walker w, uint attempts, bool reflects) {
    bool crosses = true;
    while (crosses) {
        vec3 shape = uintBitsToFloat(texelFetch(triangles, int(w.triangle)).xyz);
        float ab = shape.x;
        float cp = shape.y;
        float ch = shape.z;
        precise float rate_c = w.heading_h / ch;
        precise float rate_b = (w.heading_p - rate_c * cp) / ab;
        precise float rate_a = -rate_b - rate_c;

        // The half-edge of corner k lies opposite corner k + 2: it is reached when that corner's weight is zero.
        // The one that the walk came in by is left out: rounding must not send it straight back.
        bool towards_ab = rate_c < 0.0 && w.entered_by != 0u;
        bool towards_bc = rate_a < 0.0 && w.entered_by != 1u;
        bool towards_ca = rate_b < 0.0 && w.entered_by != 2u;
        precise float to_ab = towards_ab ? w.weight_c / -rate_c : w.remaining;
        precise float to_bc = towards_bc ? w.weight_a / -rate_a : w.remaining;
        precise float to_ca = towards_ca ? w.weight_b / -rate_b : w.remaining;
        float distance = min(min(to_ab, to_bc), min(to_ca, w.remaining));
        bool ends = distance == w.remaining;
        uint corner = to_ab == distance ? 0u : to_bc == distance ? 1u : 2u;

        precise float a = max(w.weight_a + rate_a * distance, 0.0);
        precise float b = max(w.weight_b + rate_b * distance, 0.0);
        precise float c = max(w.weight_c + rate_c * distance, 0.0);
        w.remaining -= distance;

        // Where on the half-edge, measured from its start. Across, the twin's start is the end; at an open border the
        // half-edge is its own twin.
        uvec4 edge = texelFetch(halfedges, int(3u * w.triangle + corner));
        uint twin = edge.x;
        vec2 rotation = uintBitsToFloat(edge.yz);
        bool at_border = twin == NONE;
        bool stops = ends || attempts == 0u || (at_border && !reflects);
        bool stays = stops || at_border;
        float along = min(corner == 0u ? b : corner == 1u ? c : a, 1.0);
        precise float rest = 1.0 - along;
        uint next_corner = stays ? corner : twin % 3u;
        float start = stays ? rest : along;
        float end = stays ? along : rest;
        w.weight_a = ends ? a : next_corner == 0u ? start : next_corner == 2u ? end : 0.0;
        w.weight_b = ends ? b : next_corner == 1u ? start : next_corner == 0u ? end : 0.0;
        w.weight_c = ends ? c : next_corner == 2u ? start : next_corner == 1u ? end : 0.0;
        w.status = ends ? WALK_DONE : at_border && !reflects ? WALK_BORDER : WALK_OUT_OF_ATTEMPTS;
        crosses = !stops;

        // At a border (cos, sin) is the direction of the edge, doubled, which mirrors the heading with its h negated.
        float heading_h = at_border ? -w.heading_h : w.heading_h;
        precise float p = rotation.x * w.heading_p - rotation.y * heading_h;
        precise float h = rotation.y * w.heading_p + rotation.x * heading_h;
        w.heading_p = crosses ? p : w.heading_p;
        w.heading_h = crosses ? h : w.heading_h;
        w.triangle = stays ? w.triangle : twin / 3u;
        w.entered_by = crosses ? next_corner : w.entered_by;
        attempts -= 1u;
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
