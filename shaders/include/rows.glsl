// rows: particles of which each waits for the cell that the next one is in. Twin of `won_in` in src/sim/claims.rs.
// The includer declares `goals`, and a function `bid_of` that reads `bids`.

#ifndef MYXO_ROWS
#define MYXO_ROWS

#include "texels.glsl"
#include "claims.glsl"

// The round, from 1 on, in which what is in a cell wins another one, its goal; 0 if it does not win it in so many rounds.
uint won_in(uint cell, uint goal, uint salt, uint rounds) {
    uint rank = rank_of(cell, salt);
    for (uint round = 1u; round <= rounds; round += 1u) {
        uint there = rank_of(goal, salt);
        uint claim = claim_of(rank, there);
        if (bid_of(goal) != claim) return 0u;
        uint next = texel_of(goals, goal);
        if (next == FREE) return round;
        if (next == SHARED || claim >= BELOW) return 0u;
        // What is in it must win its own goal first.
        rank = there;
        goal = goal_of(next);
    }
    return 0u;
}

#endif
