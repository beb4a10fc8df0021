//! Rows of weights for gutter texels: from reads that may touch gutter texels to owned texels only.

use rayon::prelude::*;

use super::super::surface::{NONE, Seam};
use super::{AtlasError, Control};

/// The most sweeps that replace gutter texels in rows by their own rows.
const MAX_SWEEPS: u32 = 40;

/// A row that changes less than this in a sweep has settled.
const SETTLED: f32 = 1e-5;

/// Texels that a row may hold while it is resolved; the lightest are dropped.
const ROW_CAPACITY: usize = 8;

/// A bilinear read: up to four texels, owned ones and gutter ones.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Taps {
    /// Owned texels from the front; from the back the indices of gutter texels in their list.
    index: [u32; 4],
    weight: [f32; 4],
    owned: u8,
    in_gutter: u8,
}

impl Taps {
    pub(super) fn push_owned(&mut self, texel: u32, weight: f32) {
        let k = self.owned as usize;
        (self.index[k], self.weight[k]) = (texel, weight);
        self.owned += 1;
    }

    pub(super) fn push_gutter(&mut self, index: u32, weight: f32) {
        let k = 3 - self.in_gutter as usize;
        (self.index[k], self.weight[k]) = (index, weight);
        self.in_gutter += 1;
    }

    fn owned(&self) -> impl Iterator<Item = (u32, f32)> + '_ {
        (0..self.owned as usize).map(|k| (self.index[k], self.weight[k]))
    }

    fn in_gutter(&self) -> impl Iterator<Item = (u32, f32)> + '_ {
        (0..self.in_gutter as usize).map(|k| (self.index[3 - k], self.weight[3 - k]))
    }
}

/// The sources of gutter texels, as owned texels only.
///
/// Reads that touch no gutter texel are rows already. The others, the *open* ones, have a slot each; a sweep replaces
/// their gutter texels by the rows of the sweep before, so the order of work does not matter.
pub(super) struct Rows<'a> {
    taps: &'a [Taps],
    /// Per gutter texel: its slot, or [`NONE`].
    slots: Vec<u32>,
    /// Per slot: the gutter texel's index.
    open: Vec<u32>,
    /// Per slot: the row as far as it is resolved.
    rows: Vec<Row>,
}

impl<'a> Rows<'a> {
    /// `nearest` returns an owned texel for the index of a gutter texel: the initial row of gutter texels whose reads touch no owned texel.
    pub(super) fn resolve(
        taps: &'a [Taps],
        control: &Control<'_>,
        nearest: impl Fn(u32) -> u32 + Sync,
    ) -> Result<Self, AtlasError> {
        let open: Vec<u32> = (0..taps.len() as u32)
            .filter(|&k| taps[k as usize].in_gutter > 0)
            .collect();
        let mut slots = vec![NONE; taps.len()];
        for (slot, &k) in open.iter().enumerate() {
            slots[k as usize] = slot as u32;
        }
        let rows = open
            .par_iter()
            .map(|&k| match taps[k as usize].owned {
                0 => Row::of([(nearest(k), 1.0)].into_iter()),
                _ => Row::of(taps[k as usize].owned()),
            })
            .collect();
        let mut rows = Self {
            taps,
            slots,
            open,
            rows,
        };
        let mut active: Vec<u32> = (0..rows.open.len() as u32).collect();
        for _ in 0..MAX_SWEEPS {
            control.check()?;
            let changed = rows.sweep(&active);
            active = rows.unsettled(&changed);
            if active.is_empty() {
                break;
            }
        }
        Ok(rows)
    }

    /// Updates the rows in some slots; returns for every slot whether its row changed.
    ///
    /// Rows move only halfway to their new values: where two charts meet with nearly two texels between them, the gutter texels of both are
    /// at the same places and read almost only each other. Their values would alternate from sweep to sweep; the mean converges.
    fn sweep(&mut self, active: &[u32]) -> Vec<bool> {
        let renewed: Vec<Row> = active
            .par_iter()
            .map(|&slot| {
                let taps = &self.taps[self.open[slot as usize] as usize];
                let behind = taps.in_gutter().flat_map(|(k, weight)| {
                    let row = self.row(k);
                    (0..row.count as usize).map(move |i| (row.texel[i], row.weight[i] * weight))
                });
                let before = self.rows[slot as usize];
                let halved = taps.owned().chain(behind).map(|(t, w)| (t, 0.5 * w));
                Row::of(halved.chain(before.entries().map(|(t, w)| (t, 0.5 * w))))
            })
            .collect();
        let mut changed = vec![false; self.open.len()];
        for (&slot, row) in active.iter().zip(renewed) {
            changed[slot as usize] = row.differs_from(&self.rows[slot as usize]);
            self.rows[slot as usize] = row;
        }
        changed
    }

    fn unsettled(&self, changed: &[bool]) -> Vec<u32> {
        (0..self.open.len() as u32)
            .into_par_iter()
            .filter(|&slot| {
                let taps = &self.taps[self.open[slot as usize] as usize];
                changed[slot as usize]
                    || taps.in_gutter().any(|(k, _)| {
                        let slot = self.slots[k as usize];
                        slot != NONE && changed[slot as usize]
                    })
            })
            .collect()
    }

