//! What is known of a cell, an owned texel, while particles claim cells. Twin of `shaders/include/claims.glsl`.

/// Several particles are in it: then it stays taken to the end of the step.
pub const SHARED_CELL: u32 = 0;
/// No particle is in it, and none has claimed it.
pub const FREE: u32 = u32::MAX;

/// Ids have fewer bits than these: scenes of more particles are refused.
pub const RANK_BITS: u32 = 28;
const RANKS: u32 = (1 << RANK_BITS) - 1;
/// In place of the rank of particles that are dead.
pub const NO_RANK: u32 = u32::MAX;
/// In place of the rank of particles that cannot win their cell any more.
pub const REFUSED: u32 = u32::MAX - 1;
/// The round in which particles that come over from other objects claim cells, after all others.
pub const LANDING: u32 = 14;

/// The rank of a particle in a step: a bijection of 28 bits, so that no two ranks are equal, made as the finalizer of MurmurHash3 (Appleby).
#[must_use]
pub fn rank_of(id: u32, salt: u32) -> u32 {
    let mut h = id.wrapping_add(salt) & RANKS;
    h ^= h >> 16;
    h = h.wrapping_mul(0x85eb_ca6b) & RANKS;
    h ^= h >> 13;
    h = h.wrapping_mul(0xc2b2_ae35) & RANKS;
    h ^= h >> 16;
    h
}

/// A cell with one particle, of this rank. Ranks 0 and 1 have one word, but only one of them can be in the cell, and the other one compares
/// right.
#[must_use]
pub fn taken_by(rank: u32) -> u32 {
    rank.max(1)
}

/// Would a particle of this rank move before that in the cell with this word?
#[must_use]
pub fn comes_too_early(rank: u32, word: u32) -> bool {
    word <= RANKS && rank < word
}

/// Does the word say that one particle or several are in the cell?
#[must_use]
pub fn is_taken(word: u32) -> bool {
    word <= RANKS
}

/// The claim of a rank in a round, counted from 0: above [`taken_by`] any rank, not above [`FREE`], and above all claims of earlier rounds.
#[must_use]
pub fn claim_of(rank: u32, round: u32) -> u32 {
    (round + 1) << RANK_BITS | rank
}

/// Has a particle of this rank won the cell with this word, in whichever round?
#[must_use]
pub fn is_won(word: u32, rank: u32) -> bool {
    word > RANKS && word != FREE && word & RANKS == rank
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Would catch: a rank that two particles have.
    #[test]
    fn no_two_ranks_are_equal() {
        for salt in [0, 1, 0x1234_5678, u32::MAX] {
            let mut ranks: Vec<u32> = (0..200_000).map(|id| rank_of(id, salt)).collect();
            // The ids at the other end of the range.
            ranks.extend((RANKS - 1000..=RANKS).map(|id| rank_of(id, salt)));
            assert!(ranks.iter().all(|&rank| rank <= RANKS));
            let count = ranks.len();
            ranks.sort_unstable();
            ranks.dedup();
            assert_eq!(ranks.len(), count);
        }
        // The one with the lowest id is not first.
        let first = |salt| (0..100).min_by_key(|&id| rank_of(id, salt));
        assert_ne!(first(1), first(2));
    }

    /// Would catch: a claim that says of a cell that it is taken or free, one that takes what was won in an earlier round, and a winner that
    /// does not know.
    #[test]
    fn claims_of_later_rounds_leave_what_was_won() {
        for rank in [0, 1, 77, RANKS - 1, RANKS] {
            for round in 0..LANDING {
                let claim = claim_of(rank, round);
                assert!(claim > taken_by(RANKS) && claim < FREE);
                assert!(claim < claim_of(0, round + 1));
                assert!(is_won(claim, rank) && !is_won(claim, rank ^ 1));
            }
            assert!(claim_of(rank, LANDING) > claim_of(RANKS, LANDING - 1));
            for word in [SHARED_CELL, taken_by(rank), FREE] {
                assert!(!is_won(word, rank));
            }
            assert!(!is_won(claim_of(rank, 0), REFUSED) && !is_won(FREE, REFUSED));
        }
    }

    /// Would catch: a particle that gets a cell before the one in it has moved, and ranks 0 and 1, which have one word, that compare wrong.
    #[test]
    fn only_later_ranks_come_to_a_taken_cell() {
        let ranks = [0, 1, 2, 77, RANKS - 1, RANKS];
        for holder in ranks {
            let word = taken_by(holder);
            assert!(is_taken(word) && word != SHARED_CELL);
            for rank in ranks.into_iter().filter(|rank| *rank != holder) {
                assert_eq!(comes_too_early(rank, word), rank < holder);
            }
        }
        // A shared cell stays taken anyway.
        assert!(is_taken(SHARED_CELL) && !comes_too_early(0, SHARED_CELL));
        assert!(!is_taken(FREE) && !comes_too_early(0, FREE));
        assert!(!comes_too_early(0, claim_of(1, 0)));
    }
}
