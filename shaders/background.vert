// background: one triangle that covers the picture, at depth 0, which nothing lies behind.
// Reads   nothing.
// Writes  the place in the picture, (0, 0) at the top left and (1, 1) at the bottom right.
// Three invocations.
// Overflow: cannot happen.
#version 460

layout(location = 0) out vec2 place;

void main() {
    place = vec2((gl_VertexIndex << 1) & 2, gl_VertexIndex & 2);
    gl_Position = vec4(2.0 * place - 1.0, 0.0, 1.0);
}
