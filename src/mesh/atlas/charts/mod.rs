//! The `charts` method: how a surface is cut into few charts, and how each is flattened.
//!
//! Charts grow bottom-up. The surface is cut into small compact pieces, which are joined pair by pair as long as their union is a disc that
//! can be flattened without distorting areas and angles too much. Each piece is flattened conformally (`flatten`), because the plain
//! stencil of diffusion is right only in charts that keep angles.

mod cluster;
mod flatten;
mod merge;
mod metric;
mod patch;
mod piece;
mod smooth;
#[cfg(test)]
mod tests;

use std::cell::Cell;

use glam::DVec2;
use rayon::prelude::*;

use super::flat::FlatChart;
use super::{AtlasError, Control};
use crate::mesh::surface::{NONE, Surface};
use crate::portable::ln;
use cluster::Graph;
use merge::{Merger, Pool};
use metric::Metric;
use patch::{Patch, Places};
use piece::{Bounds, LOOSE, Piece, STRICT};
use smooth::Smoothing;

/// Connected parts up to this size are coarse: pieces begin as single triangles, and the teeth of borders do not count.
const SMALL: usize = 1500;
/// Bounds on first pieces: flatter than a chart, so that two of them can be joined; and of
/// any shape, because the shape follows the triangles.
const FIRST: Bounds = Bounds {
    share: 0.02,
    wild: 0.001,
    hull: f64::INFINITY,
    roundness: f64::INFINITY,
    part: f64::INFINITY,
};
/// The share of the whole atlas's time that goes to charts.
const DONE: f32 = 0.62;

/// How often joining and smoothing alternate at most, for each set of bounds: smoother pieces join better.
const REPEATS: usize = 3;
/// How borders are straightened.
const SMOOTHING: Smoothing = Smoothing {
    openings: &[0.6, 0.4],
    blur: 6,
};

/// Progress of the charts; never decreases.
struct Progress<'a> {
    control: &'a Control<'a>,
    done: Cell<f32>,
}

impl<'a> Progress<'a> {
    fn new(control: &'a Control<'a>) -> Self {
        Self {
            control,
            done: Cell::new(0.0),
        }
    }

    /// Reports that this share of the charts' work is done.
    fn report(&self, done: f32) -> Result<(), AtlasError> {
        self.done.set(self.done.get().max(done.min(1.0)));
        self.control
            .step("cutting into charts", DONE * self.done.get())
    }

    fn advance(&self, by: f32) -> Result<(), AtlasError> {
        self.report(self.done.get() + by)
    }
}

/// Cuts and flattens all objects.
pub(super) fn flat_charts(
    surface: &Surface,
    control: &Control<'_>,
) -> Result<Vec<FlatChart>, AtlasError> {
    let progress = Progress::new(control);
    progress.report(0.0)?;
    let mut metric = Metric::new(surface);
    let pool = Pool::default();
    let parts = connected_parts(surface);
    for part in parts.iter().filter(|part| part.len() <= SMALL) {
        for &t in part {
            metric.is_coarse[t as usize] = true;
        }
    }
    let pieces = first_pieces(surface, &metric, &parts, &pool, control)?;
    progress.report(0.15)?;
    let all: Vec<u32> = (0..surface.corners.len() as u32).collect();
    let graph =
        pool.with(|places| Graph::new(surface, &all, places, |a, b| metric.step(a, b, 0.0)));
    let first_count = pieces.len() as f64;
    let mut merger = Merger::new(surface, &metric, &pool, control, pieces);
    for bounds in [&STRICT, &LOOSE] {
        for _ in 0..REPEATS {
            let before = merger.pieces.iter().flatten().count();
            merger.run(bounds, |count| {
                let joined = 1.0 - ln(count as f64) / ln(first_count).max(1.0);
                progress.report(0.15 + 0.55 * joined.clamp(0.0, 1.0) as f32)
            })?;
            merger.smooth(&graph, &SMOOTHING, &STRICT)?;
            progress.advance(0.05)?;
            if merger.pieces.len() == before {
                break;
            }
        }
    }
    let mut pieces = merger.finish();
    pieces.sort_by_key(|piece| piece.triangles[0]);
    Ok(pieces
        .into_iter()
        .map(|piece| FlatChart {
            object: surface.triangles[piece.triangles[0] as usize].object,
            triangles: piece.triangles,
            corners: piece.corners,
        })
        .collect())
}

/// The pieces to begin with.
fn first_pieces(
    surface: &Surface,
    metric: &Metric,
    parts: &[Vec<u32>],
    pool: &Pool,
    control: &Control<'_>,
) -> Result<Vec<Piece>, AtlasError> {
    let curvature = curvature(surface, metric);
    // Sets of a part, and the length that an angle of one radian counts as in each.
    let sets_of = |part: &Vec<u32>| -> Result<Vec<(Vec<u32>, f64)>, AtlasError> {
        let own_area = metric.area(part);
        let turn = 0.1 * own_area.sqrt();
        if part.len() <= SMALL {
            return Ok(part.iter().map(|&t| (vec![t], turn)).collect());
        }
        let share = own_area / metric.total;
        let bent: f64 = part.iter().map(|&t| curvature[t as usize]).sum();
        let count = (30.0 + 200.0 * share + 2.0 * bent).min(part.len() as f64 / 12.0);
        let graph =
            pool.with(|places| Graph::new(surface, part, places, |a, b| metric.step(a, b, turn)));
        let labels = graph.parts(metric, count as usize, 3, control)?;
        let sets = by_label(part, &labels).into_iter();
        Ok(sets.map(|set| (set, turn)).collect())
    };
    let sets = parts.par_iter().map(sets_of);
    let sets: Vec<_> = sets.collect::<Result<_, AtlasError>>()?;
    let pieces: Vec<Vec<Piece>> = sets
        .par_iter()
        .flatten()
        .map(|(set, turn)| {
            control.check()?;
            Ok(pool.with(|places| cut_until_flat(surface, metric, set, *turn, places)))
        })
        .collect::<Result<_, AtlasError>>()?;
    Ok(pieces.into_iter().flatten().collect())
}

