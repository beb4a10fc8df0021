//! Conductances beside seams for which linear fields are steady and all other fields spread as fast as elsewhere.
//!
//! With `d_ij` the way from texel `i` to texel `j`, unfolded into the chart of `i`, a finite-volume scheme keeps linear fields, and with
//! them the centre of mass of a spreading field, if `sum_j S_ij d_ij = 0`; and a field spreads at the right rate in every direction if
//! `sum_j S_ij d_ij d_ij^T = 2/3 a_i 1`, with `a_i` the texel's area in whole texels of its chart. (The moment conditions of Taylor's
//! expansion, as for any finite-difference stencil: Fornberg, "Generation of finite difference formulas on arbitrarily spaced grids",
//! 1988.) The stencil fulfils both inside a chart. Symmetric conductances cannot fulfil both everywhere; these approximate them by least
//! squares, with the smallest change.

use glam::Vec2;
use rayon::prelude::*;

use super::table::Table;

/// Conductance of two neighbours in a chart, in mean texel areas.
pub(super) const NINTH: f32 = 1.0 / 9.0;

/// Pairs across a seam with less are left out: they cost as much as others and carry little, and leaving a pair out never changes the sum.
pub(super) const LEAST_CONDUCTANCE: f32 = 0.1 / 9.0;

/// Smaller changes to pairs in a chart are left out, for they would need an entry.
const LEAST_CHANGE: f32 = 0.05 / 9.0;

/// A pair in a chart keeps at least this part of its conductance by the stencil.
const LEAST_KEPT: f32 = 0.1;

/// Weight of second moments beside first ones.
const SECOND: f32 = 0.5;

/// Weight of the changes, by their scale, beside the moments.
const CHANGE: f32 = 0.01;

/// Added to a conductance to give the scale of its change, so that weak pairs can become stronger, too.
const SCALE: f32 = 0.005;

/// After the first round weak pairs are removed; the second compensates for them.
const ROUNDS: usize = 2;

/// Steps of conjugate gradients in a round. Errors, and the changes that correct them, extend over a few texels only.
const STEPS: usize = 6;

/// Entries that one thread takes at a time; sums are made in this order.
const CHUNK: usize = 4096;

/// Two moments of first order and three of second, weighted.
type Moments = [f32; 5];

/// One side of a pair whose conductance may change.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    /// The texel on the other side.
    pub texel: u32,
    /// Conductance by the stencil; 0 across a seam.
    pub stencil: f32,
    /// Conductance added to that, in mean texel areas.
    pub more: f32,
    /// From this side's texel to the other, in this side's chart, in taps' distances; NaN where it is unknown.
    pub way: Vec2,
}

impl Pair {
    /// The allowed conductance nearest to `more`; with `weak_out` weak pairs get none.
    fn allowed(&self, more: f32, weak_out: bool) -> f32 {
        if self.stencil > 0.0 {
            let out = weak_out && more.abs() < LEAST_CHANGE;
            if out {
                0.0
            } else {
                more.max((LEAST_KEPT - 1.0) * self.stencil)
            }
        } else if more < if weak_out { LEAST_CONDUCTANCE } else { 0.0 } {
            0.0
        } else {
            more
        }
    }
}

/// The moments that a texel's pairs should have.
#[derive(Clone, Copy, Debug)]
pub(super) struct Demand {
    /// Without the stencil's part.
    moments: Moments,
    /// At an open border, which reflects mass, only moments along it count.
    along: Option<Vec2>,
}

impl Demand {
    /// For a texel of so many whole texels, with the stencil's pairs in these directions.
    pub(super) fn new(area: f32, stencil: impl Iterator<Item = Vec2>, along: Option<Vec2>) -> Self {
        let second = SECOND * area * 2.0 / 3.0;
        let across = if along.is_some() { 0.0 } else { second };
        let mut moments = [0.0, 0.0, second, across, 0.0];
        for way in stencil {
            add(&mut moments, -NINTH, &moments_of(way, along));
        }
        Self { moments, along }
    }
}

