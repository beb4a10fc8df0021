// claims: what is known of a cell, an owned texel, while particles claim cells. Twin of src/sim/claims.rs.
// Three words say it: in `cells`, which rank is in it; in `goals`, to which cell that particle would come; in `bids`, the lowest rank of
// those that would come to it and may. A cell is won by its bid if it is empty, or if what is in it has won its own goal; so a particle
// wins if the row of particles ahead of it ends at an empty cell within the step's rounds. No order shows, because no two ranks are equal.
// Several particles may be in one cell. They store their words one over the other, each as a whole, and any may remain: which of them `cells`
// names is open, and so is what bids for that cell; but its goal is a mark that no row passes, and it stays taken to the end of the step.
// To a taken cell only a higher rank than that in it may come, as if particles moved one after the other by their ranks. So ranks fall
// along a row, and it ends.

#ifndef MYXO_CLAIMS
#define MYXO_CLAIMS

// No particle is in a cell, or claims it.
const uint FREE = 0xffffffffu;
// In place of the goal: several particles are in the cell.
const uint SHARED = 0xffffffffu;

// Ids have fewer bits than these: scenes of more particles are refused.
const uint RANK_BITS = 28u;
const uint RANKS = (1u << RANK_BITS) - 1u;
// In place of the rank of particles that are dead.
const uint NO_RANK = 0xffffffffu;
// Added to the ranks of particles that come over from other objects: they come after all others.
const uint LANDING = 1u << RANK_BITS;

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

// May a particle of this rank come to a cell, once what is in it has left? To a shared cell it may not; its goal says that.
bool may_come(uint rank, uint inside) {
    return inside == FREE || rank > inside;
}

#endif
