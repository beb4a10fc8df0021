// disc: one triangle a centre, with its corners computed by the shader; a test of drawing.
// Reads   centres.
// Writes  the picture.
// One instance per centre, three vertices each.
// Overflow: none.
#version 460

layout(std430, binding = 0) readonly buffer Centres { vec2 centres[]; };
layout(push_constant) uniform Params { vec4 color; float size; } params; // Linear.

void main() {
    vec2 corner = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1) * 2.0 - 0.5;
    gl_Position = vec4(centres[gl_InstanceIndex] + params.size * corner, 0.5, 1.0);
}