fn moments_of(way: Vec2, along: Option<Vec2>) -> Moments {
    let second = SECOND * way;
    match along {
        None => [
            way.x,
            way.y,
            second.x * way.x,
            second.y * way.y,
            // Counts for both off-diagonal entries of the matrix.
            std::f32::consts::SQRT_2 * second.x * way.y,
        ],
        Some(along) => {
            let part = way.dot(along);
            [part, 0.0, SECOND * part * part, 0.0, 0.0]
        }
    }
}

fn add(sum: &mut Moments, factor: f32, moments: &Moments) {
    for (sum, moment) in sum.iter_mut().zip(moments) {
        *sum += factor * moment;
    }
}

fn dot(a: &Moments, b: &Moments) -> f32 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Changes conductances by as little as possible to approximate the demands of the texels; `None` demands nothing. Row `i` of the pairs is
/// that of `texels[i]`, and `row_of` is the inverse of that.
///
/// Both sides of a pair get the same conductance to the last bit, because both compute it from the same two numbers.
pub(super) fn balance(
    pairs: &mut Table<Pair>,
    texels: &[u32],
    row_of: impl Fn(u32) -> u32 + Sync,
    demands: &[Option<Demand>],
) {
    let mut system = System::new(pairs, texels, row_of, demands);
    for round in 0..ROUNDS {
        system.solve();
        let weak_out = round + 1 < ROUNDS;
        let parts = system.change.par_iter_mut().zip(&mut system.free);
        let pairs = pairs.items.par_iter().zip(&system.scale);
        parts
            .zip(pairs)
            .for_each(|((change, free), (pair, scale))| {
                let more = pair.more + *change * scale;
                let allowed = pair.allowed(more, weak_out);
                if allowed.to_bits() != more.to_bits() {
                    *change = (allowed - pair.more) / scale;
                    *free = false;
                }
            });
    }
    let changes = system.change.par_iter().zip(&system.scale);
    pairs
        .items
        .par_iter_mut()
        .zip(changes)
        .for_each(|(pair, (change, scale))| {
            let more = pair.allowed(pair.more + change * scale, false);
            // Values that were set to 0 return with rounding errors.
            pair.more = if more.abs() < 1e-6 { 0.0 } else { more };
        });
}

/// Least squares for the changes of conductances, each divided by a scale of its own: the square root of the pair's conductance, so that
/// strong pairs change more than weak ones.
struct System {
    /// Index of each texel's first pair.
    starts: Vec<u32>,
    /// Per side of a pair: its texel's row, and its other side.
    row: Vec<u32>,
    other: Vec<u32>,
    scale: Vec<f32>,
    /// The moments that a change by its scale adds to its texel.
    moments: Vec<Moments>,
    /// Per texel: the demanded moments minus those without any change.
    missing: Vec<Moments>,
    /// Whether a side's pair may change.
    free: Vec<bool>,
    change: Vec<f32>,
}

