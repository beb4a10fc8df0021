//! Packing: where in the texture each flattened chart goes.
//!
//! Charts are packed by what they really take, gutter included, on a bitmap of texels (or of cells of a few texels in
//! large textures): the largest first, each in the lowest place that is free in any of its orientations. All charts
//! have the same scale, but for the weights of their objects; the largest scale that fits is searched for.

use std::collections::HashMap;
use std::f64::consts::TAU;

use glam::{DVec2, IVec2};
use rayon::prelude::*;

use super::super::surface::{AtlasMap, Surface};
use super::bitmap::{Bitmap, Shape};
use super::fixed::Fixed;
use super::flat::FlatChart;
use super::outline::Mask;
use super::piece::Piece;
use super::{AtlasError, AtlasOptions, Control, MAX_SIZE, charts};
use crate::rng::{Purpose, random, unit};

/// Cells along a side of the bitmap at the most.
const MOST_CELLS: u32 = 1024;

/// With more charts than this, only one orientation and order are tried.
const MANY: usize = 1500;

/// Texels a chart, on average, below which a scale is not worth having.
const LEAST_TEXELS: f64 = 1.0;

/// Packs charts into the texture: per triangle its map and chart, and the number of charts.
pub(super) fn place(
    surface: &Surface,
    flat: Vec<FlatChart>,
    options: &AtlasOptions,
    control: &Control<'_>,
) -> Result<(Vec<AtlasMap>, Vec<u32>, u32), AtlasError> {
    control.step("packing", 0.0)?;
    let sheet = Sheet::new(options.size, options.gutter);
    let packer = Packer::new(surface, flat, options, control)?;
    let (scale, packing) = packer.search(sheet, control)?;
    control.step("packing", 1.0)?;
    Ok(packer.placed(surface, sheet.fixed, scale, &packing))
}

/// Where one chart goes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Spot {
    turn: DVec2,
    shift: IVec2,
}

/// What a chart takes in one orientation.
struct Candidate {
    shape: Shape,
    turn: DVec2,
    shift: IVec2,
}

/// What charts are packed into.
#[derive(Clone, Copy)]
struct Sheet {
    size: u32,
    fixed: Fixed,
    /// Texels along the side of a cell: an odd number.
    side: u32,
}

impl Sheet {
    fn new(size: u32, gutter: u32) -> Self {
        let side = size.div_ceil(MOST_CELLS);
        Self {
            size,
            fixed: Fixed::new(size, gutter),
            side: side + 1 - side % 2,
        }
    }
}

struct Packer {
    pieces: Vec<Piece>,
    /// Charts are turned at random and then not any more.
    turned: bool,
    /// The sum of the charts' areas, weighted.
    area: f64,
    /// The longest side of a chart's box, weighted.
    longest: f64,
}

impl Packer {
    fn new(
        surface: &Surface,
        flat: Vec<FlatChart>,
        options: &AtlasOptions,
        control: &Control<'_>,
    ) -> Result<Self, AtlasError> {
        let weight_of = |object: u32| match options.weights.get(object as usize) {
            Some(&weight) if weight > 0.0 && weight.is_finite() => f64::from(weight).sqrt(),
            _ => 1.0,
        };
        let to_piece = |flat: FlatChart| {
            let weight = weight_of(flat.object);
            Piece::new(surface, flat, weight)
        };
        let mut pieces: Vec<Piece> = flat.into_par_iter().map(to_piece).collect();
        control.check()?;
        let sheet = Sheet::new(options.size, options.gutter);
        loop {
            let packer = Self::of(pieces, options.turn != 0);
            // About the scale at which charts will be packed.
            let scale = packer.scale_for(sheet, 0.6).min(packer.widest_scale(sheet));
            let apart: Vec<Vec<FlatChart>> = packer
                .pieces
                .into_par_iter()
                .map(|piece| without_overlaps(surface, piece, sheet.fixed, scale))
                .collect();
            let done = apart.iter().all(|parts| parts.len() == 1);
            pieces = apart.into_par_iter().flatten().map(to_piece).collect();
            control.check()?;
            if done {
                break;
            }
        }
        if options.turn != 0 {
            turn_at_random(&mut pieces, options.turn);
        }
        Ok(Self::of(pieces, options.turn != 0))
    }

