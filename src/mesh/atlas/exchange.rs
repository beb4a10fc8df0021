//! Diffusion across seams: which texels exchange with which, and how strongly.
//!
//! Diffusion moves mass between pairs of texels: `A_i du_i = b sum_j S_ij (u_j - u_i)` with the texels' areas `A` and
//! conductances `S_ij = S_ji`, a finite-volume scheme. What one texel loses the other gains, so the sum of value times area does not
//! change, and constants stay constant. Inside a chart the pairs are the eight neighbours of the stencil, each with a ninth of the mean
//! texel area: charts keep angles, and in two dimensions the energy of such a map does not depend on its scale. Those beside seams are in
//! [`conductances`](super::conductances).
//!
//! Texels with all eight neighbours in their chart need no table. All others, and those on the far side of a pair, have
//! a row: which of the eight neighbours they exchange with, and the pairs across seams, one by one.
//!
//! **Invariant:** every pair stands in both rows, or is among both texels' eight neighbours, with the same conductance
//! to the last bit.

use bytemuck::{Pod, Zeroable};
use glam::Vec2;
use rayon::prelude::*;

use super::super::surface::{AtlasMap, NONE, Seam};
use super::GutterTexel;
use super::balance::NINTH;
use super::conductances::{Conductances, Layers};
use super::gutter::Affine;
use super::table::Table;

/// The largest diffusion that one step of these tables always takes; stronger diffusion takes two, unless
/// [`Atlas::greatest_diffusion`](super::Atlas::greatest_diffusion) is greater.
pub const GREATEST_DIFFUSION: f32 = 0.6;

/// The largest share of its mass that a texel gives away in a step, so that no value becomes negative.
const GREATEST_SHARE: f32 = 0.95;

/// A texel smaller than the mean by more than this factor exchanges less than its neighbours would: at [`GREATEST_DIFFUSION`] it would give
/// away more than 95 % of its mass.
pub const GREATEST_DENSITY: f32 = GREATEST_SHARE / (GREATEST_DIFFUSION * 8.0 / 9.0);

/// A gutter texel whose centre is farther than this from its chart, in texels, holds no point of a triangle: half a
/// texel's diagonal, and room for rounding.
const FARTHEST_POINT: f64 = 0.75;

/// Quads of texels in a row of a block: a cache line of them.
pub const BLOCK_QUADS: u32 = 4;

/// Rows of a block, as far apart as the taps of the stencil.
pub const BLOCK_ROWS: u32 = 4;

/// The exchanges of one texel beside a seam.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ExchangeRow {
    /// The owned texel, `y * pitch + x`.
    pub texel: u32,
    /// Index of its first entry.
    pub first: u32,
    /// How many pairs it has besides those in its chart.
    pub pair_count: u32,
    /// Upper 24 bits: how many gutter texels' deposits it takes a part of; their entries come after the pairs. Lower
    /// eight: which of the neighbours in [`ExchangeRow::neighbours`] it exchanges with.
    pub counts_and_mask: u32,
    /// Conductance with each of them.
    pub conductance: f32,
}

/// A texel on the other side of a pair and the conductance, or a gutter texel and the part of its deposits.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ExchangeEntry {
    /// `y * pitch + x`.
    pub texel: u32,
    /// In mean texel areas, or a share.
    pub weight: f32,
}

impl ExchangeRow {
    /// Mask of the eight neighbours that it exchanges with.
    #[must_use]
    pub fn mask(&self) -> u32 {
        self.counts_and_mask & 0xff
    }

    /// How many gutter texels' deposits it takes a part of.
    #[must_use]
    pub fn deposit_count(&self) -> u32 {
        self.counts_and_mask >> 8
    }

    /// Offsets of the neighbours of the mask's bits, from the lowest.
    #[must_use]
    pub fn neighbours(pitch: u32, distance: u32) -> [i64; 8] {
        let (x, y) = (i64::from(distance), i64::from(distance) * i64::from(pitch));
        [-y - x, -y, -y + x, -x, x, y - x, y, y + x]
    }
}

/// The tables of all texels beside seams, in ascending order of texel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Exchange {
    /// One per texel.
    pub rows: Vec<ExchangeRow>,
    /// The entries of all rows.
    pub entries: Vec<ExchangeEntry>,
}

impl Exchange {
    /// The pairs of a row, besides those in its chart.
    #[must_use]
    pub fn pairs(&self, row: &ExchangeRow) -> &[ExchangeEntry] {
        &self.entries[row.first as usize..][..row.pair_count as usize]
    }

    /// The gutter texels whose deposits a row takes up, and its part of each.
    #[must_use]
    pub fn deposits(&self, row: &ExchangeRow) -> &[ExchangeEntry] {
        &self.entries[(row.first + row.pair_count) as usize..][..row.deposit_count() as usize]
    }
}

