//! Growing charts bottom-up: neighbouring pieces are joined as long as their union can be flattened well enough.
//!
//! Each round tests pairs in parallel, each piece in one pair at most, by flattening their union. A pair is only tried if it is nearly the
//! best of both pieces, so the order of good joins does not depend on numbering.

use std::collections::HashMap;
use std::sync::Mutex;

use rayon::prelude::*;

use super::metric::Metric;
use super::patch::Places;
use super::piece::{Bounds, Piece, Refusal, Spending};
use super::{AtlasError, Control};
use crate::mesh::surface::{NONE, Surface};

/// A pair is tried if its score is at least this share of the best score of both pieces.
const SLACK: f64 = 0.9;
/// A refused pair is tried again if the area of both together has grown by this factor.
const GROWN: f64 = 1.3;

/// Scratch memory for parallel work.
#[derive(Default)]
pub(super) struct Pool(Mutex<Vec<Places>>);

impl Pool {
    pub fn with<T>(&self, work: impl FnOnce(&mut Places) -> T) -> T {
        let taken = self.0.lock().ok().and_then(|mut pool| pool.pop());
        let mut places = taken.unwrap_or_default();
        let result = work(&mut places);
        if let Ok(mut pool) = self.0.lock() {
            pool.push(places);
        }
        result
    }
}

/// Pieces of the whole surface, and the piece of each triangle.
pub(super) struct Merger<'a> {
    pub surface: &'a Surface,
    pub metric: &'a Metric,
    pub pool: &'a Pool,
    pub control: &'a Control<'a>,
    /// Pieces keep their number; joined ones leave a gap.
    pub pieces: Vec<Option<Piece>>,
    /// Per triangle, its piece.
    pub labels: Vec<u32>,
    /// Surface area of everything.
    pub area: f64,
    /// Refused pairs, and the area that they had together.
    refused: HashMap<(u32, u32), f64>,
}

struct Pair {
    score: f64,
    a: u32,
    b: u32,
}

impl<'a> Merger<'a> {
    pub fn new(
        surface: &'a Surface,
        metric: &'a Metric,
        pool: &'a Pool,
        control: &'a Control<'a>,
        pieces: Vec<Piece>,
    ) -> Self {
        let mut labels = vec![NONE; surface.corners.len()];
        for (label, piece) in pieces.iter().enumerate() {
            for &t in &piece.triangles {
                labels[t as usize] = label as u32;
            }
        }
        Self {
            surface,
            metric,
            pool,
            control,
            area: pieces.iter().map(|piece| piece.area).sum(),
            pieces: pieces.into_iter().map(Some).collect(),
            labels,
            refused: HashMap::new(),
        }
    }

    pub fn finish(self) -> Vec<Piece> {
        self.pieces.into_iter().flatten().collect()
    }

    /// Joins pieces until no pair can be joined, and reports the number of pieces after each round.
    pub fn run(
        &mut self,
        bounds: &Bounds,
        mut report: impl FnMut(usize) -> Result<(), AtlasError>,
    ) -> Result<(), AtlasError> {
        loop {
            let chosen = self.choose();
            if chosen.is_empty() {
                return Ok(());
            }
            let joined: Vec<_> = chosen
                .par_iter()
                .with_max_len(1)
                .map(|pair| {
                    self.control.check()?;
                    Ok(self.try_pair(pair, bounds))
                })
                .collect::<Result<_, AtlasError>>()?;
            let mut spent = self.spent();
            for (pair, piece) in chosen.iter().zip(joined) {
                let affordable = piece.ok().and_then(|piece| {
                    let olds = [pair.a, pair.b].map(|i| self.spending(i));
                    let sum = spent
                        .plus(&piece.spending())
                        .minus(&olds[0])
                        .minus(&olds[1]);
                    sum.within(&spent, self.area).then_some((piece, sum))
                });
                if let Some((piece, sum)) = affordable {
                    spent = sum;
                    self.join(pair, piece);
                } else {
                    let area = self.area_of(pair.a) + self.area_of(pair.b);
                    self.refused.insert((pair.a, pair.b), area);
                }
            }
            report(self.pieces.iter().flatten().count())?;
        }
    }

    /// Forgets which pairs were refused, for a run with other bounds.
    pub fn forget(&mut self) {
        self.refused.clear();
    }

    /// The areas that shrink, grow and skew too much, of all pieces.
    pub fn spent(&self) -> Spending {
        let pieces = self.pieces.iter().flatten();
        pieces.fold(Spending::default(), |sum, piece| {
            sum.plus(&piece.spending())
        })
    }

    fn spending(&self, piece: u32) -> Spending {
        let piece = self.pieces[piece as usize].as_ref();
        piece.map_or(Spending::default(), Piece::spending)
    }

