//! Straightening the borders between charts: triangles are reassigned, and changes after which a chart no longer flattens well are
//! reverted.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use rayon::prelude::*;

use super::AtlasError;
use super::cluster::{Graph, Reached};
use super::merge::Merger;
use super::piece::{Bounds, Piece, Quality, Spending};
use crate::mesh::surface::NONE;

/// How charts are reshaped.
#[derive(Clone, Copy, Debug)]
pub(super) struct Smoothing {
    /// Charts are shrunk by these shares of their inner radius, one after another, and grown again, which removes thin parts.
    pub openings: &'static [f64],
    /// Rounds of blurring the labels (the scheme of Merriman, Bence and Osher, 1992), which rounds corners off.
    pub blur: usize,
}

impl Merger<'_> {
    /// Reassigns triangles so that borders get shorter; every chart stays within bounds.
    pub fn smooth(
        &mut self,
        graph: &Graph,
        smoothing: &Smoothing,
        bounds: &Bounds,
    ) -> Result<(), AtlasError> {
        self.compact();
        let mut labels = self.labels.clone();
        for &opening in smoothing.openings {
            labels = opened(graph, &labels, self.pieces.len(), opening);
            self.control.check()?;
        }
        labels = self.blurred(&labels, smoothing.blur);
        self.relabel(labels, bounds)
    }

    /// Numbers pieces without gaps.
    pub fn compact(&mut self) {
        self.pieces.retain(Option::is_some);
        for (label, piece) in self.pieces.iter().flatten().enumerate() {
            for &t in &piece.triangles {
                self.labels[t as usize] = label as u32;
            }
        }
        self.forget();
    }

    /// Applies new labels to pieces that are then within bounds, or no worse than before.
    fn relabel(&mut self, mut labels: Vec<u32>, bounds: &Bounds) -> Result<(), AtlasError> {
        let mut made: Vec<Option<Piece>> = vec![None; self.pieces.len()];
        let mut stale = vec![true; self.pieces.len()];
        loop {
            let mut changed = vec![false; self.pieces.len()];
            let mut sets = vec![Vec::new(); self.pieces.len()];
            for (t, (&new, &old)) in labels.iter().zip(&self.labels).enumerate() {
                if new != old {
                    changed[new as usize] = true;
                    changed[old as usize] = true;
                }
                if stale[new as usize] {
                    sets[new as usize].push(t as u32);
                }
            }
            let results: Vec<_> = (0..self.pieces.len())
                .into_par_iter()
                .with_max_len(1)
                .map(|i| {
                    self.control.check()?;
                    let old = self.pieces[i].as_ref();
                    let (true, true, Some(old)) = (stale[i], changed[i], old) else {
                        return Ok(None);
                    };
                    if sets[i].is_empty() {
                        return Ok(Some(None));
                    }
                    let bounds = old.quality.or(bounds);
                    let piece = self.pool.with(|places| {
                        Piece::new(self.surface, self.metric, &sets[i], &bounds, places)
                    });
                    Ok(Some(piece.ok()))
                })
                .collect::<Result<_, AtlasError>>()?;
            let mut failed = vec![false; self.pieces.len()];
            for (i, result) in results.into_iter().enumerate() {
                if let Some(piece) = result {
                    failed[i] = piece.is_none();
                    made[i] = piece;
                }
                if !changed[i] {
                    made[i] = None;
                }
            }
            stale.fill(false);
            if !failed.contains(&true) {
                break;
            }
            for (new, &old) in labels.iter_mut().zip(&self.labels) {
                if *new != old && (failed[*new as usize] || failed[old as usize]) {
                    stale[*new as usize] = true;
                    stale[old as usize] = true;
                    *new = old;
                }
            }
        }
        let perimeter = |of: &Piece| of.perimeter;
        let (before, after) = made
            .iter()
            .zip(&self.pieces)
            .filter_map(|(new, old)| Some((perimeter(old.as_ref()?), perimeter(new.as_ref()?))))
            .fold((0.0, 0.0), |sum, pair| (sum.0 + pair.0, sum.1 + pair.1));
        let mut spent = Spending::default();
        for (new, old) in made.iter().zip(&self.pieces) {
            let piece = new.as_ref().or(old.as_ref());
            spent = spent.plus(&piece.map_or(Spending::default(), Piece::spending));
        }
        if after >= before || !spent.within(&self.spent(), self.area) {
            return Ok(());
        }
        for (piece, new) in self.pieces.iter_mut().zip(made) {
            if new.is_some() {
                *piece = new;
            }
        }
        self.labels = labels;
        Ok(())
    }

    /// Labels after some rounds of blurring the indicator of each label over the triangles; the strongest label wins.
    fn blurred(&self, labels: &[u32], rounds: usize) -> Vec<u32> {
        /// The strongest labels of a triangle, and their shares.
        type Mix = [(u32, f32); 4];
        let pure = |&label: &u32| -> Mix {
            let mut mix = [(NONE, 0.0); 4];
            mix[0] = (label, 1.0);
            mix
        };
        let mut mixes: Vec<Mix> = labels.iter().map(pure).collect();
        for _ in 0..rounds {
            let blur = |t: usize| -> Mix {
                let lengths = self.metric.shapes[t].lengths;
                let whole: f64 = lengths.iter().sum();
                let own = &mixes[t];
                let twins = [0, 1, 2].map(|k| self.surface.halfedges[3 * t + k].twin);
                if own[0].1 == 1.0
                    && twins
                        .iter()
                        .all(|&twin| twin == NONE || mixes[twin as usize / 3][0] == own[0])
                {
                    return *own;
                }
                let mut sums = [(NONE, 0.0_f32); 16];
                let mut add = |mix: &Mix, weight: f32| {
                    for &(label, share) in mix.iter().take_while(|(label, _)| *label != NONE) {
                        let place = sums.iter_mut().find(|(l, _)| *l == label || *l == NONE);
                        if let Some(place) = place {
                            *place = (label, place.1 + weight * share);
                        }
                    }
                };
                add(own, 0.5);
                for (length, twin) in lengths.into_iter().zip(twins) {
                    let from = if twin == NONE {
                        own
                    } else {
                        &mixes[twin as usize / 3]
                    };
                    add(from, (0.5 * length / whole) as f32);
                }
                sums.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
                [sums[0], sums[1], sums[2], sums[3]]
            };
            mixes = (0..labels.len()).into_par_iter().map(blur).collect();
        }
        mixes.iter().map(|mix| mix[0].0).collect()
    }
}