impl Conductances {
    /// The tables as kernels read them.
    pub(super) fn tables(&self, layers: &Layers) -> Exchange {
        let unlimited = |texel: u32| limit(layers.density[texel as usize], 8.0 * NINTH);
        let limits = self.limits(layers);
        let place = |texel: u32| match self.index[texel as usize] {
            NONE => None,
            k => Some(k as usize),
        };
        let limit_of = |texel: u32| place(texel).map_or_else(|| unlimited(texel), |k| limits[k]);
        // The plain kernel gives a texel all eight pairs, and limits it as if it had no others.
        let differs = |texel: u32| {
            let more = place(texel).is_some_and(|k| {
                let entries = self.pairs.row(k).len() + self.deposits.row(k).len();
                self.at_border[k] || entries > 0 || limits[k] != unlimited(texel)
            });
            let limited = |bit| limit_of(layers.neighbour(texel, bit)) < limit_of(texel);
            more || layers.neighbours_in_chart(texel).any(limited)
        };
        let texels = layers.chosen(differs);

        let entries = Table::collect(
            texels.len(),
            || (),
            |i, (), items: &mut Vec<ExchangeEntry>| {
                let texel = texels[i];
                let own = limit_of(texel);
                for bit in layers.neighbours_in_chart(texel) {
                    let other = layers.neighbour(texel, bit);
                    if limit_of(other) < own {
                        items.push(ExchangeEntry {
                            texel: other,
                            weight: limit_of(other) * NINTH,
                        });
                    }
                }
                let Some(k) = place(texel) else {
                    return;
                };
                for &(other, conductance) in self.pairs.row(k) {
                    items.push(ExchangeEntry {
                        texel: other,
                        weight: conductance * own.min(limit_of(other)),
                    });
                }
                let parts = self.deposits.row(k).iter();
                items.extend(parts.map(|&(texel, weight)| ExchangeEntry { texel, weight }));
            },
        );
        let rows = texels
            .par_iter()
            .enumerate()
            .map(|(i, &texel)| {
                let own = limit_of(texel);
                let mask = layers
                    .neighbours_in_chart(texel)
                    .filter(|&bit| limit_of(layers.neighbour(texel, bit)) >= own)
                    .fold(0, |mask, bit| mask | 1 << bit);
                let deposit_count = place(texel).map_or(0, |k| self.deposits.row(k).len() as u32);
                let first = entries.starts[i];
                ExchangeRow {
                    texel,
                    first,
                    pair_count: entries.starts[i + 1] - first - deposit_count,
                    counts_and_mask: deposit_count << 8 | mask,
                    conductance: own * NINTH,
                }
            })
            .collect();
        Exchange {
            rows,
            entries: entries.items,
        }
    }

    /// The share of its conductances that each texel can keep without giving away too much.
    fn limits(&self, layers: &Layers) -> Vec<f32> {
        let limit_of = |(k, &texel): (usize, &u32)| {
            let inside = layers.mask(texel).count_ones() as f32 * NINTH;
            let pairs = self.pairs.row(k).iter();
            let asked = pairs.fold(inside, |sum, pair| sum + pair.1);
            limit(layers.density[texel as usize], asked)
        };
        self.texels.par_iter().enumerate().map(limit_of).collect()
    }
}

/// The part of its conductances that a texel keeps.
fn limit(density: f32, asked: f32) -> f32 {
    (GREATEST_SHARE / (GREATEST_DIFFUSION * (density * asked))).min(1.0)
}

/// The largest diffusion that one step takes on an atlas of these texels: 1, which is the mean of nine, if no texel gives away too much then,
/// as where all cover nearly the same area.
pub(super) fn greatest_diffusion(density: &[f32], exchange: &Exchange) -> f32 {
    // Those inside charts give to eight neighbours, and those beside seams by their rows; those at a border count as if they gave to eight.
    let inside = density.iter().map(|&density| 8.0 * NINTH * density);
    let rows = exchange.rows.iter().map(|row| {
        let inside = row.mask().count_ones() as f32 * row.conductance;
        let pairs = exchange.pairs(row).iter();
        density[row.texel as usize] * pairs.fold(inside, |sum, pair| sum + pair.weight)
    });
    let most = inside.chain(rows).fold(0.0, f32::max);
    if most <= GREATEST_SHARE {
        1.0
    } else {
        GREATEST_DIFFUSION
    }
}

/// Gutter texels on which particles may deposit: those in which a point of a triangle may lie.
pub(super) fn deposited(maps: &[AtlasMap], pitch: u32, gutter_texels: &[GutterTexel]) -> Vec<bool> {
    gutter_texels
        .par_iter()
        .map(|&GutterTexel { texel, triangle }| {
            let centre = Vec2::new((texel % pitch) as f32, (texel / pitch) as f32) + 0.5;
            Affine::of(&maps[triangle as usize]).distance(centre.as_dvec2()) <= FARTHEST_POINT
        })
        .collect()
}

/// The blocks with anything in them to work on, by their first quads, in ascending order: [`BLOCK_ROWS`] rows of
/// [`BLOCK_QUADS`] quads, `reach` quads apart. They cover the texture; where `reach` is no multiple of a row of quads,
/// some share quads, and both compute the same values.
pub(super) fn used_blocks(density: &[f32], seams: &[Seam], reach: u32) -> Vec<u32> {
    let mut used: Vec<bool> = density
        .par_chunks(4)
        .map(|quad| quad.iter().any(|&density| density > 0.0))
        .collect();
    for seam in seams {
        used[(seam.texel / 4) as usize] = true;
    }
    let is_used = |block: u32| {
        (0..BLOCK_ROWS).any(|row| {
            let quads = block + row * reach..block + row * reach + BLOCK_QUADS;
            quads
                .into_iter()
                .any(|quad| used.get(quad as usize) == Some(&true))
        })
    };
    (0..used.len() as u32)
        .step_by((BLOCK_ROWS * reach) as usize)
        .flat_map(|first| (first..first + reach).step_by(BLOCK_QUADS as usize))
        .filter(|&block| is_used(block))
        .collect()
}
