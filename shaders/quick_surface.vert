// quick_surface: draws every object's triangles, lit, with the trail on them, but neither relief nor charts.
// Reads   shared_vertices, poses; its other stage trail, clearance, colors, brightest, distances.
// Writes  the vertex's place, normal, openness and position in the atlas.
// One invocation per vertex, or more if the device does not cache shaded vertices.
// Overflow: cannot happen; indices are those of vertices.
#version 460
#include "types.glsl"
#include "shading.glsl"
#include "quick_surface.glsl"

layout(set = 0, binding = 0) uniform usamplerBuffer shared_vertices;
layout(set = 0, binding = 1) uniform samplerBuffer poses;

#include "shared_vertex.glsl"
#include "pose_table.glsl"

layout(location = 0) out vec3 position;
layout(location = 1) out vec3 normal;
layout(location = 2) out vec2 texel;
layout(location = 3) out float open_share;

void main() {
    SharedVertex vertex = shared_vertex(uint(gl_VertexIndex));
    Pose pose = pose_of(vertex.object);
    position = place_in_world(pose, vertex.position);
    normal = turn_to_world(pose, unpack_normal(vertex.normal));
    texel = vertex.texel;
    open_share = vertex.openness;
    gl_Position = params.clip_from_world * vec4(position, 1.0);
}
