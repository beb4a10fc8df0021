// disc: paints in one colour.
#version 460

layout(push_constant) uniform Params { vec4 color; float size; } params;
layout(location = 0) out vec4 color;

void main() {
    color = params.color;
}
