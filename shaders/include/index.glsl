// index: the number of an invocation, right also where a dispatch has more than 65,535 groups and takes two dimensions.
// Kernels compare it with their count first: the last groups reach past the end.

#ifndef MYXO_INDEX
#define MYXO_INDEX

// A macro, because gl_WorkGroupSize is silently (1, 1, 1) in whatever stands above the layout of the group.
#define invocation_index() \
    ((gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * gl_WorkGroupSize.x + gl_LocalInvocationID.x)

// The groups of an indirect dispatch; the host has an equal struct.
struct DispatchGroups { uint x; uint y; uint z; };

// The groups of an indirect dispatch with `count` invocations.
DispatchGroups dispatch_groups(uint count, uint group_size) {
    uint groups = count / group_size + uint(count % group_size != 0u);
    uint rows = (groups + 65534u) / 65535u;
    return DispatchGroups(rows == 0u ? 0u : (groups + rows - 1u) / rows, rows, 1u);
}

#endif