    fn of(pieces: Vec<Piece>, turned: bool) -> Self {
        let longest = pieces.iter().fold(0.0f64, |longest, piece| {
            longest.max(piece.extent.max_element())
        });
        Self {
            area: pieces.iter().map(Piece::area).sum(),
            longest,
            pieces,
            turned,
        }
    }

    /// The scale at which the triangles fill so much of the texture.
    fn scale_for(&self, sheet: Sheet, utilisation: f64) -> f64 {
        f64::from(sheet.size) * (utilisation / self.area).sqrt()
    }

    /// The scale at which the longest chart is as long as the texture.
    fn widest_scale(&self, sheet: Sheet) -> f64 {
        f64::from(sheet.size) / self.longest
    }

    fn turns(&self, piece: &Piece) -> Vec<DVec2> {
        let upright = piece.upright;
        if self.turned || self.pieces.len() > MANY {
            vec![upright]
        } else {
            vec![upright, upright.perp(), -upright, -upright.perp()]
        }
    }

    fn candidates(&self, sheet: Sheet, scale: f64) -> Vec<Vec<Candidate>> {
        self.pieces
            .par_iter()
            .map(|piece| {
                self.turns(piece)
                    .into_iter()
                    .map(|turn| {
                        let footprint =
                            piece.footprint(sheet.fixed, turn, scale, sheet.side as i32);
                        Candidate {
                            shape: Shape::new(footprint.filled.mask),
                            turn,
                            shift: footprint.shift,
                        }
                    })
                    .collect()
            })
            .collect()
    }

    /// All charts at a scale, if they fit.
    fn pack(&self, sheet: Sheet, scale: f64) -> Option<Vec<Spot>> {
        let cells = (sheet.size / sheet.side) as usize;
        // What cannot fit is not made into masks: they might be far larger than the texture.
        if scale > self.scale_for(sheet, 1.0).min(self.widest_scale(sheet)) {
            return None;
        }
        let candidates = self.candidates(sheet, scale);
        let taken: usize = candidates.iter().map(|c| c[0].shape.count).sum();
        if taken > cells * cells {
            return None;
        }
        let orders = if self.pieces.len() > MANY { 1 } else { 3 };
        (0..orders)
            .into_par_iter()
            .map(|order| self.pack_in_order(sheet, &candidates, &in_order(&candidates, order)))
            .find_first(Option::is_some)
            .flatten()
    }

    fn pack_in_order(
        &self,
        sheet: Sheet,
        candidates: &[Vec<Candidate>],
        order: &[u32],
    ) -> Option<Vec<Spot>> {
        let cells = (sheet.size / sheet.side) as usize;
        let mut bitmap = Bitmap::new(cells);
        let nowhere = Spot {
            turn: DVec2::X,
            shift: IVec2::ZERO,
        };
        let mut spots = vec![nowhere; candidates.len()];
        // Where the search for a small mask goes on: what was taken below stays taken.
        let mut below: HashMap<&Mask, usize> = HashMap::new();
        for &index in order {
            let mut best: Option<(usize, usize, usize, &Candidate)> = None;
            for candidate in &candidates[index as usize] {
                let shape = &candidate.shape;
                let is_small = shape.mask.words.len() <= 16;
                let from = if is_small {
                    below.get(&shape.mask).copied().unwrap_or(0)
                } else {
                    0
                };
                let highest = best.map_or(cells, |(top, ..)| top);
                let found = bitmap.lowest(shape, from, highest);
                if let Some([x, y]) = found {
                    if is_small {
                        below.insert(&shape.mask, y);
                    }
                    let top = y + shape.height;
                    if best.is_none_or(|(most, _, left, _)| (top, x) < (most, left)) {
                        best = Some((top, y, x, candidate));
                    }
                }
            }
            let (_, y, x, candidate) = best?;
            bitmap.take(&candidate.shape, [x, y]);
            let step = sheet.side as i32 * sheet.fixed.texel;
            spots[index as usize] = Spot {
                turn: candidate.turn,
                shift: candidate.shift + IVec2::new(x as i32, y as i32) * step,
            };
        }
        Some(spots)
    }