    fn area_of(&self, piece: u32) -> f64 {
        self.pieces[piece as usize].as_ref().map_or(0.0, |p| p.area)
    }

    fn try_pair(&self, pair: &Pair, bounds: &Bounds) -> Result<Piece, Refusal> {
        let [a, b] = [pair.a, pair.b].map(|i| self.pieces[i as usize].as_ref());
        let (Some(a), Some(b)) = (a, b) else {
            return Err(Refusal::Shape);
        };
        let triangles = merged(&a.triangles, &b.triangles);
        // A union may be as long and as lobed as the worse of the two pieces.
        let bounds = Bounds {
            hull: bounds.hull.max(a.quality.hull).max(b.quality.hull),
            roundness: (bounds.roundness)
                .max(a.quality.roundness)
                .max(b.quality.roundness),
            ..*bounds
        };
        self.pool
            .with(|places| Piece::new(self.surface, self.metric, &triangles, &bounds, places))
    }

    fn join(&mut self, pair: &Pair, piece: Piece) {
        let new = self.pieces.len() as u32;
        for &t in &piece.triangles {
            self.labels[t as usize] = new;
        }
        self.pieces.push(Some(piece));
        self.pieces[pair.a as usize] = None;
        self.pieces[pair.b as usize] = None;
        for (other, _) in self.neighbours(new) {
            let refused_with = |old: u32| self.refused.get(&(old.min(other), old.max(other)));
            let most = [pair.a, pair.b]
                .into_iter()
                .filter_map(refused_with)
                .fold(0.0, |most: f64, &area| most.max(area));
            if self.area_of(new) + self.area_of(other) < GROWN * most {
                self.refused.insert((other, new), most);
            }
        }
    }

    /// The neighbours of a piece in ascending order, and the length of the border that they share.
    pub fn neighbours(&self, piece: u32) -> Vec<(u32, f64)> {
        let Some(of) = &self.pieces[piece as usize] else {
            return Vec::new();
        };
        let mut found: Vec<(u32, f64)> = of
            .border
            .iter()
            .filter_map(|&h| {
                let twin = self.surface.halfedges[h as usize].twin;
                let other = if twin == NONE {
                    piece
                } else {
                    self.labels[twin as usize / 3]
                };
                (other != piece).then(|| (other, self.metric.length(h)))
            })
            .collect();
        found.sort_by_key(|&(other, _)| other);
        found.dedup_by(|next, kept| {
            let same = next.0 == kept.0;
            if same {
                kept.1 += next.1;
            }
            same
        });
        found
    }

    /// The pairs of the next round.
    fn choose(&self) -> Vec<Pair> {
        let mut pairs: Vec<Pair> = (0..self.pieces.len() as u32)
            .into_par_iter()
            .flat_map_iter(|a| self.pairs_of(a))
            .collect();
        pairs.sort_by(|x, y| {
            y.score
                .total_cmp(&x.score)
                .then((x.a, x.b).cmp(&(y.a, y.b)))
        });
        let mut best = vec![0.0; self.pieces.len()];
        for pair in &pairs {
            for i in [pair.a, pair.b] {
                best[i as usize] = pair.score.max(best[i as usize]);
            }
        }
        let mut taken = vec![false; self.pieces.len()];
        pairs.retain(|pair| {
            let (a, b) = (pair.a as usize, pair.b as usize);
            let free = !taken[a] && !taken[b] && pair.score >= SLACK * best[a].max(best[b]);
            if free {
                taken[a] = true;
                taken[b] = true;
            }
            free
        });
        pairs
    }

    fn pairs_of(&self, a: u32) -> Vec<Pair> {
        let Some(piece) = &self.pieces[a as usize] else {
            return Vec::new();
        };
        let mut pairs = Vec::new();
        for (b, shared) in self.neighbours(a) {
            if b < a || self.refused.contains_key(&(a, b)) {
                continue;
            }
            let Some(other) = &self.pieces[b as usize] else {
                continue;
            };
            pairs.push(Pair {
                score: score(piece, other, shared),
                a,
                b,
            });
        }
        pairs
    }
}

/// The score of a pair: round unions first, small ones before large ones.
fn score(a: &Piece, b: &Piece, shared: f64) -> f64 {
    let perimeter = (a.perimeter + b.perimeter - 2.0 * shared).max(1e-9 * a.perimeter);
    let area = a.area + b.area;
    area / (perimeter * perimeter) / area.sqrt().sqrt()
}

/// Two ascending lists as one.
pub(super) fn merged(a: &[u32], b: &[u32]) -> Vec<u32> {
    let mut all = Vec::with_capacity(a.len() + b.len());
    all.extend_from_slice(a);
    all.extend_from_slice(b);
    all.sort_unstable();
    all
}