impl Quality {
    /// The given bounds, widened so that this quality is within them.
    fn or(&self, bounds: &Bounds) -> Bounds {
        Bounds {
            share: bounds
                .share
                .max(self.small)
                .max(self.large)
                .max(self.skewed),
            wild: bounds.wild.max(self.wild),
            hull: bounds.hull.max(self.hull),
            roundness: bounds.roundness.max(self.roundness),
            part: bounds.part.max(self.part),
        }
    }
}

/// Labels after each chart has been shrunk to its core and all cores have grown again; each triangle gets the label that reaches it first.
fn opened(graph: &Graph, labels: &[u32], count: usize, opening: f64) -> Vec<u32> {
    let n = labels.len();
    let beside = |i: usize| {
        let other = |&(to, _): &(u32, f64)| to != NONE && labels[to as usize] != labels[i];
        graph.neighbours[i].iter().any(other)
    };
    let mut distances = vec![f64::INFINITY; n];
    let mut own = labels.to_vec();
    let starts = (0..n).filter(|&i| beside(i)).map(|i| (i as u32, 0.0));
    grow(graph, starts, &mut distances, &mut own, true);
    let mut radius = vec![0.0_f64; count];
    for (&distance, &label) in distances.iter().zip(labels) {
        if distance.is_finite() {
            radius[label as usize] = radius[label as usize].max(distance);
        }
    }
    let core = |i: &usize| distances[*i] >= opening * radius[labels[*i] as usize];
    let starts: Vec<(u32, f64)> = (0..n)
        .filter(core)
        .map(|i| (i as u32, -opening * radius[labels[i] as usize]))
        .collect();
    let mut grown = vec![f64::INFINITY; n];
    grow(graph, starts.into_iter(), &mut grown, &mut own, false);
    own
}

/// Shortest distances from starts with given distances. Labels spread with them; `within` stops them at the border of their own label.
fn grow(
    graph: &Graph,
    starts: impl Iterator<Item = (u32, f64)>,
    distances: &mut [f64],
    labels: &mut [u32],
    within: bool,
) {
    let mut heap: BinaryHeap<_> = starts
        .map(|(i, distance)| {
            distances[i as usize] = distance;
            Reverse(Reached(distance, i))
        })
        .collect();
    while let Some(Reverse(Reached(distance, at))) = heap.pop() {
        if distance > distances[at as usize] {
            continue;
        }
        for &(to, step) in &graph.neighbours[at as usize] {
            if to == NONE || distance + step >= distances[to as usize] {
                continue;
            }
            if within && labels[to as usize] != labels[at as usize] {
                continue;
            }
            distances[to as usize] = distance + step;
            labels[to as usize] = labels[at as usize];
            heap.push(Reverse(Reached(distance + step, to)));
        }
    }
}
