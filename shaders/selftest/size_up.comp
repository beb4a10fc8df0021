#version 460
// size_up: makes the groups of an indirect dispatch on the device.
// Reads   nothing.
// Writes  groups.
// One invocation.
// Overflow: none.
#include "index.glsl"

layout(local_size_x = 1) in;
layout(std430, binding = 0) writeonly buffer Groups { DispatchGroups groups[]; };
layout(push_constant) uniform Params { uint count; uint group_size; } params;

void main() {
    if (invocation_index() > 0u) return;
    groups[0] = dispatch_groups(params.count, params.group_size);
}
