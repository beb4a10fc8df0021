//! Diffusion across seams: which texels exchange with which, and how strongly.
//!
//! Diffusion moves mass between pairs of texels: `A_i du_i = b sum_j S_ij (u_j - u_i)` with the texels' areas `A` and
//! conductances `S_ij = S_ji`, a finite-volume scheme. Whatever one texel loses the other gains, so the sum of value
//! times area stays, and constants stay constant. Inside a chart the pairs are the eight neighbours of the stencil, each
//! with a ninth of the mean texel area: charts keep angles, and in two dimensions the energy of such a map does not
//! depend on its scale. Across a seam a gutter texel stands for the owned texels `j` that it is filled from: a texel `i`
//! with gutter texels `k` among its neighbours would read `X_ij = sum_k w_kj / 9`, and `S = (X + X^T) / 2` is the
//! symmetric exchange nearest to that. As such it would push mass to one side of the seam: [`balance`](super::balance)
//! then changes these conductances, and those in charts beside them, until linear fields are nearly steady.
//!
//! Texels with all eight neighbours in their chart need no table. All others, and those on the far side of a pair, have
//! a row: which of the eight neighbours they exchange with, and the pairs across seams, one by one.
//!
//! **Invariant:** every pair stands in both rows, or is among both texels' eight neighbours, with the same conductance
//! to the last bit.

use bytemuck::{Pod, Zeroable};
use glam::{DVec2, Mat2, Vec2};
use rayon::prelude::*;

use super::super::surface::{AtlasMap, NONE, Seam};
use super::GutterTexel;
use super::balance::{Demand, LEAST_CONDUCTANCE, NINTH, Pair, balance};
use super::gutter::Way;
use super::table::Table;

/// The largest diffusion that one step of these tables takes; stronger diffusion takes two.
pub const GREATEST_DIFFUSION: f32 = 0.6;

/// The largest share of its mass that a texel gives away in a step, so that no value becomes negative.
const GREATEST_SHARE: f32 = 0.95;

/// A texel smaller than the mean by more than this factor exchanges less than its neighbours ask for: at
/// [`GREATEST_DIFFUSION`] it would give away more than [`GREATEST_SHARE`] of what it has.
pub const GREATEST_DENSITY: f32 = GREATEST_SHARE / (GREATEST_DIFFUSION * 8.0 / 9.0);

/// The square of the distance of pairs, in taps' distances, beyond which something is wrong with the way.
const FARTHEST_PAIR: f32 = 16.0;

/// Open borders whose directions have a greater cosine are one.
const SAME_BORDER: f32 = 0.99;

/// A gutter texel whose centre is farther than this from its chart, in texels, holds no point of a triangle: half a
/// texel's diagonal, and room for rounding.
const FARTHEST_POINT: f64 = 0.75;

/// Quads of texels in a row of a block: a cache line of them.
pub const BLOCK_QUADS: u32 = 4;

/// Rows of a block, as far apart as the taps of the stencil.
pub const BLOCK_ROWS: u32 = 4;

/// Texels and rows that one thread takes at a time.
const CHUNK: usize = 2048;

/// What one texel beside a seam exchanges.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ExchangeRow {
    /// The owned texel, `y * pitch + x`.
    pub texel: u32,
    /// Where its entries begin.
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
    /// Which of the eight neighbours it exchanges with, bit by bit.
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
    /// One a texel.
    pub rows: Vec<ExchangeRow>,
    /// Of all rows.
    pub entries: Vec<ExchangeEntry>,
}

impl Exchange {
    /// The pairs of a row, besides those in its chart.
    #[must_use]
    pub fn pairs(&self, row: &ExchangeRow) -> &[ExchangeEntry] {
        &self.entries[row.first as usize..][..row.pair_count as usize]
    }

    /// As kernels take it: rows by the number of their entries, so that invocations side by side go through their loops
    /// alike, and the entries in the order of the rows, so that they come from one place in memory.
    #[must_use]
    pub fn by_length(&self) -> Self {
        let mut rows = self.rows.clone();
        rows.par_sort_by_key(|row| (row.pair_count, row.deposit_count(), row.texel));
        let mut entries = Vec::with_capacity(self.entries.len());
        for row in &mut rows {
            let first = entries.len() as u32;
            entries.extend_from_slice(self.pairs(row));
            entries.extend_from_slice(self.deposits(row));
            row.first = first;
        }
        Self { rows, entries }
    }

