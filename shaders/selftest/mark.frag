#version 460
// mark: white.
#include "debug.glsl"

layout(location = 0) out vec4 color;

void main() {
    debug_value(2u, gl_FragCoord.x);
    color = vec4(1.0);
}
