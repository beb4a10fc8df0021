// strip: a straight walk through a strip of triangles. Twin of src/sim/strip_walk.rs.
// The strip is laid out flat as it goes, as seen from the start: x along the way, y to the left of it. Therefore each edge takes one read,
// and the heading turns once, at the end. Each walk begins in its triangle's own frame, so errors do not add up. The includer declares what
// strip_table.glsl needs.

#ifndef MYXO_STRIP
#define MYXO_STRIP

#include "vectors.glsl"
#include "strip_table.glsl"

const uint WALK_DONE = 0u;
const uint WALK_BORDER = 1u;
const uint WALK_OUT_OF_ATTEMPTS = 2u;

// No triangle that is laid out has less area.
const float TINY = 1.0e-30;

struct StripWalk {
    uint triangle;
    float u;
    float v;
    vec2 heading;     // in the triangle's frame, unit length
    float remaining;  // world length still to walk
    uint status;
};

vec2 seen_from(vec2 point, float x, float y, vec2 heading) {
    precise vec2 way = vec2(x - point.x, y - point.y);
    precise vec2 seen = vec2(way.x * heading.x + way.y * heading.y, way.y * heading.x - way.x * heading.y);
    return seen;
}

// How far ahead the edge from right to left is, as numerator and denominator.
vec2 way_to(vec2 right, vec2 left) {
    precise vec2 way = vec2(right.x * left.y - left.x * right.y, left.y - right.y);
    return way;
}

// Does a walk of this length end before that edge? Without a division.
bool ends_before(vec2 right, vec2 left, float remaining) {
    vec2 way = way_to(right, left);
    precise float reach = remaining * way.y;
    return way.y > 0.0 ? way.x >= reach : min(right.x, left.x) >= remaining;
}

// Walks what remains, over at most `attempts` edges. Reflections at open borders count as crossings.
// The loop has one path and one exit: devices that run both sides of every branch pay for each of them.
void walk_strip(inout StripWalk w, uint attempts, bool reflects) {
    vec3 shape = uintBitsToFloat(shape_words(w.triangle).xyz);
    precise vec2 point = vec2(w.u * shape.x + w.v * shape.y, w.v * shape.z);
    vec2 a = seen_from(point, 0.0, 0.0, w.heading);
    vec2 b = seen_from(point, shape.x, 0.0, w.heading);
    vec2 c = seen_from(point, shape.y, shape.z, w.heading);
    // The edge ahead begins on the right and ends on the left.
    bool is_ab = a.y <= 0.0 && b.y > 0.0;
    bool is_bc = b.y <= 0.0 && c.y > 0.0;
    vec2 right = is_ab ? a : is_bc ? b : c;
    vec2 left = is_ab ? b : is_bc ? c : a;
    vec2 third = is_ab ? c : is_bc ? a : b;
    uint edge = 4u * w.triangle + (is_ab ? 0u : is_bc ? 1u : 2u);
    bool stays = true;
    bool mirrored = false;
    bool at_border = false;
    bool ends = ends_before(right, left, w.remaining);
    bool crosses = true;
    while (true) {
        // This branch keeps the results of invocations that have exited, even if the device continues the loop for others.
        if (!ends) {
            uvec4 words = edge_words(edge);
            at_border = words.x == NONE;
            crosses = attempts != 0u && (reflects || !at_border);
            // Behind a border lies the triangle itself, mirrored, where left and right are exchanged.
            bool over = at_border != mirrored;
            vec2 start = over ? right : left;
            vec2 stop = over ? left : right;
            precise vec2 way = stop - start;
            float along = uintBitsToFloat(words.y);
            float off = over ? -uintBitsToFloat(words.z) : uintBitsToFloat(words.z);
            precise vec2 apex = vec2(
                start.x + (along * way.x - off * way.y),
                start.y + (along * way.y + off * way.x));
            bool turns_right = apex.y > 0.0;
            uint entered = at_border ? edge : words.x;
            uint corner = entered & 3u;
            uint after = corner == 2u ? 0u : corner + 1u;
            uint before = corner == 0u ? 2u : corner - 1u;
            uint next = turns_right == over ? before : after;
            third = !crosses ? third : turns_right ? left : right;
            left = crosses && turns_right ? apex : left;
            right = crosses && !turns_right ? apex : right;
            edge = crosses ? (entered & ~3u) + next : edge;
            mirrored = crosses ? over : mirrored;
            stays = stays && !crosses;
            attempts -= 1u;
            ends = ends_before(right, left, w.remaining);
        }
        // At the end, because a round that all invocations exit at its beginning would still be executed up to there.
        if (ends || !crosses) break;
    }

    float end = w.remaining;
    if (!ends) {
        vec2 way = way_to(right, left);
        end = within(quotient(way.x, way.y), 0.0, w.remaining);
    }

    vec2 start = mirrored ? left : right;
    precise vec2 stop = (mirrored ? right : left) - start;
    precise vec2 apex = third - start;
    precise vec2 place = vec2(end, 0.0) - start;
    precise float own_area = shape.x * shape.z;
    float area = stays ? own_area : cross_of(stop, apex);
    area = abs(area) > TINY ? area : TINY;
    float by = reciprocal(area);

    // Within its first triangle, a walk does not depend on the surrounding triangles.
    precise float rate_u = (w.heading.x * shape.z - w.heading.y * shape.y) * by;
    precise float rate_v = (w.heading.y * shape.x) * by;
    precise float near_u = w.u + rate_u * end;
    precise float near_v = w.v + rate_v * end;

    precise float of_stop = cross_of(place, apex) * by;
    precise float of_third = cross_of(stop, place) * by;
    precise float of_start = (1.0 - of_stop) - of_third;
    uint corner = edge & 3u;
    float u = stays ? near_u : corner == 0u ? of_stop : corner == 1u ? of_start : of_third;
    float v = stays ? near_v : corner == 0u ? of_third : corner == 1u ? of_stop : of_start;
    u = within(u, 0.0, 1.0);
    precise float most = 1.0 - u;

    // The way as seen from the last triangle, whose corners A and B lie in the strip.
    precise vec2 ab = corner == 0u ? stop : corner == 1u ? -apex : apex - stop;
    // By rounding, many turns change the length of a heading; one Newton step brings it back to 1.
    precise float drift = w.heading.x * w.heading.x + w.heading.y * w.heading.y;
    precise float scale = 1.5 - 0.5 * drift;
    precise vec2 kept = w.heading * scale;
    // In the strip, a triangle much thinner than the way is long may be a point. Then the heading keeps its direction.
    vec2 turned = direction_or(vec2(ab.x, mirrored ? ab.y : -ab.y), kept);

    w.triangle = edge >> 2u;
    w.u = u;
    w.v = within(v, 0.0, most);
    w.heading = stays ? kept : turned;
    precise float rest = w.remaining - end;
    w.remaining = rest;
    w.status = ends ? WALK_DONE : at_border && !reflects ? WALK_BORDER : WALK_OUT_OF_ATTEMPTS;
}

#endif