    /// The gutter texels whose deposits a row takes up, and its part of each.
    #[must_use]
    pub fn deposits(&self, row: &ExchangeRow) -> &[ExchangeEntry] {
        &self.entries[(row.first + row.pair_count) as usize..][..row.deposit_count() as usize]
    }
}

/// What an exchange is made from.
pub(super) struct Layers<'a> {
    pub owner: &'a [u32],
    pub chart: &'a [u32],
    /// Mean texel area by this texel's area; 0 where nobody owns it.
    pub density: &'a [f32],
    /// Per triangle: what a texel that lies wholly in it has, in mean texel areas.
    pub whole: &'a [f32],
    pub seams: &'a [Seam],
    /// How the gutter texels continue their charts, in the order of `seams`.
    pub ways: &'a [Way],
    /// Gutter texels on which particles may deposit, by their place in `seams`.
    pub deposited: &'a [bool],
    pub pitch: u32,
    /// Texels between the stencil's taps.
    pub distance: u32,
}

/// What a texel reads of another across seams, or is read.
#[derive(Clone, Copy, Debug, Default)]
struct Read {
    /// The other.
    texel: u32,
    weight: f32,
    /// The way to it in this texel's chart, times the weight.
    way: Vec2,
    /// The way back in the other's chart, times the weight.
    back: Vec2,
}

