// footprint: the objects as seen from below, on the square of the ground.
// Reads   corners, vertices, poses.
// Writes  the place on the square, and the height above the ground.
// Three invocations per triangle.
// Overflow: cannot happen; the draw has three vertices for each triangle.
#version 460
#include "types.glsl"
#include "shading.glsl"
#include "footprint.glsl"

layout(set = 0, binding = 0) uniform usamplerBuffer corners;
layout(set = 0, binding = 1) uniform usamplerBuffer vertices;
layout(set = 0, binding = 2) uniform samplerBuffer poses;

#include "placed.glsl"

layout(location = 0) out float height;

void main() {
    Vertex vertex = vertex_of(uint(gl_VertexIndex));
    vec3 place = place_in_world(pose_of(vertex.object), vertex.position);
    height = max(place.y - params.ground, 0.0);
    // The lowest wins, as depth is reversed.
    gl_Position = vec4((place.xz - params.middle) / params.extent, 0.999 / (1.0 + height / params.extent), 1.0);
}
