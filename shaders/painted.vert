// painted: tints what attracts, repels or may not be entered, over the surface.
// Reads   shared_vertices, poses; its other stage bias.
// Writes  the vertex's place, a little nearer than the surface, and its position in the atlas.
// One invocation per vertex, or more where the device does not keep what it has shaded.
// Overflow: cannot happen; indices are those of vertices.
#version 460
#include "types.glsl"
#include "shading.glsl"
#include "painted.glsl"

layout(set = 0, binding = 0) uniform usamplerBuffer shared_vertices;
layout(set = 0, binding = 1) uniform samplerBuffer poses;

#include "shared_vertex.glsl"
#include "pose_table.glsl"

layout(location = 0) centroid out vec2 texel;

void main() {
    SharedVertex vertex = shared_vertex(uint(gl_VertexIndex));
    texel = vertex.texel;
    gl_Position = params.clip_from_world * vec4(place_in_world(pose_of(vertex.object), vertex.position), 1.0);
    // Depths grow towards the eye.
    gl_Position.z *= 1.0005;
}
