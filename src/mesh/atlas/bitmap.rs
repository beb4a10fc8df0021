//! Finding free places for masks in a bitmap, 64 places at a time.
//!
//! For each row of the bitmap there is a table: level `k` has a bit at `x` when any of the `2^k` cells from `x` on is
//! taken. A run of `n` cells of a mask is free at `x` if two bits of one level are clear, for any `n`; by shifting, 64 values of `x` are
//! tested at once. Rows whose longest free run is shorter than the widest run are skipped.

use super::outline::{Mask, next};

/// A mask, prepared for the search.
#[derive(Clone, Debug)]
pub(super) struct Shape {
    pub width: usize,
    pub height: usize,
    /// Cells in it.
    pub count: usize,
    /// Row, first column and length of every run; those that are most likely blocked come first.
    runs: Vec<(u32, u32, u32)>,
    pub mask: Mask,
}

impl Shape {
    pub(super) fn new(mask: Mask) -> Self {
        let mut runs: Vec<(u32, u32, u32)> = (0..mask.height)
            .flat_map(|y| {
                let runs = mask.runs(y);
                runs.into_iter()
                    .map(move |(from, to)| (y as u32, from as u32, (to - from) as u32))
            })
            .collect();
        // The widest first, then rows from all over: bits of the row number reversed.
        if let Some(widest) = (0..runs.len()).max_by_key(|&k| (runs[k].2, usize::MAX - k)) {
            runs.swap(0, widest);
            runs[1..].sort_unstable_by_key(|run| (run.0.reverse_bits(), run.1));
        }
        Self {
            width: mask.width,
            height: mask.height,
            count: mask.count(),
            runs,
            mask,
        }
    }

    /// The number of runs, a measure of the work of a search.
    pub(super) fn run_count(&self) -> usize {
        self.runs.len()
    }
}

/// The cells that are taken.
#[derive(Clone, Debug)]
pub(super) struct Bitmap {
    width: usize,
    height: usize,
    /// Words a row and level, one more than the cells need.
    pitch: usize,
    levels: usize,
    /// Row by row, level by level.
    words: Vec<u64>,
    /// Per row: the longest free run.
    longest: Vec<u32>,
}

impl Bitmap {
    pub(super) fn new(width: usize, height: usize) -> Self {
        let pitch = width / 64 + 2;
        let levels = width.ilog2() as usize + 1;
        Self {
            width,
            height,
            pitch,
            levels,
            words: vec![0; pitch * levels * height],
            longest: vec![width as u32; height],
        }
    }

    fn row(&self, y: usize, level: usize) -> &[u64] {
        &self.words[(y * self.levels + level) * self.pitch..][..self.pitch]
    }

    /// The lowest free place for a shape, and of those the leftmost, not below `from` and with its top at or below
    /// `highest`.
    pub(super) fn lowest(&self, shape: &Shape, from: usize, highest: usize) -> Option<[usize; 2]> {
        let highest = highest.min(self.height);
        if shape.width > self.width || shape.height > highest {
            return None;
        }
        let places = self.width - shape.width + 1;
        let word_count = places.div_ceil(64);
        let mut blocked = [0u64; 16];
        let mut spare = Vec::new();
        let blocked = if word_count <= 16 {
            &mut blocked[..word_count]
        } else {
            spare.resize(word_count, 0);
            &mut spare[..]
        };
        let (row, _, length) = shape.runs[0];
        (from..=highest - shape.height)
            .filter(|y| self.longest[y + row as usize] >= length)
            .find_map(|y| {
                blocked.fill(0);
                if !places.is_multiple_of(64) {
                    blocked[word_count - 1] = !0 << (places % 64);
                }
                for &(row, column, length) in &shape.runs {
                    let level = length.ilog2() as usize;
                    let bits = self.row(y + row as usize, level);
                    let column = column as usize;
                    let mut all = block(blocked, bits, column);
                    let rest = length as usize - (1 << level);
                    if rest > 0 {
                        all = block(blocked, bits, column + rest);
                    }
                    if all == !0 {
                        return None;
                    }
                }
                let x = next(blocked, 0, true)?;
                Some([x, y])
            })
    }

