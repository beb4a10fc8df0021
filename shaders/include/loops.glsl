// loops: have the loops of an invocation continued to their ends?
//
// Mesa's CPU driver, lavapipe, gives the invocations that keep step with each other 65,535 rounds, of all their loops
// together (LP_MAX_TGSI_LOOP_ITERATIONS). After that it exits every loop after one round, whatever the condition is.
// Other devices do not. Searches in a tree need more near the middle of a closed mesh of tens of thousands of triangles,
// which are all about as near. The face that is found is then near, but need not be the nearest.
//
// Searches do not count their rounds. A kernel that must not use a wrong result calls searches_ended() after its searches. src/sim/loops.rs
// has the host's part.

#ifndef MYXO_LOOPS
#define MYXO_LOOPS

// Have all searches so far come to their ends? Also false if the search of another invocation that runs in step with this one has not. If
// it is false, no loop continues, not even the caller's.
bool searches_ended() {
    // If no rounds remain, this loop ends after the first of its two. Its count is hidden from compilers, which would unroll it.
    uint last = min(gl_NumWorkGroups.x, 1u);
    uint rounds = 0u;
    while (rounds <= last) rounds++;
    return rounds == 2u;
}

#endif