impl Layers<'_> {
    pub(super) fn exchange(&self) -> Exchange {
        let offsets = ExchangeRow::neighbours(self.pitch, self.distance);
        let border = self.chosen(|texel| self.mask(texel, &offsets) != 0xff);
        // Per texel: the number of its seam, and later that of its candidate.
        let mut index = vec![NONE; self.owner.len()];
        for (k, seam) in self.seams.iter().enumerate() {
            index[seam.texel as usize] = k as u32;
        }
        let reads = Table::collect(border.len(), Vec::new, |i, sums, items| {
            self.reads_of(border[i], &offsets, &index, sums);
            items.extend_from_slice(sums);
        });
        let given = Table::collect(
            self.seams.len(),
            || (),
            |k, (), items| {
                if self.deposited[k] {
                    items.extend(taps(&self.seams[k]));
                }
            },
        );

        // A texel that may need a row: beside a seam, next to such a texel, or read across a seam.
        let seam_of = index;
        let mut index = vec![NONE; self.owner.len()];
        for texel in border
            .iter()
            .copied()
            .chain(reads.items.iter().map(|read| read.texel))
            .chain(given.items.iter().map(|item| item.0))
        {
            index[texel as usize] = 0;
        }
        for &texel in &border {
            for offset in offsets {
                let other = (i64::from(texel) + offset) as u32;
                if self.in_chart(texel, other) {
                    index[other as usize] = 0;
                }
            }
        }
        let candidates = self.chosen(|texel| index[texel as usize] == 0);
        for (k, &texel) in candidates.iter().enumerate() {
            index[texel as usize] = k as u32;
        }
        let candidate = |texel: u32| index[texel as usize];
        let read_by = reads.transposed(
            candidates.len(),
            |read| candidate(read.texel),
            |i, read| Read {
                texel: border[i],
                weight: read.weight,
                way: read.back,
                back: read.way,
            },
        );
        let deposits = given.transposed(
            candidates.len(),
            |item| candidate(item.0),
            |k, item| (self.seams[k].texel, item.1),
        );
        let mut read_rows = vec![NONE; candidates.len()];
        for (row, &texel) in border.iter().enumerate() {
            read_rows[candidate(texel) as usize] = row as u32;
        }
        let mut pairs = Table::collect(
            candidates.len(),
            || (),
            |k, (), items| {
                let reads = match read_rows[k] {
                    NONE => &[],
                    row => reads.row(row as usize),
                };
                let first = items.len();
                symmetric(reads, read_by.row(k), candidates[k], items);
                let texel = candidates[k];
                let mask = self.mask(texel, &offsets);
                for bit in (0..8).filter(|bit| mask >> bit & 1 == 1) {
                    let other = (i64::from(texel) + offsets[bit]) as u32;
                    let at_border = |k: u32| k != NONE && read_rows[k as usize] != NONE;
                    if !(at_border(k as u32) || at_border(candidate(other))) {
                        continue;
                    }
                    let mut pair = Pair {
                        texel: other,
                        stencil: NINTH,
                        more: 0.0,
                        way: DIRECTIONS[bit],
                    };
                    match items[first..].iter_mut().find(|pair| pair.texel == other) {
                        Some(found) => {
                            pair.more = found.more;
                            *found = pair;
                        }
                        None => items.push(pair),
                    }
                }
                items[first..].sort_by_key(|pair| pair.texel);
            },
        );
        drop((reads, read_by));
        let demands: Vec<Option<Demand>> = candidates
            .par_iter()
            .enumerate()
            .map(|(k, &texel)| self.demand(texel, read_rows[k] != NONE, &offsets, &seam_of))
            .collect();
        balance(&mut pairs, &candidates, candidate, &demands);
        let pairs = Table::collect(
            candidates.len(),
            || (),
            |k, (), items| {
                let changed = pairs.row(k).iter().filter(|pair| pair.more != 0.0);
                items.extend(changed.map(|pair| (pair.texel, pair.more)));
            },
        );

        // The limiter: how much of what it is asked for each texel can give.
        let limits: Vec<f32> = (0..candidates.len())
            .into_par_iter()
            .map(|k| {
                let texel = candidates[k];
                let inside = self.mask(texel, &offsets).count_ones() as f32 * NINTH;
                let asked: f32 = pairs.row(k).iter().fold(inside, |sum, pair| sum + pair.1);
                limit(self.density[texel as usize], asked)
            })
            .collect();
        let limit_of = |texel: u32| match candidate(texel) {
            NONE => limit(self.density[texel as usize], 8.0 * NINTH),
            k => limits[k as usize],
        };
        let neighbour = |texel: u32, bit: usize| (i64::from(texel) + offsets[bit]) as u32;
        let all = self.chosen(|texel| {
            let k = candidate(texel) as usize;
            (candidate(texel) != NONE
                && (read_rows[k] != NONE
                    || !pairs.row(k).is_empty()
                    || !deposits.row(k).is_empty()
                    // The plain kernel limits a texel as if it had eight pairs.
                    || limits[k] != limit(self.density[texel as usize], 8.0 * NINTH)))
                || {
                    let own = limit_of(texel);
                    (0..8).any(|bit| {
                        self.in_chart(texel, neighbour(texel, bit))
                            && limit_of(neighbour(texel, bit)) < own
                    })
                }
        });

        let mut rows: Vec<ExchangeRow> = Vec::with_capacity(all.len());
        let entries = Table::collect(
            all.len(),
            || (),
            |i, (), items: &mut Vec<ExchangeEntry>| {
                let texel = all[i];
                let own = limit_of(texel);
                let mask = self.mask(texel, &offsets);
                for bit in (0..8).filter(|bit| mask >> bit & 1 == 1) {
                    let other = limit_of(neighbour(texel, bit));
                    if other < own {
                        items.push(ExchangeEntry {
                            texel: neighbour(texel, bit),
                            weight: other * NINTH,
                        });
                    }
                }
                if candidate(texel) == NONE {
                    return;
                }
                let k = candidate(texel) as usize;
                for &(other, conductance) in pairs.row(k) {
                    items.push(ExchangeEntry {
                        texel: other,
                        weight: conductance * own.min(limit_of(other)),
                    });
                }
                let parts = deposits.row(k).iter();
                items.extend(parts.map(|&(texel, weight)| ExchangeEntry { texel, weight }));
            },
        );
        all.par_iter()
            .enumerate()
            .map(|(i, &texel)| {
                let own = limit_of(texel);
                let in_chart = self.mask(texel, &offsets);
                let mask = (0..8)
                    .filter(|bit| in_chart >> bit & 1 == 1)
                    .filter(|&bit| limit_of(neighbour(texel, bit)) >= own)
                    .fold(0, |mask, bit| mask | 1 << bit);
                let deposit_count = match candidate(texel) {
                    NONE => 0,
                    k => deposits.row(k as usize).len() as u32,
                };
                let first = entries.starts[i];
                ExchangeRow {
                    texel,
                    first,
                    pair_count: entries.starts[i + 1] - first - deposit_count,
                    counts_and_mask: deposit_count << 8 | mask,
                    conductance: own * NINTH,
                }
            })
            .collect_into_vec(&mut rows);
        Exchange {
            rows,
            entries: entries.items,
        }
    }

    /// The owned texels that fulfil a condition, in ascending order.
    fn chosen(&self, condition: impl Fn(u32) -> bool + Sync) -> Vec<u32> {
        let rows: Vec<Vec<u32>> = self
            .owner
            .par_chunks(CHUNK)
            .enumerate()
            .map(|(chunk, owner)| {
                let first = chunk * CHUNK;
                (0..owner.len())
                    .filter(|&i| owner[i] != NONE && condition((first + i) as u32))
                    .map(|i| (first + i) as u32)
                    .collect()
            })
            .collect();
        rows.concat()
    }

    fn in_chart(&self, texel: u32, other: u32) -> bool {
        let Some(&owner) = self.owner.get(other as usize) else {
            return false;
        };
        let own = self.owner[texel as usize];
        owner == own || (owner != NONE && self.chart[owner as usize] == self.chart[own as usize])
    }

    /// Which of a texel's neighbours are owned by its chart.
    fn mask(&self, texel: u32, offsets: &[i64; 8]) -> u32 {
        (0..8).fold(0, |mask, bit| {
            // Before the first texel and behind the last there is nobody; a chart's gutter keeps it off the sides.
            let other = (i64::from(texel) + offsets[bit]) as u32;
            mask | u32::from(self.in_chart(texel, other)) << bit
        })
    }

    /// What a texel's moments should be; nothing where open borders meet, or charts without a direction.
    fn demand(
        &self,
        texel: u32,
        at_border: bool,
        offsets: &[i64; 8],
        seam_of: &[u32],
    ) -> Option<Demand> {
        let mask = self.mask(texel, offsets);
        let area = if at_border {
            let whole = self.whole[self.owner[texel as usize] as usize];
            1.0 / (self.density[texel as usize] * whole)
        } else {
            1.0
        };
        let mut along: Option<Vec2> = None;
        for bit in (0..8).filter(|bit| mask >> bit & 1 == 0) {
            let other = (i64::from(texel) + offsets[bit]) as u32;
            let way = &self.ways[gutter_at(seam_of, other)?];
            if way.border != Vec2::ZERO {
                if along.is_some_and(|along| along.dot(way.border).abs() < SAME_BORDER) {
                    return None;
                }
                along = Some(way.border);
            }
        }
        let stencil = (0..8).filter(|bit| mask >> bit & 1 == 1);
        let stencil = stencil.map(|bit| DIRECTIONS[bit]);
        Some(Demand::new(area, stencil, along))
    }

    /// What a texel would read across seams in one step: `(j, X_ij)`, in ascending order.
    fn reads_of(&self, texel: u32, offsets: &[i64; 8], seam_of: &[u32], sums: &mut Vec<Read>) {
        sums.clear();
        for (bit, offset) in offsets.iter().enumerate() {
            let other = (i64::from(texel) + offset) as u32;
            let Some(seam) = gutter_at(seam_of, other).filter(|_| !self.in_chart(texel, other))
            else {
                continue;
            };
            for (source, weight) in taps(&self.seams[seam]) {
                if source != texel {
                    let (way, back) = self.way_to(source, texel, bit, seam, seam_of);
                    let weight = weight * NINTH;
                    sums.push(Read {
                        texel: source,
                        weight,
                        way: weight * way,
                        back: weight * back,
                    });
                }
            }
        }
        // Stable, so that a pair's parts are added in the order of the neighbours.
        sums.sort_by_key(|read| read.texel);
        sums.dedup_by(|next, kept| {
            let same = next.texel == kept.texel;
            if same {
                kept.weight += next.weight;
                kept.way += next.way;
                kept.back += next.back;
            }
            same
        });
    }

    /// The way from a texel to one that its gutter texel in a direction is filled from, and the way back there, in taps'
    /// distances; NaN where it cannot be told.
    fn way_to(
        &self,
        source: u32,
        texel: u32,
        bit: usize,
        seam: usize,
        seam_of: &[u32],
    ) -> (Vec2, Vec2) {
        let taps = self.distance as f32;
        let centre =
            |texel: u32| Vec2::new((texel % self.pitch) as f32, (texel / self.pitch) as f32) + 0.5;
        let chart_of = |texel: u32| self.chart[self.owner[texel as usize] as usize];
        let chart = chart_of(source);
        let mut found = (Vec2::NAN, Vec2::NAN);
        let mut nearest = FARTHEST_PAIR;
        let mut consider = |way: Vec2, back: Mat2| {
            if way.length_squared() < nearest {
                nearest = way.length_squared();
                found = (way, -(back.inverse() * way));
            }
        };
        if chart == chart_of(texel) {
            consider((centre(source) - centre(texel)) / taps, Mat2::IDENTITY);
        }
        let way = &self.ways[seam];
        if way.chart == chart {
            let behind = way.back * (centre(source) - way.position) / taps;
            consider(DIRECTIONS[bit] + behind, way.back);
        } else if way.chart != NONE {
            let corner = (way.position - 0.5).floor();
            for (x, y) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                let next = (corner.y as u32 + y) * self.pitch + corner.x as u32 + x;
                let Some(on) = gutter_at(seam_of, next).map(|seam| &self.ways[seam]) else {
                    continue;
                };
                if on.chart == chart {
                    let behind =
                        centre(next) - way.position + on.back * (centre(source) - on.position);
                    consider(
                        DIRECTIONS[bit] + way.back * behind / taps,
                        way.back * on.back,
                    );
                }
            }
        }
        found
    }
}