    /// Takes the cells of a shape at a place.
    pub(super) fn take(&mut self, shape: &Shape, [x, y]: [usize; 2]) {
        let pitch = self.pitch;
        for row in 0..shape.height {
            let bits = shape.mask.row(row);
            let start = (y + row) * self.levels * pitch;
            let (word, shift) = (x / 64, x % 64);
            let table = &mut self.words[start..start + self.levels * pitch];
            for (k, &bits) in bits.iter().enumerate() {
                table[word + k] |= bits << shift;
                if shift > 0 {
                    table[word + k + 1] |= bits >> (64 - shift);
                }
            }
            for level in 1..self.levels {
                let (low, high) = table.split_at_mut(level * pitch);
                let (low, high) = (&low[(level - 1) * pitch..], &mut high[..pitch]);
                high.copy_from_slice(low);
                block(&mut high[..pitch - 1], low, 1 << (level - 1));
            }
            let free = self.longest_free(y + row);
            self.longest[y + row] = free;
        }
    }

    fn longest_free(&self, y: usize) -> u32 {
        let row = self.row(y, 0);
        let (mut longest, mut x) = (0, 0);
        while let Some(from) = next(row, x, true).filter(|&from| from < self.width) {
            let to = next(row, from, false).unwrap_or(self.width);
            longest = longest.max(to - from);
            x = to;
        }
        longest as u32
    }
}

/// Adds the bits from `offset` on; returns the bits that are set in all words.
fn block(blocked: &mut [u64], bits: &[u64], offset: usize) -> u64 {
    let (word, shift) = (offset / 64, offset % 64);
    let bits = &bits[word.min(bits.len())..];
    let mut all = !0;
    if shift == 0 {
        for (blocked, &low) in blocked.iter_mut().zip(bits) {
            *blocked |= low;
        }
        for blocked in blocked.iter() {
            all &= *blocked;
        }
    } else {
        let high = bits.iter().skip(1).copied().chain([0]);
        for (blocked, (&low, high)) in blocked.iter_mut().zip(bits.iter().zip(high)) {
            *blocked |= low >> shift | high << (64 - shift);
        }
        for blocked in blocked.iter() {
            all &= *blocked;
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, random};

    fn random_mask(seed: u32, width: usize, height: usize) -> Mask {
        let mut mask = Mask::new(width, height);
        for y in 0..height {
            let words = random(seed, y as u32, 0, Purpose::Start);
            let from = words[0] as usize % width;
            let to = from + 1 + words[1] as usize % (width - from);
            mask.take(y, from, to);
            let from = words[2] as usize % width;
            mask.take(y, from, from + 1);
        }
        mask
    }

    #[test]
    fn places_are_the_lowest_free_ones() {
        for side in [5, 64, 70, 130, 1100] {
            let mut bitmap = Bitmap::new(side, side);
            let mut taken = vec![false; side * side];
            let mut placed = 0;
            for seed in 0..40 {
                let words = random(3, seed, side as u32, Purpose::Start);
                let most = (side as u32 / 2).min(80);
                let [width, height] = [words[0], words[1]].map(|w| 1 + (w % most) as usize);
                let mask = random_mask(seed, width, height);
                let is_free = |x: usize, y: usize| {
                    (0..height).all(|j| {
                        mask.runs(j)
                            .iter()
                            .all(|&(from, to)| (from..to).all(|i| !taken[(y + j) * side + x + i]))
                    })
                };
                let places =
                    (0..=side - height).flat_map(|y| (0..=side - width).map(move |x| [x, y]));
                let expected = places.into_iter().find(|&[x, y]| is_free(x, y));
                let shape = Shape::new(mask.clone());
                assert_eq!(bitmap.lowest(&shape, 0, side), expected, "{side} {seed}");
                let Some([x, y]) = expected else { continue };
                bitmap.take(&shape, [x, y]);
                placed += 1;
                for j in 0..height {
                    for (from, to) in mask.runs(j) {
                        taken[(y + j) * side + x..][from..to].fill(true);
                    }
                }
            }
            assert!(placed > 3, "{side}");
        }
    }
}
