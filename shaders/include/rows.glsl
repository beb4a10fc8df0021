// rows: particles of which each waits for the cell that the next one is in. Twin of `won_in` in src/sim/claims.rs.
// The includer declares `cells` and `goals`, and a function `bid_of` that reads `bids`.

#ifndef MYXO_ROWS
#define MYXO_ROWS

#include "texels.glsl"
#include "claims.glsl"

// The round, from 1 on, in which a particle of this rank wins a cell; 0 if it does not win it in so many rounds.
uint won_in(uint cell, uint rank, uint rounds) {
    for (uint round = 1u; round <= rounds; round += 1u) {
        if (bid_of(cell) != rank) return 0u;
        rank = texel_of(cells, cell);
        if (rank == FREE) return round;
        // What is in it must win its own goal first.
        cell = texel_of(goals, cell);
        if (cell == SHARED) return 0u;
    }
    return 0u;
}

#endif
