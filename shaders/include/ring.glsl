// ring: slots of windows, which lie one after the other in a ring, and the flags of particles. Twin of Window and Motion in
// src/sim/types.rs.

#ifndef MYXO_RING
#define MYXO_RING

// The flag of particles that are to leave their object in the present step.
const uint SELECTED = 1u;
// The flag of particles that were refused a cell in the last step, and so left no deposit.
const uint STAYED = 2u;
// The flag of particles that are dead.
const uint DEAD = 4u;
// For how many steps a particle has been hungry, if particles die of that.
const uint HUNGRY_SHIFT = 3u;
const uint MOST_HUNGRY = 8191u;
// For how many more steps a particle is fed.
const uint FED_SHIFT = 16u;

// The slot of particle i of a window that begins at `start`, in a ring of `ring` slots.
uint ring_slot(uint start, uint i, uint ring) {
    uint slot = start + i;
    return slot >= ring ? slot - ring : slot;
}

// How far a slot lies behind `start`: the inverse of ring_slot.
uint ring_offset(uint start, uint slot, uint ring) {
    return slot >= start ? slot - start : slot + (ring - start);
}

// For how many steps a particle with these flags has been hungry.
uint hungry_steps(uint flags) {
    return (flags >> HUNGRY_SHIFT) & MOST_HUNGRY;
}

#endif
