// claims: what is known of a cell, an owned texel, while particles claim cells. Twin of src/sim/claims.rs.
// A word says it: from the lowest on, that it is taken, and by which rank, or the lowest claim, or that it is free. So one atomic minimum is a
// claim, and a taken cell cannot be claimed. A claim is the round, above the particle's rank: what was won in an earlier round stays as it is,
// and winners need not be marked. No order shows, because no two ranks are equal.
// A taken cell can only be won by a particle of a higher rank than that in it, as if particles moved one after the other by their ranks.

#ifndef MYXO_CLAIMS
#define MYXO_CLAIMS

// Several particles are in it: then it stays taken to the end of the step.
const uint SHARED_CELL = 0u;
// No particle is in it, and none has claimed it.
const uint FREE = 0xffffffffu;

// Ids have fewer bits than these: scenes of more particles are refused.
const uint RANK_BITS = 28u;
const uint RANKS = (1u << RANK_BITS) - 1u;
// In place of the rank of particles that are dead.
const uint NO_RANK = 0xffffffffu;
// In place of the rank of particles that cannot win their cell any more.
const uint REFUSED = 0xfffffffeu;
// The round in which particles that come over from other objects claim cells, after all others.
const uint LANDING = 14u;

// The rank of a particle in a step: a bijection of 28 bits, made as the finalizer of MurmurHash3 (Appleby).
uint rank_of(uint id, uint salt) {
    uint h = (id + salt) & RANKS;
    h ^= h >> 16u;
    h = (h * 0x85ebca6bu) & RANKS;
    h ^= h >> 13u;
    h = (h * 0xc2b2ae35u) & RANKS;
    h ^= h >> 16u;
    return h;
}

// A cell with one particle, of this rank. Ranks 0 and 1 have one word, but only one of them can be in the cell, and the other one compares
// right.
uint taken_by(uint rank) {
    return max(rank, 1u);
}

// Would a particle of this rank move before that in the cell with this word?
bool comes_too_early(uint rank, uint word) {
    return word <= RANKS && rank < word;
}

// The claim of a rank in a round of this number, from 0 on.
uint claim_of(uint rank, uint number) {
    return number + 1u << RANK_BITS | rank;
}

// Has a particle of this rank won the cell with this word, in whichever round?
bool is_won(uint word, uint rank) {
    return word > RANKS && word != FREE && (word & RANKS) == rank;
}

#endif
