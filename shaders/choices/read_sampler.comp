// read_sampler: sensor readings, with the trail in an image that the device's sampler interpolates.
// Reads   places, trail.
// Writes  values.
// One invocation per particle.
// Overflow: cannot happen; nothing is appended.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "index.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform Params {
    uint particle_count;
    vec2 texel;  // a texel's part of the image
} params;

layout(set = 0, binding = 2) uniform sampler2D trail;

#define SENSED(position) textureLod(trail, (position) * params.texel, 0.0).x
#include "sensors.glsl"

void main() {
    uint i = invocation_index();
    if (i >= params.particle_count) return;
    read_sensors(i);
}
