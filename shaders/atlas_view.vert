// atlas_view: shows the unwrapped atlas, flat, by one triangle that covers the picture.
// Reads   nothing; its other stage trail, texels, colors, brightest.
// Writes  the position.
// Three invocations.
// Overflow: cannot happen.
#version 460

void main() {
    vec2 place = vec2((gl_VertexIndex << 1) & 2, gl_VertexIndex & 2);
    gl_Position = vec4(2.0 * place - 1.0, 0.0, 1.0);
}
