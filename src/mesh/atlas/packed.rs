//! The tables of exchanges over seams as kernels take them: few wide words, contiguous in the order in which they are read. [`Exchange`]
//! has the same content.

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

use super::exchange::{Exchange, ExchangeEntry, ExchangeRow};

/// The exchanges of one texel beside a seam: two texels of four words.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct PackedRow {
    /// The owned texel, `y * pitch + x`.
    pub texel: u32,
    /// Index of its first two pairs.
    pub first_pair: u32,
    /// The end of its pairs, and the beginning of the entries of gutter texels whose deposits it takes a part of.
    pub first_deposit: u32,
    /// The end of the entries of gutter texels.
    pub end: u32,
    /// Mask of the neighbours that it exchanges with, as in [`ExchangeRow::mask`].
    pub mask: u32,
    /// Conductance with each of them.
    pub conductance: f32,
    /// Its density, here so that the kernel reads no other memory for it.
    pub density: f32,
    /// Always 0.
    pub pad: u32,
}

/// Two entries; the second may be padding with weight 0.
pub type PackedEntries = [ExchangeEntry; 2];

/// The tables of all texels beside seams.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PackedExchange {
    /// One per texel, sorted by the number of entries, so that neighbouring invocations have loops of equal length.
    pub rows: Vec<PackedRow>,
    /// The entries of all rows, in the order of rows, so that reads are contiguous.
    pub entries: Vec<PackedEntries>,
}

impl Exchange {
    /// The tables as kernels read them, for texels with these densities.
    #[must_use]
    pub fn packed(&self, density: &[f32]) -> PackedExchange {
        let mut rows: Vec<&ExchangeRow> = self.rows.iter().collect();
        rows.par_sort_by_key(|row| {
            let (pairs, deposits) = (row.pair_count, row.deposit_count());
            (pairs.div_ceil(2), deposits.div_ceil(2), row.texel)
        });
        let mut entries = Vec::with_capacity(self.packed_entries());
        let pack = |row: &&ExchangeRow| {
            // Padding of a row's entries to even numbers: the texel itself, with weight 0.
            let nothing = ExchangeEntry {
                texel: row.texel,
                weight: 0.0,
            };
            let mut add = |of: &[ExchangeEntry]| {
                let first = entries.len() as u32;
                let twos = of.chunks(2);
                entries.extend(twos.map(|two| [two[0], *two.get(1).unwrap_or(&nothing)]));
                (first, entries.len() as u32)
            };
            let (first_pair, _) = add(self.pairs(row));
            let (first_deposit, end) = add(self.deposits(row));
            PackedRow {
                texel: row.texel,
                first_pair,
                first_deposit,
                end,
                mask: row.mask(),
                conductance: row.conductance,
                density: density[row.texel as usize],
                pad: 0,
            }
        };
        PackedExchange {
            rows: rows.iter().map(pack).collect(),
            entries,
        }
    }

    /// The number of pairs of entries.
    #[must_use]
    pub fn packed_entries(&self) -> usize {
        let twos = |row: &ExchangeRow| row.pair_count.div_ceil(2) + row.deposit_count().div_ceil(2);
        self.rows.par_iter().map(|row| twos(row) as usize).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packed_rows_say_what_rows_say() {
        let entry = |texel: u32| ExchangeEntry {
            texel,
            weight: texel as f32 / 64.0,
        };
        // Rows with no entries, even and odd numbers of either kind.
        let counts = [(3, 2), (0, 0), (2, 1), (4, 0), (0, 3)];
        let mut exchange = Exchange::default();
        for (k, (pair_count, deposit_count)) in counts.into_iter().enumerate() {
            let first = exchange.entries.len() as u32;
            exchange.rows.push(ExchangeRow {
                texel: 7 * k as u32,
                first,
                pair_count,
                counts_and_mask: deposit_count << 8 | 0x80 | k as u32,
                conductance: 0.1 * k as f32,
            });
            (exchange.entries).extend((0..pair_count + deposit_count).map(|e| entry(first + e)));
        }
        let density: Vec<f32> = (0..29).map(|texel| texel as f32).collect();
        let packed = exchange.packed(&density);
        assert_eq!(packed.entries.len(), exchange.packed_entries());
        assert_eq!(packed.rows.len(), exchange.rows.len());
        let lengths: Vec<u32> = (packed.rows.iter())
            .map(|row| row.first_deposit - row.first_pair)
            .collect();
        assert!(lengths.is_sorted(), "{lengths:?}");
        for packed_row in &packed.rows {
            let row = &exchange.rows[packed_row.texel as usize / 7];
            let said = |from: u32, to: u32, expected: &[ExchangeEntry]| {
                let twos = packed.entries[from as usize..to as usize].as_flattened();
                assert_eq!(&twos[..expected.len()], expected);
                assert!(twos.len() - expected.len() < 2);
                let rest = &twos[expected.len()..];
                assert!(rest.iter().all(|e| e.texel == row.texel && e.weight == 0.0));
            };
            said(
                packed_row.first_pair,
                packed_row.first_deposit,
                exchange.pairs(row),
            );
            said(
                packed_row.first_deposit,
                packed_row.end,
                exchange.deposits(row),
            );
            assert_eq!(packed_row.mask, row.mask());
            assert_eq!(packed_row.conductance, row.conductance);
            assert_eq!(packed_row.density, density[row.texel as usize]);
        }
    }
}
