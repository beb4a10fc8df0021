//! The texels of a chart: those whose centres lie in it or within reach of it.
//!
//! The set of places within reach of a chart is the chart and a square round each point of its border (a Minkowski sum),
//! so only the border's edges are needed. All computations are in whole numbers: moving a chart by whole texels moves its texels by as
//! many.

use glam::IVec2;

/// Rows and columns of square cells, of which the one in column 0 and row 0 begins at the origin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cells {
    /// Units a cell's side; even.
    pub side: i32,
    /// The largest distance from a cell's centre, in units along both axes, at which a chart takes the cell.
    pub reach: i32,
}

impl Cells {
    fn first_at_or_after(self, place: i32) -> i32 {
        (place - self.side / 2 + self.side - 1).div_euclid(self.side)
    }

    fn last_at_or_before(self, place: i32) -> i32 {
        (place - self.side / 2).div_euclid(self.side)
    }

    fn centre(self, index: i32) -> i32 {
        index * self.side + self.side / 2
    }

    /// The rows that an edge takes cells in: first, and one past the last.
    pub(super) fn rows(self, [a, b]: [IVec2; 2]) -> (i32, i32) {
        (
            self.first_at_or_after(a.y.min(b.y) - self.reach),
            self.last_at_or_before(a.y.max(b.y) + self.reach) + 1,
        )
    }

    /// The columns that an edge takes in a row that it reaches: first, and one past the last.
    pub(super) fn columns(self, [a, b]: [IVec2; 2], row: i32) -> (i32, i32) {
        let [low, high] = if a.y <= b.y { [a, b] } else { [b, a] };
        let centre = self.centre(row);
        let (from, to) = if high.y - low.y <= self.side / 8 {
            // A nearly horizontal edge takes slightly more than needed, without a division.
            (low.x.min(high.x), low.x.max(high.x))
        } else {
            let bottom = low.y.max(centre - self.reach);
            let top = high.y.min(centre + self.reach);
            let (dx, dy) = (i64::from(high.x - low.x), i64::from(high.y - low.y));
            let along = |y: i32| dx * i64::from(y - low.y);
            let (at_bottom, at_top) = (along(bottom), along(top));
            let (least, most) = (at_bottom.min(at_top), at_bottom.max(at_top));
            (
                low.x + least.div_euclid(dy) as i32,
                low.x - (-most).div_euclid(dy) as i32,
            )
        };
        (
            self.first_at_or_after(from - self.reach),
            self.last_at_or_before(to + self.reach) + 1,
        )
    }
}

/// A set of cells.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Mask {
    pub width: usize,
    pub height: usize,
    /// 64-bit words per row.
    pub pitch: usize,
    pub words: Vec<u64>,
}

impl Mask {
    pub(super) fn new(width: usize, height: usize) -> Self {
        let pitch = width.div_ceil(64);
        Self {
            width,
            height,
            pitch,
            words: vec![0; pitch * height],
        }
    }

    pub(super) fn row(&self, y: usize) -> &[u64] {
        &self.words[y * self.pitch..][..self.pitch]
    }

    /// Takes the cells of a row from column `from` to before column `to`.
    pub(super) fn take(&mut self, y: usize, from: usize, to: usize) {
        let row = &mut self.words[y * self.pitch..][..self.pitch];
        for (index, word) in row
            .iter_mut()
            .enumerate()
            .take(to.div_ceil(64))
            .skip(from / 64)
        {
            let low = from.saturating_sub(64 * index);
            let high = (to - 64 * index).min(64);
            *word |= (!0u64 >> (64 - (high - low))) << low;
        }
    }

    pub(super) fn count(&self) -> usize {
        self.words
            .iter()
            .map(|word| word.count_ones() as usize)
            .sum()
    }

    /// Per row its runs of cells: first, and one past the last.
    pub(super) fn runs(&self, y: usize) -> Vec<(usize, usize)> {
        let row = self.row(y);
        let mut runs = Vec::new();
        let mut x = 0;
        while let Some(from) = next(row, x, false) {
            let to = next(row, from, true).unwrap_or(64 * self.pitch);
            runs.push((from, to));
            x = to;
        }
        runs
    }
}

/// The first bit at or after `x` that is set, or not set.
pub(super) fn next(row: &[u64], x: usize, inverted: bool) -> Option<usize> {
    let flip = if inverted { !0 } else { 0 };
    let mut index = x / 64;
    let mut word = (row.get(index)? ^ flip) & (!0 << (x % 64));
    while word == 0 {
        index += 1;
        word = row.get(index)? ^ flip;
    }
    Some(64 * index + word.trailing_zeros() as usize)
}

/// The texels of a chart.
pub(super) struct Filled {
    pub mask: Mask,
    /// Cells whose centres are inside.
    pub inside: usize,
    /// Does the border wind around some cell's centre more than once, or clockwise?
    pub overlaps: bool,
}

/// The cells that a chart takes, from its closed border, counter-clockwise, in units. Cells in negative rows and columns are left out.
pub(super) fn fill(edges: &[[IVec2; 2]], cells: Cells) -> Filled {
    let mut high = IVec2::ZERO;
    for edge in edges {
        high = high.max(edge[0]).max(edge[1]);
    }
    let width = cells.last_at_or_before(high.x + cells.reach) + 1;
    let height = cells.last_at_or_before(high.y + cells.reach) + 1;
    let (width, height) = (width.max(1) as usize, height.max(1) as usize);
    let mut mask = Mask::new(width, height);
    let stride = width + 1;
    let mut turns = vec![0i16; stride * height];
    for &[a, b] in edges {
        let (first, end) = cells.rows([a, b]);
        for row in first.max(0)..end.min(height as i32) {
            let (from, to) = cells.columns([a, b], row);
            let (from, to) = (from.max(0), to.min(width as i32));
            if from < to {
                mask.take(row as usize, from as usize, to as usize);
            }
        }
        // Half-open in y, so that an edge's end counts for one of the two edges that meet there.
        let (low, high, turn) = if a.y > b.y { (b, a, 1) } else { (a, b, -1) };
        let first = cells.first_at_or_after(low.y);
        let end = cells.first_at_or_after(high.y);
        let (dx, dy) = (i64::from(high.x - low.x), i64::from(high.y - low.y));
        for row in first..end {
            let y = cells.centre(row);
            let x = low.x - (-dx * i64::from(y - low.y)).div_euclid(dy) as i32;
            let column = cells.first_at_or_after(x).clamp(0, width as i32);
            turns[row as usize * stride + column as usize] += turn;
        }
    }
    let (mut inside, mut overlaps) = (0, false);
    for y in 0..height {
        let mut round = 0;
        let mut from = 0;
        for x in 0..width {
            let turn = turns[y * stride + x];
            if turn != 0 {
                if round == 0 {
                    from = x;
                }
                overlaps |= round + turn < 0 || round + turn > 1;
                if round != 0 && round + turn == 0 {
                    mask.take(y, from, x);
                    inside += x - from;
                }
                round += turn;
            }
        }
        if round != 0 {
            mask.take(y, from, width);
            inside += width - from;
        }
    }
    Filled {
        mask,
        inside,
        overlaps,
    }
}
