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
    /// The sheet of a texture, with at most so many cells a side.
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
    /// The mean row of its cells in its box.
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
    /// Puts each chart at the place where its middle is lowest, in any of its orientations or the given one; `None` if not all fit.
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
        // The row from which the search for a mask continues: places below were taken and stay so.
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
                    // Only places lower than the best one so far count.
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

    /// The height of the pile, and for ties the sum of the heights of the charts' tops.
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
