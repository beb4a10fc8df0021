// index: the number of an invocation, right also where a dispatch has more than 65,535 groups and takes two dimensions.
// Kernels compare it with their count first: the last groups reach past the end.

#ifndef MYXO_INDEX
#define MYXO_INDEX

// A macro, because gl_WorkGroupSize is silently (1, 1, 1) in whatever stands above the layout of the group.
#define invocation_index() \
    ((gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * gl_WorkGroupSize.x + gl_LocalInvocationID.x)

#endif