/// Columns and rows of the neighbours of the mask's bits, from the lowest.
const DIRECTIONS: [Vec2; 8] = [
    Vec2::new(-1.0, -1.0),
    Vec2::new(0.0, -1.0),
    Vec2::new(1.0, -1.0),
    Vec2::new(-1.0, 0.0),
    Vec2::new(1.0, 0.0),
    Vec2::new(-1.0, 1.0),
    Vec2::new(0.0, 1.0),
    Vec2::new(1.0, 1.0),
];

/// The place of a gutter texel in the list of them.
fn gutter_at(seam_of: &[u32], texel: u32) -> Option<usize> {
    let seam = seam_of.get(texel as usize).copied();
    seam.filter(|&seam| seam != NONE).map(|seam| seam as usize)
}

fn taps(seam: &Seam) -> impl Iterator<Item = (u32, f32)> {
    let weights = seam.weights();
    (0..4)
        .map(move |k| (seam.source[k], weights[k]))
        .filter(|tap| tap.1 > 0.0)
}

/// The part of its conductances that a texel keeps.
fn limit(density: f32, asked: f32) -> f32 {
    (GREATEST_SHARE / (GREATEST_DIFFUSION * (density * asked))).min(1.0)
}

/// `(X + X^T) / 2` for one texel, from its row of `X` and its row of the transpose, both in ascending order.
fn symmetric(reads: &[Read], read_by: &[Read], texel: u32, pairs: &mut Vec<Pair>) {
    let (mut reads, mut read_by) = (reads.iter().peekable(), read_by.iter().peekable());
    loop {
        let next = |item: Option<&&Read>| item.map_or(NONE, |item| item.texel);
        let other = next(reads.peek()).min(next(read_by.peek()));
        if other == NONE {
            return;
        }
        let part =
            |item: Option<&Read>| item.map_or((0.0, Vec2::ZERO), |read| (read.weight, read.way));
        let there = part(reads.next_if(|item| item.texel == other));
        let back = part(read_by.next_if(|item| item.texel == other));
        let weight = there.0 + back.0;
        let conductance = 0.5 * weight;
        if conductance >= LEAST_CONDUCTANCE && other != texel {
            pairs.push(Pair {
                texel: other,
                stencil: 0.0,
                more: conductance,
                way: (there.1 + back.1) / weight,
            });
        }
    }
}

