// stretch: the bins of a group of the kernels that add up bins, and those of an invocation.

#ifndef MYXO_STRETCH
#define MYXO_STRETCH

// Bins that an invocation takes.
const uint RUN = 16u;

// Bins that a group takes. A macro, because gl_WorkGroupSize is a constant only below the layout of the group.
#define STRETCH (RUN * gl_WorkGroupSize.x)
#define first_bin() (RUN * invocation_index())

#endif
