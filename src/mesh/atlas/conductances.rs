//! Conductances beside seams.
//!
//! A gutter texel stands for the owned texels `j` that it is filled from: a texel `i` with gutter texels `k` among its
//! neighbours would read `X_ij = sum_k w_kj / 9`, and `S = (X + X^T) / 2` is the symmetric exchange nearest to that. As
//! such it would push mass to one side of the seam: [`balance`] then changes these conductances, and those in charts
//! beside them, until linear fields are nearly steady.

use glam::{Mat2, Vec2};
use rayon::prelude::*;

use super::super::surface::{NONE, Seam};
use super::balance::{Demand, LEAST_CONDUCTANCE, NINTH, Pair, balance};
use super::gutter::Way;
use super::table::Table;
use super::{AtlasError, Control};

/// The square of the distance of pairs, in taps' distances, beyond which the way counts as unknown.
const FARTHEST_PAIR: f32 = 16.0;

/// Open borders whose directions have a greater cosine are one.
const SAME_BORDER: f32 = 0.99;

/// Texels that one thread takes at a time.
const CHUNK: usize = 2048;

/// Inputs of an exchange.
pub(super) struct Layers<'a> {
    pub owner: &'a [u32],
    pub chart: &'a [u32],
    /// Mean texel area by this texel's area; 0 where it has no owner.
    pub density: &'a [f32],
    /// Per triangle: the surface area of a texel that lies wholly in it, in mean texel areas.
    pub whole: &'a [f32],
    pub seams: &'a [Seam],
    /// How the gutter texels continue their charts, in the order of `seams`.
    pub ways: &'a [Way],
    /// Gutter texels on which particles may deposit, by their place in `seams`.
    pub deposited: &'a [bool],
    /// Across seams texels lie as inside a chart, so that the conductances that they read are right as they are.
    pub is_plain: bool,
    pub pitch: u32,
    /// Texels between the stencil's taps.
    pub distance: u32,
    /// Offsets of the stencil's taps.
    pub offsets: [i64; 8],
}

/// A read of one texel by another across seams.
#[derive(Clone, Copy, Debug, Default)]
struct Read {
    /// The texel that is read.
    texel: u32,
    weight: f32,
    /// The way to it in this texel's chart, times the weight.
    way: Vec2,
    /// The way back in the other's chart, times the weight.
    back: Vec2,
}

/// Exchanges of texels near seams in addition to the stencil's ninths.
pub(super) struct Conductances {
    /// The texels that may exchange anything, in ascending order.
    pub texels: Vec<u32>,
    /// Their places in the list, or [`NONE`], by texel; of gutter texels the places in the list of seams.
    pub index: Vec<u32>,
    /// Does a texel lack one of the eight neighbours in its chart?
    pub at_border: Vec<bool>,
    /// The texel on the other side and the conductance, in mean texel areas.
    pub pairs: Table<(u32, f32)>,
    /// Gutter texels whose deposits they take a part of, and the part.
    pub deposits: Table<(u32, f32)>,
}

