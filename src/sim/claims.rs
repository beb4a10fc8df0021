//! What is known of a cell, an owned texel, while particles claim cells. Twin of `shaders/include/claims.glsl`, which says what its two
//! words mean, and of `shaders/include/rows.glsl`.

use crate::mesh::atlas::MAX_SIZE;

/// No particle is in a cell, or claims it.
pub const FREE: u32 = u32::MAX;
/// In place of the goal: several particles are in the cell.
pub const SHARED: u32 = 0;

/// Numbers of cells and ids have no more bits than these: larger textures are refused, and so are more particles than cells.
const RANK_BITS: u32 = 30;
const RANKS: u32 = (1 << RANK_BITS) - 1;
const _: () = assert!((MAX_SIZE as u64).pow(2) <= 1 << RANK_BITS);
/// Added to the ranks of particles that may only come to a cell that was empty: they come after those that may come to it in any case.
pub const BELOW: u32 = 1 << RANK_BITS;
/// Added to the ranks of particles that come over from other objects: they come after all others.
pub const LANDING: u32 = 2 << RANK_BITS;

/// The rank of a cell in a step, or of an id: a bijection of 30 bits, so that no two ranks are equal, made as the finalizer of MurmurHash3
/// (Appleby).
#[must_use]
pub fn rank_of(number: u32, salt: u32) -> u32 {
    let mut h = number.wrapping_add(salt) & RANKS;
    h ^= h >> 16;
    h = h.wrapping_mul(0x85eb_ca6b) & RANKS;
    h ^= h >> 13;
    h = h.wrapping_mul(0xc2b2_ae35) & RANKS;
    h ^= h >> 16;
    h
}

/// The claim of what has this rank to a cell of the rank `there`.
#[must_use]
pub fn claim_of(rank: u32, there: u32) -> u32 {
    if rank > there { rank } else { BELOW + rank }
}

/// What is kept of a goal. It is above [`SHARED`], and below [`FREE`].
#[must_use]
pub fn goal_word(cell: u32) -> u32 {
    cell + 1
}

/// A particle takes its cell, and claims its goal. A step within a cell needs no claim. Twin of what `shaders/wish.comp` does.
pub fn claim(cell: u32, goal: u32, salt: u32, (goals, bids): (&mut [u32], &mut [u32])) {
    let word = &mut goals[cell as usize];
    *word = if *word == FREE {
        goal_word(goal)
    } else {
        SHARED
    };
    if goal != cell {
        let bid = &mut bids[goal as usize];
        *bid = (*bid).min(claim_of(rank_of(cell, salt), rank_of(goal, salt)));
    }
}

/// All cells after particles have claimed them; each has one element per texel, for owned ones.
#[derive(Clone, Copy, Debug)]
pub struct Claimed<'a> {
    /// To which cell what is in it would come, as [`goal_word`] has it, or [`SHARED`], or [`FREE`].
    pub goals: &'a [u32],
    /// The lowest claim to it.
    pub bids: &'a [u32],
    /// Makes ranks differ from step to step.
    pub salt: u32,
}