impl System {
    fn new(
        pairs: &Table<Pair>,
        texels: &[u32],
        row_of: impl Fn(u32) -> u32 + Sync,
        demands: &[Option<Demand>],
    ) -> Self {
        let row: Vec<u32> = (0..texels.len())
            .flat_map(|i| pairs.row(i).iter().map(move |_| i as u32))
            .collect();
        let items = &pairs.items;
        let other: Vec<u32> = items
            .par_iter()
            .zip(&row)
            .map(|(pair, &i)| {
                let there = row_of(pair.texel) as usize;
                let found = pairs
                    .row(there)
                    .binary_search_by_key(&texels[i as usize], |pair| pair.texel);
                pairs.starts[there] + found.expect("both sides have a pair") as u32
            })
            .collect();
        let demands: Vec<Option<Demand>> = (0..texels.len())
            .into_par_iter()
            .map(|i| demands[i].filter(|_| pairs.row(i).iter().all(|pair| pair.way.is_finite())))
            .collect();
        let demand = |side: usize| demands[row[side] as usize];
        let scale: Vec<f32> = items
            .par_iter()
            .map(|pair| ((pair.stencil + pair.more).max(0.0) + SCALE).sqrt())
            .collect();
        let moments = (0..items.len())
            .into_par_iter()
            .map(|side| match demand(side) {
                None => Moments::default(),
                Some(demand) => moments_of(items[side].way, demand.along).map(|m| m * scale[side]),
            })
            .collect();
        let free = (0..items.len())
            .into_par_iter()
            .map(|side| demand(side).is_some() || demand(other[side] as usize).is_some())
            .collect();
        let missing = (0..texels.len())
            .into_par_iter()
            .map(|i| {
                let mut missing = Moments::default();
                if let Some(demand) = demands[i] {
                    missing = demand.moments;
                    for pair in pairs.row(i) {
                        add(
                            &mut missing,
                            -pair.more,
                            &moments_of(pair.way, demand.along),
                        );
                    }
                }
                missing
            })
            .collect();
        Self {
            starts: pairs.starts.clone(),
            change: vec![0.0; items.len()],
            row,
            other,
            scale,
            moments,
            missing,
            free,
        }
    }

    /// Conjugate gradients on the normal equations, from the changes so far (Hestenes and Stiefel, 1952).
    fn solve(&mut self) {
        let mut missing = self.missing.clone();
        for (missing, now) in missing.iter_mut().zip(self.moments_by(&self.change)) {
            add(missing, -1.0, &now);
        }
        let mut slope = self.slope(&missing);
        let mut direction = slope.clone();
        let mut steepness = squares(&slope);
        for _ in 0..STEPS {
            let gained = self.moments_by(&direction);
            let bend = sum_of(&gained, |gained| dot(gained, gained));
            let bend = bend + f64::from(CHANGE) * squares(&direction);
            if bend <= 0.0 {
                return;
            }
            let length = (steepness / bend) as f32;
            let parts = self.change.par_iter_mut().zip(&direction);
            parts.for_each(|(change, direction)| *change += length * direction);
            let parts = missing.par_iter_mut().zip(&gained);
            parts.for_each(|(missing, gained)| add(missing, -length, gained));
            slope = self.slope(&missing);
            let before = std::mem::replace(&mut steepness, squares(&slope));
            let kept = (steepness / before) as f32;
            let parts = direction.par_iter_mut().zip(&slope);
            parts.for_each(|(direction, slope)| *direction = slope + kept * *direction);
        }
    }

    /// The moments that changes add to each texel.
    fn moments_by(&self, change: &[f32]) -> Vec<Moments> {
        self.starts
            .par_windows(2)
            .map(|range| {
                let mut sum = Moments::default();
                let sides = range[0] as usize..range[1] as usize;
                for (change, moments) in change[sides.clone()].iter().zip(&self.moments[sides]) {
                    add(&mut sum, *change, moments);
                }
                sum
            })
            .collect()
    }

    /// The direction of descent for each pair, equal for both sides.
    fn slope(&self, missing: &[Moments]) -> Vec<f32> {
        let part = |side: usize| dot(&self.moments[side], &missing[self.row[side] as usize]);
        (0..self.change.len())
            .into_par_iter()
            .map(|side| {
                if self.free[side] {
                    let both = part(side) + part(self.other[side] as usize);
                    both - CHANGE * self.change[side]
                } else {
                    0.0
                }
            })
            .collect()
    }
}

/// The sum of squares; each pair counts once, although both its sides are listed.
fn squares(of_sides: &[f32]) -> f64 {
    0.5 * sum_of(of_sides, |x| x * x)
}

/// Summed chunk by chunk, in an order that does not depend on the threads.
fn sum_of<T: Sync>(items: &[T], of: impl Fn(&T) -> f32 + Sync) -> f64 {
    let parts: Vec<f64> = items
        .par_chunks(CHUNK)
        .map(|chunk| chunk.iter().map(|item| f64::from(of(item))).sum())
        .collect();
    parts.iter().sum()
}
