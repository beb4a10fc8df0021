//! What is known of a cell, an owned texel, while particles claim cells. Twin of `shaders/include/claims.glsl`.

/// Several particles are in it: then it stays taken to the end of the step.
pub const SHARED_CELL: u32 = 0;
/// One particle is in it.
pub const TAKEN: u32 = 1;
/// No particle is in it, and none has claimed it.
pub const FREE: u32 = u32::MAX;

/// Ids have fewer bits than these: scenes of more particles are refused.
pub const RANK_BITS: u32 = 28;
const RANKS: u32 = (1 << RANK_BITS) - 1;
/// In place of the rank of particles that are dead.
pub const NO_RANK: u32 = u32::MAX;
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

/// The claim of a rank in a round, counted from 0: above [`TAKEN`], not above [`FREE`], and above all claims of earlier rounds.
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
                assert!(claim > TAKEN && claim < FREE);
                assert!(claim < claim_of(0, round + 1));
                assert!(is_won(claim, rank) && !is_won(claim, rank ^ 1));
            }
            assert!(claim_of(rank, LANDING) > claim_of(RANKS, LANDING - 1));
            for word in [SHARED_CELL, TAKEN, FREE] {
                assert!(!is_won(word, rank));
            }
        }
    }
}
