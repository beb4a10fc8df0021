//! Packing: the place of each flattened chart in the texture.
//!
//! Charts are packed by their exact cells, gutter included, on a bitmap: large ones first, each at the lowest place in any of its
//! orientations. All charts have the same scale, times the weights of their objects. Orders of charts are tried on a bitmap of coarse
//! cells, and changed slightly and repeatedly as long as that makes the pile lower; with the best of them the largest scale that fits is
//! searched for on the real bitmap. The number of trials depends on the number of charts only, never on the time.

use glam::IVec2;
use rayon::prelude::*;

use super::super::surface::{AtlasMap, Surface};
use super::fixed::Fixed;
use super::flat::FlatChart;
use super::piece::Piece;
use super::pile::{Candidate, Pile, Sheet, Spot};
use super::{AtlasError, AtlasOptions, Control, MAX_SIZE, owners, pieces};
use crate::rng::{Purpose, random};

/// Cells along a side of the bitmap at the most.
const MOST_CELLS: u32 = 1024;

/// Cells along a side of the bitmap at the most, while orders are tried.
const COARSE_CELLS: u32 = 360;

/// With more charts than this no orders are tried: among so many small ones there is always one that fits.
const MANY: usize = 600;

/// With more charts than this, the orientations found on coarse cells are not used on the real bitmap.
const FEW: usize = 40;

/// Orders that are kept.
const KEPT: usize = 4;

/// With more charts than this each is tried in one orientation only.
const VERY_MANY: usize = 3000;

/// Orders that are tried in parallel.
const TOGETHER: u32 = 8;

/// Limits of the rounds of changed orders: about so many runs of cells are searched for, with at most one round for each so many triangles,
/// and at least and at most so many rounds.
const RUNS: usize = 250_000;
const TRIANGLES: usize = 1000;
const LEAST_ROUNDS: usize = 2;
const MOST_ROUNDS: usize = 24;

/// Texels a chart, on average, below which a scale is not accepted.
const LEAST_TEXELS: f64 = 1.0;

/// The share of the atlas's total time before packing starts.
const START: f32 = 0.62;

/// Packs charts into the texture: per triangle its map and chart, and the number of charts.
pub(super) fn place(
    surface: &Surface,
    flat: Vec<FlatChart>,
    options: &AtlasOptions,
    control: &Control<'_>,
) -> Result<(Vec<AtlasMap>, Vec<u32>, u32), AtlasError> {
    control.step("packing", START)?;
    let sheet = Sheet::new(options.size, options.gutter, MOST_CELLS);
    let pieces = pieces::prepared(surface, flat, options, control)?;
    let packer = Packer::new(pieces, options.turn != 0);
    let found = packer.search(sheet, control)?;
    control.step("packing", owners::START)?;
    Ok(packer.placed(surface, sheet.fixed, &found))
}

/// An order of the charts, and the orientation in which each is tried: a given one, or any.
#[derive(Clone, Debug)]
struct Plan {
    order: Vec<u32>,
    /// Per chart, the number of its orientation; empty: any.
    turns: Vec<u8>,
}

/// A packing that fits.
struct Found {
    scale: f64,
    /// Per chart.
    spots: Vec<Spot>,
}

struct Packer {
    pieces: Vec<Piece>,
    /// Charts have been turned and keep their orientation.
    turned: bool,
    /// The sum of the charts' areas, weighted.
    area: f64,
    /// The longest side of a chart's box, weighted.
    longest: f64,
}

impl Packer {
    fn new(pieces: Vec<Piece>, turned: bool) -> Self {
        Self {
            area: pieces.iter().map(Piece::area).sum(),
            longest: pieces
                .iter()
                .map(|piece| piece.extent.max_element())
                .fold(0.0, f64::max),
            pieces,
            turned,
        }
    }

    /// The scale at which the triangles fill this share of the texture.
    fn scale_for(&self, sheet: Sheet, utilisation: f64) -> f64 {
        f64::from(sheet.size) * (utilisation / self.area).sqrt()
    }

