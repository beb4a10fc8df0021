// limit: which selected particles leave if more are selected than the lists hold: those with the smallest keys. A key is the
// particle's id, mixed by a bijection that differs from step to step: no two are equal, and none is always first. Twin of
// src/sim/step/limit.rs.

#ifndef MYXO_LIMIT
#define MYXO_LIMIT

// Bins of half a key.
const uint BINS = 65536u;

// The finalizer of MurmurHash3 (Appleby), a bijection. The salt is that of the step.
uint key_of(uint id, uint salt) {
    uint h = id + salt;
    h ^= h >> 16u;
    h *= 0x85ebca6bu;
    h ^= h >> 13u;
    h *= 0xc2b2ae35u;
    return h ^ (h >> 16u);
}

#endif
