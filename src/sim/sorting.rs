//! Particles in the order in which they lie together in the atlas, every so often: what a group of them reads and counts
//! then lies together too. No result depends on the order, because ids go along.
//!
//! With windows each object's particles stay in its window. By one strategy each particle keeps its slot for good.

use crate::mesh::atlas::Atlas;

/// Steps from one sort to the next: a particle takes about twice as many to leave a tile. On `trio` each step since the last
/// sort makes `advance` 0.3 to 0.5 ms dearer and a sort takes 42 ms, which is least together at 13 to 17 steps.
pub const SORT_INTERVAL: u64 = 16;

/// Tiles have at least this side, as a power of two, in texels.
const SMALLEST_SHIFT: u32 = 4;

/// Bins that are few enough to be added up in no time.
const MOST_BINS: u32 = 1 << 18;

/// Tiles of the atlas.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tiles {
    /// log2 of a tile's side, texels.
    pub shift: u32,
    /// Tiles side by side.
    pub a_row: u32,
    /// All of them.
    pub count: u32,
}

impl Tiles {
    /// The smallest that are few enough where so many windows each have all of them.
    #[must_use]
    pub fn of(atlas: &Atlas, windows: usize) -> Self {
        let most = (MOST_BINS / windows as u32).max(1);
        let tiles = |shift: u32| {
            let a_row = atlas.size.div_ceil(1 << shift);
            Self {
                shift,
                a_row,
                count: a_row * a_row,
            }
        };
        let mut shifts = SMALLEST_SHIFT..=16;
        shifts
            .find(|&shift| tiles(shift).count <= most)
            .map_or(tiles(16), tiles)
    }
}

/// Are particles sorted at the end of a step? Starts have no order, so they are after the first one.
#[must_use]
pub fn is_due(step: u64) -> bool {
    step.is_multiple_of(SORT_INTERVAL)
}

/// How many bins there are, by the strategy that has most: it may change while the simulation runs.
pub(super) fn bins(atlas: &Atlas, objects: usize) -> usize {
    let bins = |windows: usize| Tiles::of(atlas, windows).count as usize * windows;
    bins(1).max(bins(objects))
}