    /// The scale above which no packing exists: all of the texture is full, or the longest chart is as long as its diagonal.
    fn scale_limit(&self, sheet: Sheet) -> f64 {
        let diagonal = 1.42 * f64::from(sheet.size);
        (diagonal / self.longest).min(self.scale_for(sheet, 1.0))
    }

    /// The scale below which charts have too few texels.
    fn least_scale(&self, sheet: Sheet) -> f64 {
        let texels = f64::from(sheet.size) * f64::from(sheet.size);
        let least = LEAST_TEXELS * self.pieces.len() as f64 / texels;
        self.scale_for(sheet, least)
            .min(0.7 * self.scale_limit(sheet))
    }

    fn turn_count(&self) -> usize {
        match self.pieces.len() {
            _ if self.turned => 1,
            n if n > VERY_MANY => 1,
            n if n > MANY => 4,
            _ => 8,
        }
    }

    /// The candidates of all charts at a scale, in the orientations of the plans; without plans, in all orientations.
    fn candidates(&self, sheet: Sheet, scale: f64, plans: &[Plan]) -> Vec<Vec<Option<Candidate>>> {
        let count = self.turn_count();
        let is_used = |index: usize, turn: usize| {
            let mut plans = plans.iter();
            plans.len() == 0
                || plans.any(|plan| plan.turns.get(index).is_none_or(|&k| k as usize == turn))
        };
        self.pieces
            .par_iter()
            .enumerate()
            .map(|(index, piece)| {
                let turns = piece.turns().into_iter().enumerate();
                turns
                    .take(if piece.is_needle() {
                        count.min(4)
                    } else {
                        count
                    })
                    .map(|(k, turn)| {
                        is_used(index, k).then(|| Candidate::new(piece, sheet, turn, scale))
                    })
                    .collect()
            })
            .collect()
    }

    /// Packs all charts at a scale, by the first plan by which they fit.
    fn pack(&self, sheet: Sheet, scale: f64, plans: &[Plan]) -> Option<Found> {
        let cells = sheet.cells();
        // No masks are made at a scale that cannot fit: they might be far larger than the texture.
        if scale > self.scale_limit(sheet) || cells == 0 {
            return None;
        }
        let candidates = self.candidates(sheet, scale, plans);
        let any = |candidates: &Vec<Option<Candidate>>| {
            candidates
                .iter()
                .flatten()
                .next()
                .map_or(0, |c| c.shape.count)
        };
        // All orientations take about equally many cells.
        let taken = candidates.iter().map(any).sum::<usize>() * 49 / 50;
        if taken > cells * cells {
            return None;
        }
        plans
            .par_iter()
            .map(|plan| {
                let pile = Pile::of(&candidates, &plan.order, &plan.turns, [cells, cells])?;
                Some(pile.spots(sheet, &candidates))
            })
            .find_first(Option::is_some)
            .flatten()
            .map(|spots| Found { scale, spots })
    }