/// One piece, or several if one would be no disc or distort too much.
fn cut_until_flat(
    surface: &Surface,
    metric: &Metric,
    triangles: &[u32],
    turn: f64,
    places: &mut Places,
) -> Vec<Piece> {
    let mut open = vec![triangles.to_vec()];
    let mut pieces = Vec::new();
    while let Some(set) = open.pop() {
        match Piece::new(surface, metric, &set, &FIRST, places) {
            Ok(piece) => pieces.push(piece),
            Err(_) => {
                let graph = Graph::new(surface, &set, places, |a, b| metric.step(a, b, turn));
                open.extend(by_label(&set, &graph.halves()));
            }
        }
    }
    pieces
}

/// The triangles of each label, ascending; labels without any are left out.
fn by_label(triangles: &[u32], labels: &[u32]) -> Vec<Vec<u32>> {
    let count = labels.iter().max().map_or(0, |&most| most as usize + 1);
    let mut sets = vec![Vec::new(); count];
    for (&t, &label) in triangles.iter().zip(labels) {
        sets[label as usize].push(t);
    }
    sets.retain(|set| !set.is_empty());
    sets
}

/// The triangles of each part that is connected over edges, ascending.
fn connected_parts(surface: &Surface) -> Vec<Vec<u32>> {
    let mut part_of = vec![NONE; surface.corners.len()];
    let mut count = 0;
    let mut open = Vec::new();
    for first in 0..part_of.len() as u32 {
        if part_of[first as usize] != NONE {
            continue;
        }
        part_of[first as usize] = count;
        open.push(first);
        while let Some(t) = open.pop() {
            for h in 3 * t..3 * t + 3 {
                let twin = surface.halfedges[h as usize].twin;
                if twin != NONE && part_of[twin as usize / 3] == NONE {
                    part_of[twin as usize / 3] = count;
                    open.push(twin / 3);
                }
            }
        }
        count += 1;
    }
    let all: Vec<u32> = (0..part_of.len() as u32).collect();
    by_label(&all, &part_of)
}

/// Per triangle, a third of the absolute curvature at its corners, shared with the other triangles there.
fn curvature(surface: &Surface, metric: &Metric) -> Vec<f64> {
    let mut defects = vec![std::f64::consts::TAU; surface.positions.len()];
    let mut degrees = vec![0_u32; surface.positions.len()];
    for (corners, shape) in surface.corners.iter().zip(&metric.shapes) {
        for (&v, angle) in corners.iter().zip(shape.angles) {
            defects[v as usize] -= angle;
            degrees[v as usize] += 1;
        }
    }
    for (h, halfedge) in surface.halfedges.iter().enumerate() {
        if halfedge.twin == NONE {
            defects[surface.corners[h / 3][h % 3] as usize] = 0.0;
            defects[surface.corners[h / 3][(h + 1) % 3] as usize] = 0.0;
        }
    }
    let share = |&v: &u32| defects[v as usize].abs() / f64::from(degrees[v as usize]);
    surface
        .corners
        .par_iter()
        .map(|corners| corners.iter().map(share).sum())
        .collect()
}

/// Cuts a flattened chart of at least two triangles into compact discs that keep their places in the plane.
pub(super) fn split(surface: &Surface, chart: &FlatChart) -> Vec<FlatChart> {
    let middle = |t: u32| {
        let corners = chart.triangles.binary_search(&t).map(|i| chart.corners[i]);
        corners.map_or(DVec2::ZERO, |[a, b, c]| (a + b + c) / 3.0)
    };
    let mut places = Places::new();
    let mut cut = |set: &[u32]| {
        let graph = Graph::new(surface, set, &mut places, |a, b| {
            middle(a).distance(middle(b))
        });
        by_label(set, &graph.halves())
    };
    let mut open = cut(&chart.triangles);
    let mut discs = Vec::new();
    let mut patch_places = Places::new();
    while let Some(set) = open.pop() {
        if set.len() == 1 || Patch::new(surface, &set, &mut patch_places).is_some() {
            discs.push(set);
        } else {
            open.extend(cut(&set));
        }
    }
    discs.sort();
    let corners = |set: &[u32]| {
        set.iter()
            .filter_map(|t| chart.triangles.binary_search(t).ok())
            .map(|i| chart.corners[i])
            .collect()
    };
    discs
        .into_iter()
        .map(|triangles| FlatChart {
            object: chart.object,
            corners: corners(&triangles),
            triangles,
        })
        .collect()
}
