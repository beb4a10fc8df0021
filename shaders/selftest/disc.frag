#version 460
// disc: paints in one colour.

layout(push_constant) uniform Params { vec4 color; float size; } params;
layout(location = 0) out vec4 color;

void main() {
    color = params.color;
}
