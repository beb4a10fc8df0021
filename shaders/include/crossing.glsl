// crossing: meetings of a walk on one object with the surface of another, and its continuation there. Twin of
// src/sim/crossing.rs.
// The includer declares `roots` first, the first node of each object's tree, and what walk.glsl, transfer.glsl and
// sign.glsl need. Every place here is in the space of the other object, the target.
//
// Two planes meet in a line. The component of a heading along the line stays; the component across it turns into the other plane, to one of
// two sides. The walk takes the side on which it ends less covered by the object that it comes from.

#ifndef MYXO_CROSSING
#define MYXO_CROSSING

#include "walk.glsl"
#include "transfer.glsl"
#include "sign.glsl"

struct Meeting {
    uint slot;     // the target's face, NONE if they do not meet
    float u;       // weights of B and C there
    float v;
    float t;       // the share of the segment before it
    vec3 heading;  // of the walk
    vec3 normal;   // of the plane that it was in
};

// Planes count as parallel where the squared cross product of their unit normals is less than this.
const float PARALLEL_SQUARE = 1.0e-6;

Flight flight_of_walker(Walker w) {
    vec2 uv = walker_uv(w);
    vec2 heading = walker_heading(w);
    return flight_of(Particle(w.triangle, uv.x, uv.y, 0u), Motion(heading.x, heading.y, 0.0, 0u));
}

vec3 place_of(Pose target, Flight flight) {
    return place_in_object(target, flight.position);
}

// The first meeting of the straight way between two walkers with the target; `on` is one of them that is in the triangle that
// the way lies in, and `side` is -1 if it walks backwards.
Meeting meeting_between(uint target, vec3 from, vec3 to, Flight on, float side) {
    Crossing crossing = first_crossing(roots[target], from, to);
    Meeting meeting;
    meeting.slot = crossing.slot;
    meeting.u = crossing.u;
    meeting.v = crossing.v;
    meeting.t = crossing.t;
    Pose pose = pose_of(target);
    precise vec3 heading = side * turned_to_object(pose, on.heading);
    meeting.heading = heading;
    meeting.normal = turned_to_object(pose, on.normal);
    return meeting;
}

// The walk that continues from a meeting: outwards if `side` is 1, seen from the object that it comes from, or inwards.
Walker walker_from(Meeting meeting, float side, float rest) {
    uint triangle = triangle_of(meeting.slot);
    Frame frame = frame_of(triangle);
    vec3 crossed = cross_of(meeting.normal, frame.normal);
    float square = dot_of(crossed, crossed);
    vec3 heading;
    if (square < PARALLEL_SQUARE) {
        heading = folded(meeting.heading, meeting.normal, frame.normal);
    } else {
        precise vec3 axis = crossed * inverse_root(square);
        vec3 across = cross_of(axis, frame.normal);
        float outwards = dot_of(across, meeting.normal) < 0.0 ? -side : side;
        float along = dot_of(meeting.heading, axis);
        precise float rest_square = 1.0 - along * along;
        precise vec3 folded_heading = along * axis + (outwards * root(rest_square)) * across;
        heading = folded_heading;
    }
    vec2 flat_heading = flat_direction(vec2(dot_of(heading, frame.p), dot_of(heading, frame.h)));
    return walker_at(triangle, meeting.u, meeting.v, flat_heading, rest);
}

// The signed distance of a walker to an object that it has come from.
float distance_to_object(uint object, Walker w, uint first_vertex_normal) {
    uint tree = roots[object];
    vec3 place = place_of(pose_of(object), flight_of_walker(w));
    // The way began on the object, but that may have moved since: it may be any depth away.
    uint slot = nearest_on(tree, place, UNLIMITED);
    // A search that has not ended may have found nothing.
    if (slot == NONE) return 0.0;
    vec4 point = nearest_on_face(slot, place);
    float distance = root(point.z);
    return is_outside(tree, slot, place, point, first_vertex_normal) ? distance : -distance;
}

// Is the inner one of two ends less covered by the object that the walk comes from? If both are equally covered, it is not.
bool inner_is_better(uint source, Walker outer, Walker inner, uint first_vertex_normal) {
    float outer_distance = distance_to_object(source, outer, first_vertex_normal);
    float inner_distance = distance_to_object(source, inner, first_vertex_normal);
    precise float least = outer_distance + 4.0 * slack_of_tree(roots[source]);
    return inner_distance > least;
}

#endif
