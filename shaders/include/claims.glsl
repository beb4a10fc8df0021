// claims: what is known of a cell, an owned texel, while particles claim cells. Twin of src/sim/claims.rs.
// Two words say it: in `goals`, to which cell what is in it would come; in `bids`, the lowest claim to it.
// Cells have ranks, mixed from their numbers, and a particle has the rank of the cell that it is in. So all know the rank of what may be
// in the cell that they claim, and read nothing to know it. A claim is low if the particle's rank is above that of the cell, and high
// otherwise; of low ones, and of high ones, that of the lower rank is lower. The lowest claim wins the cell if the cell is empty. It also
// wins if it is low and what is in the cell has won its own goal: so a particle wins if the row of particles ahead of it ends at an empty
// cell within the step's rounds. Ranks fall along a row, so it ends. Where no two claim one empty cell, this is moving one after the
// other by ranks.
// No order shows, because no two cells have one rank.
// Several particles may be in one cell. Then its goal is a mark that no row passes, and the cell stays taken to the end of the step. They
// have one rank: those that would come to the same cell come there together, or stay. No particle of another cell joins them.

#ifndef MYXO_CLAIMS
#define MYXO_CLAIMS

// No particle is in a cell, or claims it.
const uint FREE = 0xffffffffu;
// In place of the goal: several particles are in the cell.
const uint SHARED = 0u;

// Numbers of cells and ids have no more bits than these: larger textures are refused, and so are more particles than cells.
const uint RANK_BITS = 30u;
const uint RANKS = (1u << RANK_BITS) - 1u;
// Added to the ranks of particles that may only come to a cell that was empty: they come after those that may come to it in any case.
const uint BELOW = 1u << RANK_BITS;
// Added to the ranks of particles that come over from other objects: they come after all others.
const uint LANDING = 2u << RANK_BITS;

// The rank of a cell in a step, or of an id: a bijection of 30 bits, made as the finalizer of MurmurHash3 (Appleby).
uint rank_of(uint number, uint salt) {
    uint h = (number + salt) & RANKS;
    h ^= h >> 16u;
    h = (h * 0x85ebca6bu) & RANKS;
    h ^= h >> 13u;
    h = (h * 0xc2b2ae35u) & RANKS;
    h ^= h >> 16u;
    return h;
}

// The claim of what has this rank to a cell of the rank `there`.
uint claim_of(uint rank, uint there) {
    return rank > there ? rank : BELOW + rank;
}

// What `goals` has of a goal. It is above SHARED, and below FREE.
uint goal_word(uint cell) {
    return cell + 1u;
}

uint goal_of(uint word) {
    return word - 1u;
}

#endif
