// loops: have the loops of an invocation gone on to their ends?
//
// Mesa's CPU driver, lavapipe, gives the invocations that keep step with each other 65,535 rounds, of all their loops
// together (LP_MAX_TGSI_LOOP_ITERATIONS). From there on it leaves every loop after one round, whatever the condition says.
// Other devices do not. Searches in a tree need more near the middle of a closed mesh of tens of thousands of triangles,
// which are all about as near. What is found is near then, but need not be the nearest.
//
// Searches do not count their rounds. Kernels that must not take a wrong answer for a right one ask here, once, behind
// their searches. src/sim/loops.rs is for what the host does about that limit.

#ifndef MYXO_LOOPS
#define MYXO_LOOPS

// Have all searches so far come to their ends? False also if the last of the rounds went by in asking, or if only an
// invocation has used them up that keeps step with this one.
bool searches_ended() {
    // Two rounds are one too many where none are left. Compilers must not see that the number is 2, or they would unroll the loop.
    uint last = min(gl_NumWorkGroups.x, 1u);
    uint rounds = 0u;
    while (rounds <= last) rounds++;
    return rounds == 2u;
}

#endif
