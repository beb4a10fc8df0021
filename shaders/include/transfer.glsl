// transfer: how a particle leaves one object in world space and lands on another. Twin of src/sim/twin/transfer.rs.
// The includer declares `triangles` (texel buffer), `corners`, `vertices` and `poses` first.
// Poses are rotations and translations: lengths and angles are the same in every space.

#ifndef MYXO_TRANSFER
#define MYXO_TRANSFER

// A triangle's corner A, the axes of its tangent frame and its unit normal, object space.
struct Frame { vec3 origin; vec3 p; vec3 h; vec3 normal; };

vec3 corner_position(uint triangle, uint corner) {
    return vertices[corners[3u * triangle + corner]].position;
}

Frame frame_of(uint triangle) {
    vec3 a = corner_position(triangle, 0u);
    vec3 ab = corner_position(triangle, 1u) - a;
    vec3 ac = corner_position(triangle, 2u) - a;
    vec3 p = normalize(ab);
    vec3 normal = normalize(cross(ab, ac));
    return Frame(a, p, cross(normal, p), normal);
}

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

Flight flight_of(Particle particle, Motion motion) {
    uvec4 shape = texelFetch(triangles, int(particle.triangle));
    float ab = uintBitsToFloat(shape.x);
    float cp = uintBitsToFloat(shape.y);
    float ch = uintBitsToFloat(shape.z);
    Pose pose = poses[shape.w];
    Frame frame = frame_of(particle.triangle);
    float along = particle.u * ab + particle.v * cp;
    float across = particle.v * ch;
    vec3 position = frame.origin + along * frame.p + across * frame.h;
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

// The weights of B and C at the point of a triangle that is nearest to (x, y) of its tangent frame.
vec2 nearest_weights(float ab, float cp, float ch, float x, float y) {
    float v = y / ch;
    float u = (x - v * cp) / ab;
    if (u >= 0.0 && v >= 0.0 && u + v <= 1.0) return vec2(u, v);
    // The nearest point of each edge, as a share of the way along it.
    float on_ab = clamp(x / ab, 0.0, 1.0);
    float bc_x = cp - ab;
    float on_bc = clamp(((x - ab) * bc_x + y * ch) / (bc_x * bc_x + ch * ch), 0.0, 1.0);
    float on_ac = clamp((x * cp + y * ch) / (cp * cp + ch * ch), 0.0, 1.0);
    vec2 to_ab = vec2(x - on_ab * ab, y);
    vec2 to_bc = vec2(x - ab - on_bc * bc_x, y - on_bc * ch);
    vec2 to_ac = vec2(x - on_ac * cp, y - on_ac * ch);
    float ab_square = dot(to_ab, to_ab);
    float bc_square = dot(to_bc, to_bc);
    float ac_square = dot(to_ac, to_ac);
    if (ab_square <= bc_square && ab_square <= ac_square) return vec2(on_ab, 0.0);
    return bc_square <= ac_square ? vec2(1.0 - on_bc, on_bc) : vec2(0.0, on_ac);
}

// Where a particle that flies lands on a triangle: the nearest point of it, with the heading folded into its plane.
struct Landing { float u; float v; float heading_p; float heading_h; };

Landing landing_on(uint triangle, Flight flight) {
    uvec4 shape = texelFetch(triangles, int(triangle));
    Pose pose = poses[shape.w];
    Frame frame = frame_of(triangle);
    vec3 place = turned_to_object(pose, flight.position - translation_of(pose)) - frame.origin;
    vec2 weights = nearest_weights(uintBitsToFloat(shape.x), uintBitsToFloat(shape.y), uintBitsToFloat(shape.z),
        dot(place, frame.p), dot(place, frame.h));
    vec3 from = turned_to_object(pose, flight.normal);
    vec3 heading = folded(turned_to_object(pose, flight.heading), from, frame.normal);
    vec2 flat_heading = normalize(vec2(dot(heading, frame.p), dot(heading, frame.h)));
    float u = clamp(weights.x, 0.0, 1.0);
    return Landing(u, clamp(weights.y, 0.0, 1.0 - u), flat_heading.x, flat_heading.y);
}

#endif
