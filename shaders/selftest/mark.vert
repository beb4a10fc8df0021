// mark: one point in the middle of the picture, which writes its position as debug values.
// Reads   nothing.
// Writes  the picture, the debug list.
// One vertex.
// Overflow: values that do not fit are counted and dropped.
#version 460
#include "debug.glsl"

void main() {
    debug_value(1u, uint(gl_VertexIndex) + 10u);
    gl_Position = vec4(0.0, 0.0, 0.5, 1.0);
    gl_PointSize = 1.0;
}
