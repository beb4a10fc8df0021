// transfer: how a particle leaves one object in world space and lands on another. Twin of src/sim/ground.rs.
// The includer declares `triangles`, `corners`, `vertices` and `poses` first, tables.

#ifndef MYXO_TRANSFER
#define MYXO_TRANSFER

#include "tables.glsl"
#include "frame.glsl"
#include "pose_table.glsl"
#include "spaces.glsl"

// Place, heading and plane of a particle in world space.
struct Flight { vec3 position; vec3 heading; vec3 normal; };

Flight flight_of(Particle particle, Motion motion) {
    uvec4 shape = fetch4(triangles, particle.triangle);
    Pose pose = pose_of(shape.w);
    Frame frame = frame_of(particle.triangle);
    vec3 position = position_on(shape, frame, particle.u, particle.v);
    precise vec3 heading = motion.heading_p * frame.p + motion.heading_h * frame.h;
    return Flight(
        place_in_world(pose, position), turned_to_world(pose, heading), turned_to_world(pose, frame.normal));
}

// The heading, turned about the line in which the two planes meet by the angle between their normals (Rodrigues).
// Between planes that face each other there is no such line, and the heading stays.
vec3 folded(vec3 heading, vec3 from, vec3 to) {
    vec3 axis = cross_of(from, to);
    float cosine = dot_of(from, to);
    if (cosine < -0.99999) return heading;
    precise float more = 1.0 + cosine;
    precise vec3 turned = (cosine * heading + cross_of(axis, heading)) + quotient(dot_of(axis, heading), more) * axis;
    return turned;
}

// The landing of a transferred particle on a triangle: its nearest point, with the heading folded into its plane.
struct Landing { float u; float v; float heading_p; float heading_h; };

Landing landing_on(uint triangle, Flight flight) {
    uvec4 shape = fetch4(triangles, triangle);
    Pose pose = pose_of(shape.w);
    Frame frame = frame_of(triangle);
    precise vec3 place = place_in_object(pose, flight.position) - frame.origin;
    vec2 weights = nearest_weights(uintBitsToFloat(shape.x), uintBitsToFloat(shape.y), uintBitsToFloat(shape.z),
        dot_of(place, frame.p), dot_of(place, frame.h));
    vec3 from = turned_to_object(pose, flight.normal);
    vec3 heading = folded(turned_to_object(pose, flight.heading), from, frame.normal);
    vec2 flat_heading = flat_direction(vec2(dot_of(heading, frame.p), dot_of(heading, frame.h)));
    float u = within(weights.x, 0.0, 1.0);
    precise float most = 1.0 - u;
    return Landing(settled(u), settled(within(weights.y, 0.0, most)), flat_heading.x, flat_heading.y);
}

#endif
