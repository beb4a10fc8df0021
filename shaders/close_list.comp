// close_list: fixes how many of the selected particles leave their objects in this step.
// Reads   flow.
// Writes  flow, and the groups of the kernels that follow.
// One invocation; counts made on the device stay there.
// Overflow: entries beyond the capacity were never written. Then the kernels limit_* make a new list; otherwise they have no groups.

#version 460
#extension GL_GOOGLE_include_directive : require
#include "types.glsl"
#include "index.glsl"
#include "counted.glsl"
#include "transfer_groups.glsl"

layout(local_size_x = 1) in;

layout(push_constant) uniform Params {
    uint particle_count;
    uint capacity;          // of the lists of transfers
    uint transfer_group;    // invocations in a group of the kernels that work on transfers
    uint limit_group;       // the same for those that find out which particles leave
} params;

layout(std430, set = 0, binding = 0) buffer FlowBlock { Flow flow[]; };
layout(std430, set = 0, binding = 1) writeonly buffer Groups { DispatchGroups groups[]; };

void main() {
    if (invocation_index() >= gl_WorkGroupSize.x) return;
    Flow now = flow[0];
    uint leaving = min(now.wanted, params.capacity);
    bool is_full = now.wanted > leaving;
    now.leaving = leaving;
    now.selected = counted(now.selected, now.wanted);
    now.refused = counted(now.refused, now.wanted - leaving);
    now.most_wanted = max(now.most_wanted, now.wanted);
    now.wanted = 0u;
    now.listed = 0u;
    flow[0] = now;
    groups[TRANSFERS] = dispatch_groups(leaving, params.transfer_group);
    groups[EXCESS] = dispatch_groups(is_full ? params.particle_count : 0u, params.limit_group);
    groups[LIMIT] = dispatch_groups(is_full ? 1u : 0u, 1u);
}