    /// The largest scale that is found to work.
    fn search(&self, sheet: Sheet, control: &Control<'_>) -> Result<(f64, Vec<Spot>), AtlasError> {
        let mut best: Option<(f64, Vec<Spot>)> = None;
        let least = self.least_scale(sheet);
        let (mut low, mut high) = (self.scale_for(sheet, 0.62), self.scale_for(sheet, 0.9));
        let mut round = 0;
        while round < 4 {
            control.check()?;
            let scales: Vec<f64> = (1..=3)
                .map(|k| low + (high - low) * f64::from(k) / 4.0)
                .collect();
            let found: Vec<Option<Vec<Spot>>> = scales
                .par_iter()
                .map(|&scale| self.pack(sheet, scale))
                .collect();
            let largest = found.iter().rposition(Option::is_some);
            if let Some(k) = largest {
                low = scales[k];
                if k + 1 < scales.len() {
                    high = scales[k + 1];
                }
                best = found.into_iter().nth(k).flatten().map(|spots| (low, spots));
                round += 1;
            } else if best.is_some() {
                high = scales[0];
                round += 1;
            } else if scales[0] > least {
                high = scales[0];
                low = (0.6 * low).max(least * 0.999);
            } else {
                break;
            }
            control.step("packing", round as f32 / 5.0)?;
        }
        match best {
            Some(best) => Ok(best),
            None => match self.pack(sheet, least) {
                Some(spots) => Ok((least, spots)),
                None => Err(self.no_room(sheet, control)?),
            },
        }
    }

    /// The scale below which charts have too few texels to be worth having.
    fn least_scale(&self, sheet: Sheet) -> f64 {
        let texels = f64::from(sheet.size) * f64::from(sheet.size);
        let least = LEAST_TEXELS * self.pieces.len() as f64 / texels;
        self.scale_for(sheet, least)
            .min(0.999 * self.widest_scale(sheet))
    }

    /// The error with the smallest size at which the charts fit.
    fn no_room(&self, sheet: Sheet, control: &Control<'_>) -> Result<AtlasError, AtlasError> {
        let mut size = f64::from(sheet.size);
        let needed = loop {
            control.check()?;
            size = (1.02 * size).max(size + 1.0).floor();
            if size > f64::from(MAX_SIZE) {
                break u64::from(MAX_SIZE) + 1;
            }
            let larger = Sheet::new(size as u32, sheet.fixed.gutter);
            if self.pack(larger, self.least_scale(larger)).is_some() {
                break size as u64;
            }
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
        scale: f64,
        spots: &[Spot],
    ) -> (Vec<AtlasMap>, Vec<u32>, u32) {
        let triangle_count = surface.corners.len();
        let mut maps = vec![bytemuck::Zeroable::zeroed(); triangle_count];
        let mut chart = vec![0; triangle_count];
        for (index, (piece, spot)) in self.pieces.iter().zip(spots).enumerate() {
            for (t, corners) in piece.corners(fixed, spot.turn, scale, spot.shift) {
                maps[t as usize] = fixed.map_of(corners);
                chart[t as usize] = index as u32;
            }
        }
        (maps, chart, self.pieces.len() as u32)
    }
}

/// The chart, or pieces of it if it lies on itself.
fn without_overlaps(surface: &Surface, piece: Piece, fixed: Fixed, scale: f64) -> Vec<FlatChart> {
    let good = piece.flat.triangles.len() == 1 || {
        let footprint = piece.footprint(fixed, piece.upright, scale, 1);
        !footprint.filled.overlaps && !piece.is_folded()
    };
    if good {
        vec![piece.flat]
    } else {
        charts::split(surface, &piece.flat)
    }
}

fn turn_at_random(pieces: &mut [Piece], seed: u64) {
    for (index, piece) in pieces.iter_mut().enumerate() {
        let words = random(
            seed as u32,
            index as u32,
            (seed >> 32) as u32,
            Purpose::Start,
        );
        piece.turn_to(DVec2::from_angle(TAU * f64::from(unit(words[0]))));
    }
}

/// Large charts first, by one measure of size or another.
fn in_order(candidates: &[Vec<Candidate>], measure: usize) -> Vec<u32> {
    let size = |index: &u32| {
        let shape = &candidates[*index as usize][0].shape;
        let size = match measure {
            0 => shape.count,
            1 => shape.width * shape.height,
            _ => shape.width.max(shape.height),
        };
        (std::cmp::Reverse(size), *index)
    };
    let mut order: Vec<u32> = (0..candidates.len() as u32).collect();
    order.sort_by_cached_key(size);
    order
}