    /// The largest scale that is found to work.
    fn search(&self, sheet: Sheet, control: &Control<'_>) -> Result<Found, AtlasError> {
        let any = [self.by_size()];
        let mut plans = any.to_vec();
        let mut guess = self.full_scale(sheet);
        if (2..=MANY).contains(&self.pieces.len()) {
            (plans, guess) = self.plans(sheet, guess, control)?;
        }
        let least = self.least_scale(sheet);
        let mut best: Option<Found> = None;
        let (mut low, mut high) = (0.93 * guess, 1.05 * guess);
        let mut rounds = 0;
        while rounds < 3 {
            let scales: Vec<f64> = (1..=3)
                .map(|k| low + (high - low) * f64::from(k) / 4.0)
                .collect();
            let found: Vec<Option<Found>> = scales
                .par_iter()
                .map(|&scale| {
                    control.check()?;
                    Ok(self.pack(sheet, scale, &plans))
                })
                .collect::<Result<_, AtlasError>>()?;
            match found.iter().rposition(Option::is_some) {
                Some(2) if high < self.scale_limit(sheet) && rounds == 0 => {
                    (low, high) = (high, high * 1.1);
                }
                Some(k) => {
                    low = scales[k];
                    high = if k < 2 { scales[k + 1] } else { high };
                    rounds += 1;
                }
                None if best.is_some() => {
                    high = scales[0];
                    rounds += 1;
                }
                None if low > least => (low, high) = (0.85 * low, low),
                None => break,
            }
            best = found.into_iter().flatten().last().or(best);
            control.step(
                "packing",
                START + (0.4 + 0.2 * rounds as f32) * (owners::START - START),
            )?;
        }
        match best.or_else(|| self.pack(sheet, least, &any)) {
            Some(best) => Ok(best),
            None => Err(self.no_room(sheet, control)?),
        }
    }

    /// The cells that all charts take.
    fn taken(&self, sheet: Sheet, scale: f64) -> f64 {
        let count = |piece: &Piece| {
            let footprint = piece.footprint(sheet.fixed, piece.upright, scale, sheet.side as i32);
            footprint.filled.mask.count()
        };
        self.pieces.par_iter().map(count).sum::<usize>() as f64
    }

    /// About the scale at which charts take four fifths of the texture, including gutters.
    fn full_scale(&self, sheet: Sheet) -> f64 {
        let coarse = Sheet::new(sheet.size, sheet.fixed.gutter, COARSE_CELLS);
        let limit = 0.7 * self.scale_limit(sheet);
        let cells = coarse.cells() as f64;
        let room = 0.8 * (cells * cells);
        let mut scale = limit;
        for _ in 0..5 {
            let share = room / self.taken(coarse, scale).max(1.0);
            scale = (scale * share.sqrt().clamp(0.2, 1.5)).min(limit);
        }
        scale.max(self.least_scale(sheet))
    }

    /// Large charts first, each in any orientation.
    fn by_size(&self) -> Plan {
        let area: Vec<f64> = self.pieces.iter().map(Piece::box_area).collect();
        let mut order: Vec<u32> = (0..self.pieces.len() as u32).collect();
        order.sort_by(|&a, &b| {
            area[b as usize]
                .total_cmp(&area[a as usize])
                .then(a.cmp(&b))
        });
        Plan {
            order,
            turns: Vec::new(),
        }
    }

