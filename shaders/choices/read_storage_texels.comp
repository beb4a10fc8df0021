// read_storage_texels: sensor readings, with the trail in a storage texel buffer.
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
    uint pitch;  // texels from one atlas row to the next
} params;

layout(r32f, set = 0, binding = 2) uniform readonly imageBuffer trail;

#define TRAIL_OF(column, row) imageLoad(trail, int((row) * params.pitch + (column))).x
#include "sensors.glsl"

void main() {
    uint i = invocation_index();
    if (i >= params.particle_count) return;
    read_sensors(i);
}
