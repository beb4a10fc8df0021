//! What is known of a cell, an owned texel, while particles claim cells. Twin of `shaders/include/claims.glsl`, which says what its three
//! words mean.

/// No particle is in a cell, or claims it.
pub const FREE: u32 = u32::MAX;
/// In place of the goal: several particles are in the cell.
pub const SHARED: u32 = u32::MAX;

/// Ids have fewer bits than these: scenes of more particles are refused.
pub const RANK_BITS: u32 = 28;
const RANKS: u32 = (1 << RANK_BITS) - 1;
/// In place of the rank of particles that are dead.
pub const NO_RANK: u32 = u32::MAX;
/// Added to the ranks of particles that come over from other objects: they come after all others.
pub const LANDING: u32 = 1 << RANK_BITS;

/// The rank of a particle in a step: a bijection of 28 bits, so that no two ranks are equal, made as the finalizer of MurmurHash3
/// (Appleby).
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

/// May a particle of this rank come to a cell, once what is in it has left? To a shared cell it may not; its goal says that.
#[must_use]
pub fn may_come(rank: u32, inside: u32) -> bool {
    inside == FREE || rank > inside
}

/// All cells while particles claim them; each has one element per texel, for owned ones.
#[derive(Clone, Copy)]
pub struct Claimed<'a> {
    /// Which rank is in a cell.
    pub cells: &'a [u32],
    /// For a taken cell: to which one the particle in it would come, or [`SHARED`].
    pub goals: &'a [u32],
    /// The lowest rank of the particles that would come to a cell and may.
    pub bids: &'a [u32],
}

impl Claimed<'_> {
    /// The round, from 1 on, in which a particle of this rank wins a cell; `None` if it does not win it in so many rounds.
    /// Twin of `shaders/include/rows.glsl`.
    #[must_use]
    pub fn won_in(&self, cell: u32, rank: u32, rounds: u32) -> Option<u32> {
        let (mut cell, mut rank) = (cell, rank);
        for round in 1..=rounds {
            let k = cell as usize;
            if self.bids[k] != rank {
                return None;
            }
            rank = self.cells[k];
            if rank == FREE {
                return Some(round);
            }
            cell = self.goals[k];
            if cell == SHARED {
                return None;
            }
        }
        None
    }

    /// May a particle that comes over from another object have a cell? Not one that a particle of its own object claims, even if that
    /// stays because it would win the cell in a later round than the last.
    #[must_use]
    pub fn is_open(&self, cell: u32, rounds: u32) -> bool {
        let inside = self.cells[cell as usize];
        let is_left = || {
            let goal = self.goals[cell as usize];
            goal != SHARED && self.won_in(goal, inside, rounds).is_some()
        };
        self.bids[cell as usize] >= LANDING && (inside == FREE || is_left())
    }
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

    /// Would catch: a particle that gets a cell before the one in it has moved, and a landing before others.
    #[test]
    fn only_later_ranks_come_to_a_taken_cell() {
        let ranks = [0, 1, 2, 77, RANKS - 1, RANKS];
        for holder in ranks {
            for rank in ranks {
                assert_eq!(may_come(rank, holder), rank > holder);
                assert!(LANDING + rank > holder && LANDING + rank < FREE);
            }
            assert!(may_come(holder, FREE));
        }
    }

    /// A row of five particles, each in the cell that the next one would come to, on a line of seven cells of which the last is empty.
    ///
    /// Would catch: a round too many or too few, a winner over a lower bid, rows that pass shared cells, and cells that are left or taken for
    /// those that come over.
    #[test]
    fn a_row_moves_by_one_particle_a_round() {
        let ranks = [50, 40, 30, 20, 10];
        let mut cells = [FREE; 7];
        let mut goals = [0; 7];
        let mut bids = [FREE; 7];
        for (k, rank) in ranks.into_iter().enumerate() {
            cells[k + 1] = rank;
            goals[k + 1] = k as u32 + 2;
            bids[k + 2] = rank;
        }
        let row = Claimed {
            cells: &cells,
            goals: &goals,
            bids: &bids,
        };
        for (k, rank) in (0..).zip(ranks) {
            let cell = k + 2;
            for rounds in 0..7 {
                let round = 5 - k;
                let expected = (round <= rounds).then_some(round);
                assert_eq!(row.won_in(cell, rank, rounds), expected);
                assert_eq!(row.won_in(cell, rank + 1, rounds), None);
            }
        }
        // The first cell is left once all have moved, and the others are claimed.
        let open = |row: Claimed<'_>, rounds| -> Vec<u32> {
            let cells = 0..7;
            cells.filter(|&cell| row.is_open(cell, rounds)).collect()
        };
        assert_eq!(open(row, 5), [0, 1]);
        assert_eq!(open(row, 4), [0]);
        // Where a lower rank comes to the empty cell, all of them stay.
        let mut lower = bids;
        lower[6] = 3;
        let row = Claimed {
            bids: &lower,
            ..row
        };
        for (k, rank) in (0..).zip(ranks) {
            assert_eq!(row.won_in(k + 2, rank, 14), None);
        }
        // Where only a particle that comes over claims it, another one still may.
        let mut landing = bids;
        landing[6] = LANDING + 3;
        let row = Claimed {
            bids: &landing,
            ..row
        };
        assert_eq!(open(row, 5), [0, 6]);
        // No row passes a shared cell, and no particle that comes over may have it. That does not depend on the bid for it.
        let mut shared = goals;
        shared[3] = SHARED;
        for bid in [bids[3], FREE, LANDING + 3] {
            let mut bids = bids;
            bids[3] = bid;
            let row = Claimed {
                goals: &shared,
                bids: &bids,
                ..row
            };
            for (k, rank) in (2..).zip(&ranks[2..]) {
                assert_eq!(row.won_in(k + 2, *rank, 14), Some(5 - k));
            }
            assert_eq!(row.won_in(2, ranks[0], 14), None);
            assert_eq!(row.won_in(3, ranks[1], 14), None);
            assert_eq!(open(row, 5), [0]);
        }
    }
}
