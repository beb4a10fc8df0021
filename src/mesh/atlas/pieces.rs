//! Preparing charts for packing: weights are applied, and charts that overlap themselves are cut.

use std::f64::consts::TAU;

use rayon::prelude::*;

use super::super::surface::Surface;
use super::fixed::Fixed;
use super::flat::FlatChart;
use super::nearness::is_near_itself;
use super::piece::Piece;
use super::{AtlasError, AtlasOptions, Control, charts};
use crate::portable::direction;
use crate::rng::{Purpose, random, unit};

/// The least share of the texture that triangles will fill; whether charts are near themselves is tested at that scale.
const FULL: f64 = 0.55;

/// Pieces that neither overlap themselves nor are folded.
pub(super) fn prepared(
    surface: &Surface,
    flat: Vec<FlatChart>,
    options: &AtlasOptions,
    control: &Control<'_>,
) -> Result<Vec<Piece>, AtlasError> {
    let fixed = Fixed::new(options.size, options.gutter);
    let to_piece = |flat: FlatChart| {
        let weight = match options.weights.get(flat.object as usize) {
            Some(&weight) if weight > 0.0 && weight.is_finite() => f64::from(weight).sqrt(),
            _ => 1.0,
        };
        Piece::new(surface, flat, weight)
    };
    let mut pieces: Vec<Piece> = flat.into_par_iter().map(to_piece).collect();
    loop {
        control.check()?;
        let area: f64 = pieces.iter().map(Piece::area).sum();
        let side = f64::from(options.size);
        let scale = side * (FULL / area).sqrt();
        let apart: Vec<Vec<FlatChart>> = pieces
            .into_par_iter()
            .map(|piece| {
                // A chart that is far too long will be packed much smaller.
                let scale = scale.min(side / piece.extent.max_element());
                if is_sound(&piece, fixed, scale) {
                    vec![piece.flat]
                } else {
                    charts::split(surface, &piece.flat)
                }
            })
            .collect();
        let done = apart.iter().all(|parts| parts.len() == 1);
        pieces = apart.into_par_iter().flatten().map(to_piece).collect();
        if done {
            break;
        }
    }
    if options.turn != 0 {
        turn_at_random(&mut pieces, options.turn);
    }
    Ok(pieces)
}

/// Is no part of a chart on another one, or so near that they would share gutter?
fn is_sound(piece: &Piece, fixed: Fixed, scale: f64) -> bool {
    if piece.flat.triangles.len() == 1 {
        return true;
    }
    let footprint = piece.footprint(fixed, piece.upright, scale, 1);
    !footprint.filled.overlaps
        && !piece.is_folded()
        && !is_near_itself(&footprint.edges, &piece.loops, fixed)
}

fn turn_at_random(pieces: &mut [Piece], seed: u64) {
    for (index, piece) in pieces.iter_mut().enumerate() {
        let words = random(
            seed as u32,
            index as u32,
            (seed >> 32) as u32,
            Purpose::Start,
        );
        piece.turn_to(direction(TAU * f64::from(unit(words[0]))));
    }
}