    /// Good orders, and about the scale at which the best of them fills the texture.
    fn plans(
        &self,
        sheet: Sheet,
        mut scale: f64,
        control: &Control<'_>,
    ) -> Result<(Vec<Plan>, f64), AtlasError> {
        let coarse = Sheet::new(sheet.size, sheet.fixed.gutter, COARSE_CELLS);
        let cells = coarse.cells();
        let room = [cells, 3 * cells];
        let mut candidates = self.candidates(coarse, scale, &[]);
        let by_size = self.by_size().order;
        let heap = |candidates: &[Vec<Option<Candidate>>], order: &[u32]| {
            Pile::of(candidates, order, &[], room).map(|pile| (pile.height(candidates), pile))
        };
        // Finds the scale at which the pile is about as high as wide.
        for _ in 0..4 {
            let ratio = match heap(&candidates, &by_size) {
                Some(((height, _), _)) => cells as f64 / height as f64,
                None => 0.4,
            };
            if (0.98..1.02).contains(&ratio) {
                break;
            }
            scale *= ratio.sqrt().min(1.2);
            candidates = self.candidates(coarse, scale, &[]);
        }
        let runs: usize = candidates
            .iter()
            .flatten()
            .flatten()
            .map(|candidate| candidate.shape.run_count())
            .sum();
        let triangles: usize = self
            .pieces
            .iter()
            .map(|piece| piece.flat.triangles.len())
            .sum();
        let rounds = (RUNS / runs.max(1))
            .min(triangles.div_ceil(TRIANGLES))
            .clamp(LEAST_ROUNDS, MOST_ROUNDS);
        let mut best: Vec<((usize, usize), Vec<u32>, Pile)> = Vec::new();
        for round in 0..rounds as u32 {
            control.check()?;
            let orders: Vec<Vec<u32>> = (0..TOGETHER)
                .map(|k| match best.get(k as usize % 2) {
                    None => shuffled(&by_size, k, 0, k.min(1) * 3),
                    Some((_, order, _)) => shuffled(order, k, round, 1 + k / 2),
                })
                .collect();
            let tried: Vec<_> = orders
                .into_par_iter()
                .map(|order| heap(&candidates, &order).map(|(height, pile)| (height, order, pile)))
                .collect();
            best.extend(tried.into_iter().flatten());
            // The sort is stable: of equally good orders the earlier one comes first.
            best.sort_by_key(|(height, ..)| *height);
            best.dedup_by(|a, b| a.1 == b.1);
            best.truncate(KEPT);
        }
        let Some(&((height, _), ..)) = best.first() else {
            return Ok((vec![self.by_size()], scale));
        };
        // Coarse cells take slightly more area than real ones.
        let guess = 1.01 * scale * (cells as f64 / height as f64).sqrt();
        // With many charts the best orientations depend on single cells.
        let is_free = self.pieces.len() > FEW;
        let plans = best.into_iter().map(|(_, order, pile)| Plan {
            order,
            turns: if is_free { Vec::new() } else { pile.turns },
        });
        let count = if is_free { 2 } else { KEPT };
        Ok((plans.take(count).collect(), guess))
    }

    /// The error with the smallest size at which the charts fit.
    fn no_room(&self, sheet: Sheet, control: &Control<'_>) -> Result<AtlasError, AtlasError> {
        let mut size = f64::from(sheet.size);
        let plan = [self.by_size()];
        let needed = loop {
            control.check()?;
            size = (1.02 * size).max(size + 1.0).floor();
            if size > f64::from(MAX_SIZE) {
                break u64::from(MAX_SIZE) + 1;
            }
            let larger = Sheet::new(size as u32, sheet.fixed.gutter, MOST_CELLS);
            let least = self.least_scale(larger);
            if self.pack(larger, least, &plan).is_some() {
                break size as u64;
            }
            let taken = self.taken(larger, least).sqrt() * f64::from(larger.side);
            size = size.max(0.97 * taken);
        };
        Ok(AtlasError::NoRoomForCharts {
            charts: self.pieces.len(),
            gutter: sheet.fixed.gutter,
            size: sheet.size,
            needed,
        })
    }

    fn placed(
        &self,
        surface: &Surface,
        fixed: Fixed,
        found: &Found,
    ) -> (Vec<AtlasMap>, Vec<u32>, u32) {
        let triangle_count = surface.corners.len();
        let mut maps = vec![bytemuck::Zeroable::zeroed(); triangle_count];
        let mut chart = vec![0; triangle_count];
        for (index, (piece, spot)) in self.pieces.iter().zip(&found.spots).enumerate() {
            for (t, corners) in piece.corners(fixed, spot.turn, found.scale, IVec2::ZERO) {
                maps[t as usize] = fixed.map_of(corners.map(|corner| corner + spot.shift));
                chart[t as usize] = index as u32;
            }
        }
        (maps, chart, self.pieces.len() as u32)
    }
}

/// The order with a few charts moved.
fn shuffled(order: &[u32], k: u32, round: u32, moves: u32) -> Vec<u32> {
    let mut order = order.to_vec();
    for step in 0..moves {
        let words = random(k, round, step, Purpose::Start);
        let [from, to] = [words[0], words[1]].map(|word| word as usize % order.len());
        let chart = order.remove(from);
        order.insert(to, chart);
    }
    order
}
