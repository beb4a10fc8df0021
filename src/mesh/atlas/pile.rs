//! One packing of charts on a bitmap, in a given order.

use std::collections::HashMap;

use glam::{DVec2, IVec2};

use super::bitmap::{Bitmap, Shape};
use super::fixed::Fixed;
use super::outline::Mask;
use super::piece::Piece;

/// The texture and the cells that charts are packed by.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sheet {
    pub size: u32,
    pub fixed: Fixed,
    /// Texels along the side of a cell: an odd number.
    pub side: u32,
}

impl Sheet {
    /// With so many cells a side at the most.
    pub(super) fn new(size: u32, gutter: u32, most_cells: u32) -> Self {
        let side = size.div_ceil(most_cells);
        Self {
            size,
            fixed: Fixed::new(size, gutter),
            side: side + 1 - side % 2,
        }
    }

    /// Cells a side.
    pub(super) fn cells(self) -> usize {
        (self.size / self.side) as usize
    }
}

/// The cells of a chart in one orientation.
pub(super) struct Candidate {
    pub shape: Shape,
    /// The sum of the rows of its cells, over their number: how high it lies in its box.
    middle: f64,
    turn: DVec2,
    shift: IVec2,
}

impl Candidate {
    pub(super) fn new(piece: &Piece, sheet: Sheet, turn: DVec2, scale: f64) -> Self {
        let footprint = piece.footprint(sheet.fixed, turn, scale, sheet.side as i32);
        let shape = Shape::new(footprint.filled.mask);
        let rows: usize = (0..shape.height)
            .map(|y| {
                let row = shape.mask.row(y);
                y * row
                    .iter()
                    .map(|word| word.count_ones() as usize)
                    .sum::<usize>()
            })
            .sum();
        Self {
            middle: rows as f64 / shape.count as f64,
            shape,
            turn,
            shift: footprint.shift,
        }
    }
}

/// The place of one chart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spot {
    pub turn: DVec2,
    /// Units.
    pub shift: IVec2,
}

/// Charts on a bitmap.
#[derive(Clone, Debug)]
pub(super) struct Pile {
    /// Per chart: which of its candidates it lies as.
    pub turns: Vec<u8>,
    /// Per chart: column and row.
    places: Vec<[usize; 2]>,
}

impl Pile {
    /// Puts each chart where its middle is lowest, as any of its candidates or as the one given; if all fit.
    pub(super) fn of(
        candidates: &[Vec<Option<Candidate>>],
        order: &[u32],
        turns: &[u8],
        [width, height]: [usize; 2],
    ) -> Option<Self> {
        let mut bitmap = Bitmap::new(width, height);
        let mut pile = Self {
            turns: vec![0; candidates.len()],
            places: vec![[0, 0]; candidates.len()],
        };
        // Where the search for a small mask goes on: what was taken below stays taken.
        let mut below: HashMap<&Mask, usize> = HashMap::new();
        for &index in order {
            let mut best: Option<(f64, usize, u8, [usize; 2])> = None;
            for (k, candidate) in candidates[index as usize].iter().enumerate() {
                let Some(candidate) = candidate else { continue };
                if turns
                    .get(index as usize)
                    .is_some_and(|&turn| turn as usize != k)
                {
                    continue;
                }
                let shape = &candidate.shape;
                let is_small = shape.mask.words.len() <= 16;
                let from = match below.get(&shape.mask) {
                    Some(&from) if is_small => from,
                    _ => 0,
                };
                let highest = match best {
                    // Lower than what is known already, or not at all.
                    Some((least, ..)) => {
                        ((least - candidate.middle).max(-1.0) + 1.0) as usize + shape.height
                    }
                    None => height,
                };
                let Some([x, y]) = bitmap.lowest(shape, from, highest) else {
                    continue;
                };
                if is_small {
                    below.insert(&shape.mask, y);
                }
                let level = y as f64 + candidate.middle;
                if best.is_none_or(|(least, left, ..)| (level, x) < (least, left)) {
                    best = Some((level, x, k as u8, [x, y]));
                }
            }
            let (.., turn, place) = best?;
            let candidate = candidates[index as usize][turn as usize].as_ref()?;
            bitmap.take(&candidate.shape, place);
            pile.turns[index as usize] = turn;
            pile.places[index as usize] = place;
        }
        Some(pile)
    }

    /// How high the pile is, and, where that is the same, how high the charts' tops are on the whole.
    pub(super) fn height(&self, candidates: &[Vec<Option<Candidate>>]) -> (usize, usize) {
        let tops = self.places.iter().zip(&self.turns).zip(candidates);
        let mut height = (0, 0);
        for (([_, y], &turn), candidates) in tops {
            if let Some(Candidate { shape, .. }) = &candidates[turn as usize] {
                let top = y + shape.height;
                height = (height.0.max(top), height.1 + top * shape.count);
            }
        }
        height
    }

    pub(super) fn spots(&self, sheet: Sheet, candidates: &[Vec<Option<Candidate>>]) -> Vec<Spot> {
        let step = sheet.side as i32 * sheet.fixed.texel;
        let charts = self.places.iter().zip(&self.turns).zip(candidates);
        charts
            .map(|(([x, y], &turn), candidates)| {
                let candidate = candidates[turn as usize].as_ref();
                let candidate = candidate.expect("charts lie as they were tried");
                Spot {
                    turn: candidate.turn,
                    shift: candidate.shift + IVec2::new(*x as i32, *y as i32) * step,
                }
            })
            .collect()
    }
}
