// surface: draws every object's triangles, lit, with the trail on them.
// Reads   corners, vertices, normals, strips, poses, openness, charts; its other stage trail, colors, brightest, distances.
// Writes  the corner's place, normal, uv and openness, and the triangle, its map to the atlas and its chart's colour.
// Three invocations per triangle; nothing is indexed, because pixels need their own triangle's map to the atlas.
// Overflow: cannot happen; the draw has three vertices for each triangle.
#version 460
#include "types.glsl"
#include "shading.glsl"
#include "surface.glsl"
#include "corner.glsl"

// As in the other stage: is it the second look?
layout(constant_id = 3) const bool LOOKS = false;

layout(set = 0, binding = 8) readonly buffer Charts { uint charts[]; };

layout(location = 7) flat out uint chart;

void main() {
    place_corner(uint(gl_VertexIndex));
    chart = charts[triangle];
    // Over the first look, whose depth other shaders may have rounded in another way.
    if (LOOKS) gl_Position.z *= 1.0005;
}
