// spaces: places and directions in the world and in objects. Twin of src/sim/ground.rs.
// Poses are rotations and translations: lengths and angles are the same in every space.

#ifndef MYXO_SPACES
#define MYXO_SPACES

#include "types.glsl"
#include "frame.glsl"

vec3 turned_to_world(Pose pose, vec3 direction) {
    return vec3(dot_of(pose.x.xyz, direction), dot_of(pose.y.xyz, direction), dot_of(pose.z.xyz, direction));
}

vec3 turned_to_object(Pose pose, vec3 direction) {
    precise vec3 turned = (direction.x * pose.x.xyz + direction.y * pose.y.xyz) + direction.z * pose.z.xyz;
    return turned;
}

vec3 translation_of(Pose pose) {
    return vec3(pose.x.w, pose.y.w, pose.z.w);
}

vec3 place_in_world(Pose pose, vec3 position) {
    precise vec3 place = turned_to_world(pose, position) + translation_of(pose);
    return place;
}

vec3 place_in_object(Pose pose, vec3 position) {
    precise vec3 way = position - translation_of(pose);
    return turned_to_object(pose, way);
}

// The place with given weights of B and C on a triangle with that frame, object space.
vec3 position_on(uvec4 shape, Frame frame, float u, float v) {
    precise float along = u * uintBitsToFloat(shape.x) + v * uintBitsToFloat(shape.y);
    precise float across = v * uintBitsToFloat(shape.z);
    precise vec3 position = (frame.origin + along * frame.p) + across * frame.h;
    return position;
}

#endif