impl Layers<'_> {
    /// # Errors
    /// [`AtlasError::Cancelled`].
    pub(super) fn conductances(&self, control: &Control<'_>) -> Result<Conductances, AtlasError> {
        let border = self.chosen(|texel| self.mask(texel) != 0xff);
        // One array for the places of gutter texels in one list and of owned texels in another, because it is as large as the texture.
        let mut index = vec![NONE; self.owner.len()];
        for (k, seam) in self.seams.iter().enumerate() {
            index[seam.texel as usize] = k as u32;
        }
        let reads = Table::collect(border.len(), Vec::new, |i, sums, items| {
            self.reads_of(border[i], &index, sums);
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
        let read = reads.items.iter().map(|read| read.texel);
        let given_to = given.items.iter().map(|item| item.0);
        let texels = self.near_seams(&border, read.chain(given_to), &mut index);
        let deposits = given.transposed(
            texels.len(),
            |item| index[item.0 as usize],
            |k, item| (self.seams[k].texel, item.1),
        );
        let mut at_border = vec![false; texels.len()];
        for &texel in &border {
            at_border[index[texel as usize] as usize] = true;
        }
        control.check()?;
        let mut pairs = self.pairs(&border, &reads, &texels, &index);
        let demands: Vec<Option<Demand>> = texels
            .par_iter()
            .zip(&at_border)
            .map(|(&texel, &at_border)| self.demand(texel, at_border, &index))
            .collect();
        control.check()?;
        balance(&mut pairs, &texels, |texel| index[texel as usize], &demands);
        let pairs = Table::collect(
            texels.len(),
            || (),
            |k, (), items| {
                let changed = pairs.row(k).iter().filter(|pair| pair.more != 0.0);
                items.extend(changed.map(|pair| (pair.texel, pair.more)));
            },
        );
        Ok(Conductances {
            texels,
            index,
            at_border,
            pairs,
            deposits,
        })
    }

    /// Texels at borders, next to those, and others that exchange with them. Writes their places in that list into the index.
    fn near_seams(
        &self,
        border: &[u32],
        others: impl Iterator<Item = u32>,
        index: &mut [u32],
    ) -> Vec<u32> {
        for texel in border.iter().copied().chain(others) {
            index[texel as usize] = 0;
        }
        for &texel in border {
            for bit in self.neighbours_in_chart(texel) {
                index[self.neighbour(texel, bit) as usize] = 0;
            }
        }
        let texels = self.chosen(|texel| index[texel as usize] == 0);
        for (k, &texel) in texels.iter().enumerate() {
            index[texel as usize] = k as u32;
        }
        texels
    }

    /// The pairs of texels near seams that may be changed, by texel: all across seams, and in charts those with one at
    /// the border.
    fn pairs(
        &self,
        border: &[u32],
        reads: &Table<Read>,
        texels: &[u32],
        index: &[u32],
    ) -> Table<Pair> {
        let read_by = reads.transposed(
            texels.len(),
            |read| index[read.texel as usize],
            |i, read| Read {
                texel: border[i],
                weight: read.weight,
                way: read.back,
                back: read.way,
            },
        );
        let mut row_of = vec![NONE; texels.len()];
        for (row, &texel) in border.iter().enumerate() {
            row_of[index[texel as usize] as usize] = row as u32;
        }
        let at_border = |k: u32| k != NONE && row_of[k as usize] != NONE;
        Table::collect(
            texels.len(),
            || (),
            |k, (), items| {
                let texel = texels[k];
                let reads = match row_of[k] {
                    NONE => &[],
                    row => reads.row(row as usize),
                };
                let first = items.len();
                symmetric(reads, read_by.row(k), texel, items);
                for bit in self.neighbours_in_chart(texel) {
                    let other = self.neighbour(texel, bit);
                    if !(at_border(k as u32) || at_border(index[other as usize])) {
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
        )
    }

    /// The owned texels that fulfil a condition, in ascending order.
    pub(super) fn chosen(&self, condition: impl Fn(u32) -> bool + Sync) -> Vec<u32> {
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

    pub(super) fn in_chart(&self, texel: u32, other: u32) -> bool {
        let Some(&owner) = self.owner.get(other as usize) else {
            return false;
        };
        let own = self.owner[texel as usize];
        owner == own || (owner != NONE && self.chart[owner as usize] == self.chart[own as usize])
    }

    /// Mask of the neighbours that the texel's chart owns.
    pub(super) fn mask(&self, texel: u32) -> u32 {
        (0..8).fold(0, |mask, bit| {
            mask | u32::from(self.in_chart(texel, self.neighbour(texel, bit))) << bit
        })
    }

    /// The bits of a texel's neighbours that are owned by its chart.
    pub(super) fn neighbours_in_chart(&self, texel: u32) -> impl Iterator<Item = usize> + use<> {
        let mask = self.mask(texel);
        (0..8).filter(move |bit| mask >> bit & 1 == 1)
    }

    /// No owned texel has a neighbour outside of the texture, because a chart's gutter keeps it off the sides.
    pub(super) fn neighbour(&self, texel: u32, bit: usize) -> u32 {
        (i64::from(texel) + self.offsets[bit]) as u32
    }

    /// The place of a gutter texel in the list of them.
    fn gutter_at(&self, index: &[u32], texel: u32) -> Option<usize> {
        let is_gutter = self.owner.get(texel as usize) == Some(&NONE);
        let seam = index.get(texel as usize).filter(|_| is_gutter)?;
        (*seam != NONE).then_some(*seam as usize)
    }

    /// The moments that a texel should have; `None` where open borders meet, or charts without a direction, and where nothing is to change.
    fn demand(&self, texel: u32, at_border: bool, index: &[u32]) -> Option<Demand> {
        if self.is_plain {
            return None;
        }
        let mask = self.mask(texel);
        let area = if at_border {
            let whole = self.whole[self.owner[texel as usize] as usize];
            1.0 / (self.density[texel as usize] * whole)
        } else {
            1.0
        };
        let mut along: Option<Vec2> = None;
        for bit in (0..8).filter(|bit| mask >> bit & 1 == 0) {
            let other = self.neighbour(texel, bit);
            let way = &self.ways[self.gutter_at(index, other)?];
            if way.border != Vec2::ZERO {
                if along.is_some_and(|along| along.dot(way.border).abs() < SAME_BORDER) {
                    return None;
                }
                along = Some(way.border);
            }
        }
        let stencil = self.neighbours_in_chart(texel).map(|bit| DIRECTIONS[bit]);
        Some(Demand::new(area, stencil, along))
    }

    /// The reads of a texel across seams in one step: `(j, X_ij)`, in ascending order.
    fn reads_of(&self, texel: u32, index: &[u32], sums: &mut Vec<Read>) {
        sums.clear();
        for bit in 0..8 {
            let other = self.neighbour(texel, bit);
            let Some(seam) = self
                .gutter_at(index, other)
                .filter(|_| !self.in_chart(texel, other))
            else {
                continue;
            };
            for (source, weight) in taps(&self.seams[seam]) {
                if source != texel {
                    let (way, back) = self.way_to(source, texel, bit, seam, index);
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
    /// distances; NaN where it is unknown.
    fn way_to(
        &self,
        source: u32,
        texel: u32,
        bit: usize,
        seam: usize,
        index: &[u32],
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
                let Some(on) = self.gutter_at(index, next).map(|seam| &self.ways[seam]) else {
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

fn taps(seam: &Seam) -> impl Iterator<Item = (u32, f32)> {
    let weights = seam.weights();
    (0..4)
        .map(move |k| (seam.source[k], weights[k]))
        .filter(|tap| tap.1 > 0.0)
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
