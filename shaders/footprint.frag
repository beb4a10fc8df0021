// footprint: how much of the sky the lowest object above a place of the ground hides from it.
// Reads   the height above the ground.
// Writes  the share that is hidden, as red.
// One invocation per cell that an object covers.
// Overflow: cannot happen.
#version 460
#include "footprint.glsl"

layout(location = 0) in float height;

layout(location = 0) out vec4 color;

void main() {
    color = vec4(exp(-4.0 * height / params.extent), 0.0, 0.0, 1.0);
}
