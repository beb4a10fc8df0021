// claims: what is known of a cell, an owned texel, while particles claim cells. Twin of src/sim/claims.rs.
// Two words say it: in `goals`, to which cell what is in it would come; in `bids`, the lowest claim to it. A cell is won by the lowest claim
// if it is empty, or if what is in it has won its own goal; so a particle wins if the row of particles ahead of it ends at an empty cell
// within the step's rounds.
// Particles move as if one after the other by their ranks. The rank of a particle is that of the cell it is in, mixed from the cell's number,
// so all know the rank of what may be in the cell that they claim, and read nothing to know it. To a taken cell only a higher rank than its
// own may come, so ranks fall along a row, and it ends. Lower ranks come after all higher ones, and only if the cell was empty from the start.
// No order shows, because no two cells have one rank.
// Several particles may be in one cell. Then its goal is a mark that no row passes, and it stays taken to the end of the step. They have one
// rank: those of them that would come to the same cell come there together, or stay. So what shares a cell parts, and nothing joins it.

#ifndef MYXO_CLAIMS
#define MYXO_CLAIMS

// No particle is in a cell, or claims it.
const uint FREE = 0xffffffffu;
// In place of the goal: several particles are in the cell.
const uint SHARED = 0u;

// Numbers of cells and ids have no more bits than these: larger textures are refused, and particles than cells.
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
