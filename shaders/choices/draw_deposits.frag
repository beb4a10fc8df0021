// draw_deposits: one more particle; the blending adds it.
// Reads   nothing.
// Writes  the count that is added to the pixel.
// One invocation per particle.
// Overflow: as in the vertex shader.
#version 460

layout(location = 0) out vec4 count;

void main() {
    count = vec4(1.0);
}
