// counted: counters that stay at the largest number instead of wrapping round. Twin: `saturating_add`.

#ifndef MYXO_COUNTED
#define MYXO_COUNTED

const uint MOST_COUNTED = 0xffffffffu;

uint counted(uint before, uint more) {
    return before + min(more, MOST_COUNTED - before);
}

// Adds one, by many invocations at once. An invocation that passes the largest number sets the counter back to it. A macro,
// because the counter lies in a buffer.
#define count_one(counter) \
    { if (atomicAdd(counter, 1u) == MOST_COUNTED) { atomicMax(counter, MOST_COUNTED); } }

#endif
