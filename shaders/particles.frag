// particles: a round point of light.
// Reads   nothing.
// Writes  the light that is added to the pixel.
// One invocation per pixel of a point.
// Overflow: cannot happen.
#version 460
#include "particles.glsl"

layout(location = 0) flat in vec3 light;

layout(location = 0) out vec4 color;

void main() {
    float strength = 1.0;
    if (params.diameter > 2.0) {
        float distance_from_middle = length(gl_PointCoord - 0.5) * params.diameter;
        strength = clamp(0.5 * params.diameter - distance_from_middle + 0.5, 0.0, 1.0);
    }
    // It covers as much as it is light: beside the point a picture without a background stays clear.
    vec3 added = light * strength;
    color = vec4(added, min(max(added.r, max(added.g, added.b)), 1.0));
}
