//! What is known of a cell, an owned texel, while particles claim cells. Twin of `shaders/include/claims.glsl`.

/// Several particles are in it: then it stays taken to the end of the step.
pub const SHARED_CELL: u32 = 0;
/// One particle is in it.
pub const TAKEN: u32 = 1;
/// No particle is in it, and none has claimed it.
pub const FREE: u32 = u32::MAX;

/// Ids have fewer bits than these.
const RANKS: u32 = u32::MAX >> 1;

/// The rank of a particle in a step: above [`TAKEN`] and below [`FREE`]. A bijection of 31 bits, so that no two ranks are equal, made as
/// the finalizer of MurmurHash3 (Appleby).
#[must_use]
pub fn rank_of(id: u32, salt: u32) -> u32 {
    let mut h = id.wrapping_add(salt) & RANKS;
    h ^= h >> 16;
    h = h.wrapping_mul(0x85eb_ca6b) & RANKS;
    h ^= h >> 13;
    h = h.wrapping_mul(0xc2b2_ae35) & RANKS;
    h ^= h >> 16;
    h + 2
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Would catch: a rank that two particles have, or one that says of a cell that it is taken or free.
    #[test]
    fn no_two_ranks_are_equal_and_none_says_something_else() {
        for salt in [0, 1, 0x1234_5678, u32::MAX] {
            let mut ranks: Vec<u32> = (0..200_000).map(|id| rank_of(id, salt)).collect();
            // The ids at the other end of the range.
            ranks.extend((RANKS - 1000..=RANKS).map(|id| rank_of(id, salt)));
            assert!(ranks.iter().all(|&rank| rank > TAKEN && rank < FREE));
            let count = ranks.len();
            ranks.sort_unstable();
            ranks.dedup();
            assert_eq!(ranks.len(), count);
        }
        // The one with the lowest id is not first.
        let first = |salt| (0..100).min_by_key(|&id| rank_of(id, salt));
        assert_ne!(first(1), first(2));
    }
}
