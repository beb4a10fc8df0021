// append: places in lists that many invocations append to. An atomic counter counts the entries. In the form for graphics
// cards one invocation of a subgroup counts for all that append together: many atomic additions to one word take turns.
// Invocations that append together reconverge behind the branch of the one that counts, as present compilers make them.
// No twin: the twins push in a loop.

#ifndef MYXO_APPEND
#define MYXO_APPEND

#ifdef MYXO_CARD

#extension GL_KHR_shader_subgroup_ballot : require

// Declares `place`, that of this invocation's entry. Every invocation that gets here together must name one counter. A macro,
// because counters lie in buffers.
#define append_to(counter, place) \
    uint place = 0u; \
    { \
        uvec4 together = subgroupBallot(true); \
        if (subgroupElect()) place = atomicAdd(counter, subgroupBallotBitCount(together)); \
        place = subgroupBroadcastFirst(place) + subgroupBallotExclusiveBitCount(together); \
    }

// The counters that a subgroup counts together for; for any more, each invocation counts alone.
const uint COUNTED_TOGETHER = 4u;

// Declares `place` where each invocation names one of many counters, `counters[which]`, and neighbours mostly share one.
#define append_to_one_of(counters, which, place) \
    uint place = 0u; \
    { \
        bool waits = true; \
        for (uint turn = 0u; waits && turn < COUNTED_TOGETHER; turn += 1u) { \
            uint first = subgroupBroadcastFirst(which); \
            if (which == first) { \
                append_to(counters[first], of_those) \
                place = of_those; \
                waits = false; \
            } \
        } \
        if (waits) place = atomicAdd(counters[which], 1u); \
    }

#else

#define append_to(counter, place) uint place = atomicAdd(counter, 1u);
#define append_to_one_of(counters, which, place) uint place = atomicAdd(counters[which], 1u);

#endif

#endif
