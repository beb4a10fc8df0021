#version 460
// mark: one point in the middle of the picture, which tells where it is.
// Reads   nothing.
// Writes  the picture, the debug list.
// One vertex.
// Overflow: told values are counted and dropped.
#include "debug.glsl"

void main() {
    debug_value(1u, uint(gl_VertexIndex) + 10u);
    gl_Position = vec4(0.0, 0.0, 0.5, 1.0);
    gl_PointSize = 1.0;
}
