// transfer: how a particle leaves one object in world space and lands on another. Twin of src/sim/ground.rs.
// The includer declares `triangles`, `corners`, `vertices` and `poses` first, tables.
// Poses are rotations and translations: lengths and angles are the same in every space.

#ifndef MYXO_TRANSFER
#define MYXO_TRANSFER

#include "tables.glsl"
#include "frame.glsl"
#include "pose_table.glsl"

vec3 turned_to_world(Pose pose, vec3 direction) {
    return vec3(dot(pose.x.xyz, direction), dot(pose.y.xyz, direction), dot(pose.z.xyz, direction));
}

vec3 turned_to_object(Pose pose, vec3 direction) {
    return direction.x * pose.x.xyz + direction.y * pose.y.xyz + direction.z * pose.z.xyz;
}

vec3 translation_of(Pose pose) {
    return vec3(pose.x.w, pose.y.w, pose.z.w);
}

// Where a particle is and where it is going, world space.
struct Flight { vec3 position; vec3 heading; vec3 normal; };

// Where weights of B and C are on a triangle of that frame, object space.
vec3 position_on(uvec4 shape, Frame frame, float u, float v) {
    float along = u * uintBitsToFloat(shape.x) + v * uintBitsToFloat(shape.y);
    float across = v * uintBitsToFloat(shape.z);
    return frame.origin + along * frame.p + across * frame.h;
}

Flight flight_of(Particle particle, Motion motion) {
    uvec4 shape = fetch4(triangles, particle.triangle);
    Pose pose = pose_of(shape.w);
    Frame frame = frame_of(particle.triangle);
    vec3 position = position_on(shape, frame, particle.u, particle.v);
    vec3 heading = motion.heading_p * frame.p + motion.heading_h * frame.h;
    return Flight(
        turned_to_world(pose, position) + translation_of(pose),
        turned_to_world(pose, heading),
        turned_to_world(pose, frame.normal));
}

// The heading, turned about the line in which the two planes meet by the angle between their normals (Rodrigues).
// Between planes that face each other there is no such line, and the heading stays.
vec3 folded(vec3 heading, vec3 from, vec3 to) {
    vec3 axis = cross(from, to);
    float cosine = dot(from, to);
    if (cosine < -0.99999) return heading;
    return cosine * heading + cross(axis, heading) + (dot(axis, heading) / (1.0 + cosine)) * axis;
}

// Where a particle that flies lands on a triangle: the nearest point of it, with the heading folded into its plane.
struct Landing { float u; float v; float heading_p; float heading_h; };

Landing landing_on(uint triangle, Flight flight) {
    uvec4 shape = fetch4(triangles, triangle);
    Pose pose = pose_of(shape.w);
    Frame frame = frame_of(triangle);
    vec3 place = turned_to_object(pose, flight.position - translation_of(pose)) - frame.origin;
    vec2 weights = nearest_weights(uintBitsToFloat(shape.x), uintBitsToFloat(shape.y), uintBitsToFloat(shape.z),
        dot(place, frame.p), dot(place, frame.h));
    vec3 from = turned_to_object(pose, flight.normal);
    vec3 heading = folded(turned_to_object(pose, flight.heading), from, frame.normal);
    vec2 flat_heading = flat_direction(vec2(dot(heading, frame.p), dot(heading, frame.h)));
    float u = clamp(weights.x, 0.0, 1.0);
    return Landing(u, clamp(weights.y, 0.0, 1.0 - u), flat_heading.x, flat_heading.y);
}

#endif
