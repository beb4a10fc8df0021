// painted: tints places that attract, repel or may not be entered, over the surface.
// Reads   corners, vertices, strips, poses; its other stage bias.
// Writes  the corner's place, a little nearer than the surface, and its position in the atlas.
// Three invocations per triangle.
// Overflow: cannot happen; the draw has three vertices for each triangle.
#version 460
#include "types.glsl"
#include "shading.glsl"
#include "painted.glsl"

layout(set = 0, binding = 0) uniform usamplerBuffer corners;
layout(set = 0, binding = 1) uniform usamplerBuffer vertices;
layout(set = 0, binding = 2) uniform usamplerBuffer strips;
layout(set = 0, binding = 3) uniform samplerBuffer poses;

#include "placed.glsl"
#include "strip_table.glsl"

layout(location = 0) centroid out vec2 texel;

void main() {
    uint corner = uint(gl_VertexIndex);
    uint triangle = corner / 3u;
    uint k = corner - 3u * triangle;
    Vertex vertex = vertex_of(corner);
    AtlasMap map = atlas_map_of(triangle);
    texel = map.origin + (k == 1u ? map.du : vec2(0.0)) + (k == 2u ? map.dv : vec2(0.0));
    gl_Position = params.clip_from_world * vec4(place_in_world(pose_of(vertex.object), vertex.position), 1.0);
    // Depths grow towards the eye.
    gl_Position.z *= 1.0005;
}
