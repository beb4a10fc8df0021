//! Twin of `shaders/exchange_seams.comp`.

use crate::sim::field::fill_gutters;
use crate::sim::types::Seam;

/// Fills the gutter texels of `trail` from the owned texels across the seams.
pub fn exchange_seams(seams: &[Seam], trail: &mut [f32]) {
    fill_gutters(seams, trail);
}