    /// The row of a gutter texel, by its index in the list of them.
    pub(super) fn row(&self, index: u32) -> Row {
        match self.slots[index as usize] {
            NONE => Row::of(self.taps[index as usize].owned()),
            slot => self.rows[slot as usize],
        }
    }
}

/// Owned texels and their weights, heaviest first; the weights sum to 1 unless there are none.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Row {
    texel: [u32; ROW_CAPACITY],
    weight: [f32; ROW_CAPACITY],
    count: u8,
}

impl Row {
    /// Weights of the same texel are added up, in the order in which they come.
    fn of(entries: impl Iterator<Item = (u32, f32)>) -> Self {
        let mut merged = [(0, 0.0); 5 * ROW_CAPACITY];
        let mut count = 0;
        for (texel, weight) in entries {
            match merged[..count].iter_mut().find(|entry| entry.0 == texel) {
                Some(entry) => entry.1 += weight,
                None => {
                    merged[count] = (texel, weight);
                    count += 1;
                }
            }
        }
        let merged = &mut merged[..count];
        merged.sort_unstable_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let kept = &merged[..count.min(ROW_CAPACITY)];
        let sum: f32 = kept.iter().map(|entry| entry.1).sum();
        let mut row = Self {
            count: kept.len() as u8,
            ..Self::default()
        };
        for (k, &(texel, weight)) in kept.iter().enumerate() {
            row.texel[k] = texel;
            row.weight[k] = weight / sum;
        }
        row
    }

    fn entries(&self) -> impl Iterator<Item = (u32, f32)> + '_ {
        (0..self.count as usize).map(|k| (self.texel[k], self.weight[k]))
    }

    fn differs_from(&self, other: &Row) -> bool {
        self.count != other.count
            || self
                .entries()
                .zip(other.entries())
                .any(|(a, b)| a.0 != b.0 || (a.1 - b.1).abs() > SETTLED)
    }

    /// Keeps the four heaviest and makes the weights sum to exactly 1, in whatever order they are added.
    pub(super) fn into_seam(self, texel: u32) -> Seam {
        assert!(self.count > 0, "gutter texel {texel} has no owned texel");
        let count = self.count.min(4) as usize;
        let sum: f64 = self.weight[..count].iter().map(|&w| f64::from(w)).sum();
        let mut source = [self.texel[0]; 4];
        let mut units = [0.0; 4];
        let all = f64::from(Seam::UNITS);
        for k in 0..count {
            source[k] = self.texel[k];
            units[k] = (f64::from(self.weight[k]) / sum * all).round();
        }
        units[0] += all - units.iter().sum::<f64>();
        Seam::new(texel, source, units.map(|unit| unit as u32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn taps(owned: &[(u32, f32)], in_gutter: &[(u32, f32)]) -> Taps {
        let mut taps = Taps::default();
        for &(texel, weight) in owned {
            taps.push_owned(texel, weight);
        }
        for &(index, weight) in in_gutter {
            taps.push_gutter(index, weight);
        }
        taps
    }

    #[test]
    fn gutter_texels_that_read_each_other_are_resolved() {
        // a = (x + b) / 2 and b = (y + a) / 2 have the solution a = (2 x + y) / 3; c reads a, d is nothing but c.
        let (x, y, z) = (100, 200, 300);
        let taps = [
            taps(&[(x, 0.5)], &[(1, 0.5)]),
            taps(&[(y, 0.5)], &[(0, 0.5)]),
            taps(&[(z, 0.25)], &[(0, 0.75)]),
            taps(&[], &[(2, 1.0)]),
            taps(&[(z, 0.6), (x, 0.4)], &[]),
        ];
        let rows = Rows::resolve(&taps, &Control::default(), |_| 100).unwrap();
        let weight_of = |k: u32, texel: u32| {
            let row = rows.row(k);
            let found = row.entries().find(|entry| entry.0 == texel);
            found.map_or(0.0, |entry| entry.1)
        };
        let expected = [
            (0, x, 2.0 / 3.0),
            (0, y, 1.0 / 3.0),
            (1, y, 2.0 / 3.0),
            (2, x, 0.5),
            (2, z, 0.25),
            (3, x, 0.5),
            (3, y, 0.25),
            (3, z, 0.25),
            (4, z, 0.6),
            (4, y, 0.0),
        ];
        for (k, texel, weight) in expected {
            let found = weight_of(k, texel);
            assert!(
                (found - weight).abs() < 3e-5,
                "row {k}, texel {texel}: {found}"
            );
        }
    }

    #[test]
    fn weights_sum_to_exactly_one_in_any_order() {
        let entries = [(7, 0.31), (9, 0.29), (3, 0.17), (5, 0.13), (4, 0.1)];
        let seam = Row::of(entries.into_iter()).into_seam(1);
        assert_eq!(seam.source, [7, 9, 3, 5]);
        let [a, b, c, d] = seam.weights();
        assert_eq!(((a + b) + c) + d, 1.0);
        assert_eq!(((d + c) + b) + a, 1.0);
        assert!((a - 0.31 / 0.9).abs() < 1e-4);
        let alone = Row::of([(7, 0.3)].into_iter()).into_seam(1);
        assert_eq!((alone.source, alone.units()), ([7; 4], [32_768, 0, 0, 0]));
    }
}
