// fields: draws every object's triangles in colours that show another field than the trail.
// Reads   corners, vertices, normals, strips, poses, openness; its other stage trail, colors, brightest, deposits, density,
//         distances, nearest, object_colors.
// Writes  the corner's place, normal, uv and openness, and the triangle and its map to the atlas.
// Three invocations per triangle; nothing is indexed, because a vertex has another normal and uv in each triangle.
// Overflow: cannot happen; the draw has three vertices for each triangle.
#version 460
#include "types.glsl"
#include "shading.glsl"
#include "fields.glsl"
#include "corner.glsl"

void main() {
    place_corner(uint(gl_VertexIndex));
}
