// claims: what is known of a cell, an owned texel, while particles claim cells. Twin of src/sim/claims.rs.
// A word says it: from the lowest on, that it is taken, or the lowest rank that claims it, or that it is free. So one atomic minimum is a claim,
// and a taken cell cannot be claimed. No order shows, because no two ranks are equal.

#ifndef MYXO_CLAIMS
#define MYXO_CLAIMS

// Several particles are in it: then it stays taken to the end of the step.
const uint SHARED_CELL = 0u;
// One particle is in it.
const uint TAKEN = 1u;
// No particle is in it, and none has claimed it.
const uint FREE = 0xffffffffu;

// Ids have fewer bits than these.
const uint RANKS = 0x7fffffffu;

// The rank of a particle in a step: above TAKEN and below FREE. A bijection of 31 bits, made as the finalizer of MurmurHash3 (Appleby).
uint rank_of(uint id, uint salt) {
    uint h = (id + salt) & RANKS;
    h ^= h >> 16u;
    h = (h * 0x85ebca6bu) & RANKS;
    h ^= h >> 13u;
    h = (h * 0xc2b2ae35u) & RANKS;
    h ^= h >> 16u;
    return h + 2u;
}

#endif
