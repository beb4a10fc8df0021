// transfer_groups: where the groups of the dispatches for transfers lie. Twin of `Counter::of` in src/sim/work.rs.

#ifndef MYXO_TRANSFER_GROUPS
#define MYXO_TRANSFER_GROUPS

const uint TRANSFERS = 0u;   // one invocation per transfer
const uint EXCESS = 1u;      // one per particle, where more are selected than the lists hold
const uint LIMIT = 2u;       // one group then
const uint CANDIDATES = 3u;  // one per slot that may hold a particle of another object than its window's
const uint STRAYS = 4u;      // one per entry of the lists of such slots

#endif
