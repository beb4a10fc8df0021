//! Cutting sets of triangles into compact parts: each triangle belongs to the nearest seed in the dual graph, in which the length of an
//! edge combines distance and the angle between normals.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use super::metric::Metric;
use super::patch::Places;
use super::{AtlasError, Control};
use crate::mesh::surface::{NONE, Surface};

/// A distance that can be ordered; triangles break ties.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Reached(pub f64, pub u32);

impl Eq for Reached {}

impl PartialOrd for Reached {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Reached {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0).then(self.1.cmp(&other.1))
    }
}

/// The dual graph of some triangles.
pub(super) struct Graph {
    /// Triangles of the surface, ascending.
    pub triangles: Vec<u32>,
    /// Per triangle its neighbours among them, and their distances.
    pub neighbours: Vec<[(u32, f64); 3]>,
}

impl Graph {
    /// `step` is the distance from one triangle to a neighbour.
    pub fn new(
        surface: &Surface,
        triangles: &[u32],
        places: &mut Places,
        step: impl Fn(u32, u32) -> f64,
    ) -> Self {
        places.resize(surface.corners.len(), NONE);
        for (i, &t) in triangles.iter().enumerate() {
            places[t as usize] = i as u32;
        }
        let neighbours = triangles
            .iter()
            .map(|&t| {
                [0, 1, 2].map(|corner| {
                    let twin = surface.halfedges[(3 * t + corner) as usize].twin;
                    if twin == NONE || places[twin as usize / 3] == NONE {
                        return (NONE, 0.0);
                    }
                    (places[twin as usize / 3], step(t, twin / 3).max(0.0))
                })
            })
            .collect();
        for &t in triangles {
            places[t as usize] = NONE;
        }
        Self {
            triangles: triangles.to_vec(),
            neighbours,
        }
    }

    /// Lowers the distances of triangles that are nearer to one of the seeds, and gives them its label.
    fn spread(&self, seeds: &[(u32, u32)], distances: &mut [f64], labels: &mut [u32]) {
        let mut heap = BinaryHeap::new();
        for &(seed, label) in seeds {
            distances[seed as usize] = 0.0;
            labels[seed as usize] = label;
            heap.push(Reverse(Reached(0.0, seed)));
        }
        while let Some(Reverse(Reached(distance, at))) = heap.pop() {
            if distance > distances[at as usize] {
                continue;
            }
            for &(to, step) in &self.neighbours[at as usize] {
                if to == NONE || distance + step >= distances[to as usize] {
                    continue;
                }
                distances[to as usize] = distance + step;
                labels[to as usize] = labels[at as usize];
                heap.push(Reverse(Reached(distance + step, to)));
            }
        }
    }

    /// For each triangle the nearer one of two far ends. The halves of connected triangles are connected; unconnected triangles give
    /// more parts.
    pub fn halves(&self) -> Vec<u32> {
        let n = self.triangles.len();
        let farthest = |distances: &[f64]| {
            let most = (0..n as u32).max_by(|&i, &j| {
                distances[i as usize]
                    .total_cmp(&distances[j as usize])
                    .then(j.cmp(&i))
            });
            most.expect("there are triangles")
        };
        let mut labels = vec![0; n];
        let mut distances = vec![f64::INFINITY; n];
        self.spread(&[(0, 0)], &mut distances, &mut labels);
        let first = farthest(&distances);
        if distances[first as usize].is_finite() {
            distances.fill(f64::INFINITY);
            self.spread(&[(first, 0)], &mut distances, &mut labels);
        }
        let last = farthest(&distances);
        if distances[last as usize] > 0.0 {
            self.spread(&[(last, 1)], &mut distances, &mut labels);
        } else {
            // All triangles are in one place.
            labels[0] = 1;
        }
        labels
    }

    /// Cuts connected triangles into about `count` parts of similar size.
    pub fn parts(
        &self,
        metric: &Metric,
        count: usize,
        rounds: usize,
        control: &Control<'_>,
    ) -> Result<Vec<u32>, AtlasError> {
        let n = self.triangles.len();
        let mut labels = vec![0; n];
        let mut distances = vec![f64::INFINITY; n];
        let mut seeds: Vec<u32> = Vec::with_capacity(count);
        let mut next_seed = 0;
        while seeds.len() < count.min(n) {
            let label = seeds.len() as u32;
            seeds.push(next_seed);
            self.spread(&[(next_seed, label)], &mut distances, &mut labels);
            let farthest = (0..n as u32).max_by(|&i, &j| {
                distances[i as usize]
                    .total_cmp(&distances[j as usize])
                    .then(j.cmp(&i))
            });
            next_seed = farthest.expect("there are triangles");
            if distances[next_seed as usize] == 0.0 {
                break;
            }
            control.check()?;
        }
        for _ in 0..rounds {
            self.move_to_middles(metric, &labels, &mut seeds);
            distances.fill(f64::INFINITY);
            let all: Vec<_> = seeds.iter().copied().zip(0..).collect();
            self.spread(&all, &mut distances, &mut labels);
            control.check()?;
        }
        Ok(labels)
    }

    /// Takes each part's seed to its triangle nearest to the part's centroid (Lloyd, 1982).
    fn move_to_middles(&self, metric: &Metric, labels: &[u32], seeds: &mut [u32]) {
        let mut sums = vec![(glam::DVec3::ZERO, 0.0); seeds.len()];
        for (&t, &label) in self.triangles.iter().zip(labels) {
            let area = metric.shapes[t as usize].area();
            let (sum, weight) = &mut sums[label as usize];
            *sum += area * metric.centroids[t as usize];
            *weight += area;
        }
        let mut nearest = vec![f64::INFINITY; seeds.len()];
        for (i, (&t, &label)) in self.triangles.iter().zip(labels).enumerate() {
            let (sum, weight) = sums[label as usize];
            let distance = metric.centroids[t as usize].distance_squared(sum / weight);
            if distance < nearest[label as usize] {
                nearest[label as usize] = distance;
                seeds[label as usize] = i as u32;
            }
        }
    }
}