impl Claimed<'_> {
    /// The round, from 1 on, in which what is in a cell wins another one, its goal; `None` if it does not win it in so many rounds.
    #[must_use]
    pub fn won_in(&self, cell: u32, goal: u32, rounds: u32) -> Option<u32> {
        let (mut rank, mut goal) = (rank_of(cell, self.salt), goal);
        for round in 1..=rounds {
            let there = rank_of(goal, self.salt);
            let claim = claim_of(rank, there);
            if self.bids[goal as usize] != claim {
                return None;
            }
            match self.goals[goal as usize] {
                FREE => return Some(round),
                SHARED => return None,
                _ if claim >= BELOW => return None,
                // What is in it must win its own goal first.
                word => (rank, goal) = (there, word - 1),
            }
        }
        None
    }

    /// May a particle that comes over from another object have a cell? Not one that a particle of its own object claims, even if that
    /// stays because it would win the cell in a later round than the last, or because its rank is too low.
    #[must_use]
    pub fn is_open(&self, cell: u32, rounds: u32) -> bool {
        let is_left = || match self.goals[cell as usize] {
            FREE => true,
            SHARED => false,
            word => self.won_in(cell, word - 1, rounds).is_some(),
        };
        self.bids[cell as usize] >= LANDING && is_left()
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

    /// Would catch: a particle that comes to a cell before the one in it has moved, a high claim that beats a low one, and a landing that
    /// beats either.
    #[test]
    fn claims_come_first_by_who_may_come_in_any_case() {
        let ranks = [0, 1, 2, 77, RANKS - 1, RANKS];
        for there in ranks {
            for one in ranks.into_iter().filter(|&rank| rank != there) {
                let claim = claim_of(one, there);
                assert_eq!(claim < BELOW, one > there);
                for other in ranks.into_iter().filter(|&rank| rank != there) {
                    let goes_first = (one > there, other) > (other > there, one);
                    assert_eq!(claim < claim_of(other, there), goes_first);
                    assert!((claim + 1..FREE).contains(&(LANDING + other)));
                }
            }
        }
        for goal in [0, 1, RANKS] {
            assert!((SHARED + 1..FREE).contains(&goal_word(goal)));
        }
    }

    /// A row of five particles, each in the cell that the next one would come to, on a line of seven cells of which the last is empty. The
    /// ranks of the cells fall along the line.
    ///
    /// Would catch: a round too many or too few, a winner over a lower claim, rows that pass shared cells, and cells that are left or taken
    /// for those that come over.
    #[test]
    fn a_row_moves_by_one_particle_a_round() {
        const SALT: u32 = 7;
        let mut line: Vec<u32> = (0..7).collect();
        line.sort_unstable_by_key(|&cell| RANKS - rank_of(cell, SALT));
        let at = |k: usize| line[k] as usize;
        let mut goals = [FREE; 7];
        let mut bids = [FREE; 7];
        for k in 1..6 {
            claim(line[k], line[k + 1], SALT, (&mut goals, &mut bids));
        }
        let row = Claimed {
            goals: &goals,
            bids: &bids,
            salt: SALT,
        };
        // The round in which the particle at a place moves.
        let round = |row: Claimed<'_>, k: usize| row.won_in(line[k], line[k + 1], 14);
        let open = |row: Claimed<'_>, rounds| -> Vec<usize> {
            (0..7).filter(|&k| row.is_open(line[k], rounds)).collect()
        };
        for k in 1..6 {
            assert_eq!(round(row, k), Some(6 - k as u32));
            for rounds in 0..7 {
                let moves = row.won_in(line[k], line[k + 1], rounds).is_some();
                assert_eq!(moves, 6 - k as u32 <= rounds);
                // It has claimed no other cell.
                for other in (0..7).filter(|&other| other != k + 1) {
                    assert_eq!(row.won_in(line[k], line[other], rounds), None);
                }
            }
        }
        // The first cell is left once all have moved, and the others are claimed.
        assert_eq!(open(row, 5), [0, 1]);
        assert_eq!(open(row, 4), [0]);
        // Where a lower claim comes to the empty cell, all of them stay.
        let mut lower = bids;
        lower[at(6)] -= 1;
        let stays = Claimed {
            bids: &lower,
            ..row
        };
        assert!((1..6).all(|k| round(stays, k).is_none()));
        // Where only a particle that comes over claims it, another one still may.
        let mut landing = bids;
        landing[at(6)] = LANDING + 3;
        let over = Claimed {
            bids: &landing,
            ..row
        };
        assert_eq!(open(over, 5), [0, 6]);
        // No row passes a shared cell, and no particle that comes over may have it. That does not depend on the claim to it.
        let mut shared = (goals, bids);
        claim(line[3], line[4], SALT, (&mut shared.0, &mut shared.1));
        assert_eq!((shared.0[at(3)], shared.1), (SHARED, bids));
        for bid in [bids[at(3)], FREE, LANDING + 3] {
            let mut bids = bids;
            bids[at(3)] = bid;
            let row = Claimed {
                goals: &shared.0,
                bids: &bids,
                ..row
            };
            assert!((3..6).all(|k| round(row, k) == Some(6 - k as u32)));
            assert!((1..3).all(|k| round(row, k).is_none()));
            assert_eq!(open(row, 5), [0]);
        }
    }

    /// Would catch: a lower rank that comes to a cell which was taken, or that comes before a higher one; and a step within a cell that
    /// claims it.
    #[test]
    fn lower_ranks_come_only_to_cells_that_were_empty() {
        const SALT: u32 = 3;
        let mut cells: Vec<u32> = (0..5).collect();
        cells.sort_unstable_by_key(|&cell| rank_of(cell, SALT));
        let [low, middle, high, empty, highest] = cells[..] else {
            unreachable!("five cells")
        };
        let outcome = |claims: &[[u32; 2]]| -> Vec<Option<u32>> {
            let (mut goals, mut bids) = ([FREE; 5], [FREE; 5]);
            for &[cell, goal] in claims {
                claim(cell, goal, SALT, (&mut goals, &mut bids));
            }
            let claimed = Claimed {
                goals: &goals,
                bids: &bids,
                salt: SALT,
            };
            let claims = claims.iter();
            claims
                .map(|&[cell, goal]| claimed.won_in(cell, goal, 3))
                .collect()
        };
        assert_eq!(outcome(&[[low, empty]]), [Some(1)]);
        assert_eq!(outcome(&[[low, empty], [middle, empty]]), [Some(1), None]);
        assert_eq!(outcome(&[[low, empty], [highest, empty]]), [None, Some(1)]);
        // What is in the cell leaves it.
        assert_eq!(outcome(&[[low, high], [high, empty]]), [None, Some(1)]);
        assert_eq!(
            outcome(&[[highest, high], [high, empty]]),
            [Some(2), Some(1)]
        );
        assert_eq!(
            outcome(&[[low, high], [highest, high], [high, empty]]),
            [None, Some(2), Some(1)]
        );
        // What stays in its cell has not left it.
        assert_eq!(outcome(&[[highest, high], [high, high]])[0], None);
    }
}