/// Gutter texels on which particles may deposit: those in which a point of a triangle may lie.
pub(super) fn deposited(maps: &[AtlasMap], pitch: u32, gutter_texels: &[GutterTexel]) -> Vec<bool> {
    gutter_texels
        .par_iter()
        .map(|&GutterTexel { texel, triangle }| {
            let centre = Vec2::new((texel % pitch) as f32, (texel / pitch) as f32) + 0.5;
            distance_to(&maps[triangle as usize], centre.as_dvec2()) <= FARTHEST_POINT
        })
        .collect()
}

/// From a place in the texture to a triangle, in texels.
fn distance_to(map: &AtlasMap, place: DVec2) -> f64 {
    let a = map.origin.as_dvec2();
    let corners = [a, a + map.du.as_dvec2(), a + map.dv.as_dvec2()];
    let mut inside = true;
    let mut nearest = f64::INFINITY;
    for k in 0..3 {
        let (start, end) = (corners[k], corners[(k + 1) % 3]);
        let edge = end - start;
        let offset = place - start;
        inside &= edge.perp_dot(offset) >= 0.0;
        let along =
            (offset.dot(edge) / edge.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        nearest = nearest.min((offset - along * edge).length());
    }
    if inside { 0.0 } else { nearest }
}

/// The blocks with anything in them to work on, by their first quads, in ascending order: [`BLOCK_ROWS`] rows of
/// [`BLOCK_QUADS`] quads, `reach` quads apart. They cover the texture; where `reach` is no multiple of a row of quads,
/// some share quads, which come out alike.
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
