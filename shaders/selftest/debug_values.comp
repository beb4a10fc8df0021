// debug_values: writes three debug values per invocation.
// Reads   nothing.
// Writes  the debug list.
// One invocation per element.
// Overflow: values that do not fit are counted and dropped.
#version 460
#include "debug.glsl"

layout(local_size_x = 64) in;
layout(push_constant) uniform Params { uint count; } params;

void main() {
    uint i = invocation_index();
    if (i >= params.count) return;
    debug_value(7u, i * 2u);
    debug_value(8u, -int(i));
    debug_value(9u, float(i) + 0.5);
}
