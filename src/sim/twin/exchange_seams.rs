//! Twin of `shaders/exchange_seams.comp`.

use crate::sim::types::Seam;

/// Fills the gutter texels of `trail` from the owned texels across the seams.
pub fn exchange_seams(seams: &[Seam], trail: &mut [f32]) {
    for seam in seams {
        let units = seam.units().map(|units| units as f32);
        let mut value = units[0] * trail[seam.source[0] as usize];
        for k in 1..4 {
            value += units[k] * trail[seam.source[k] as usize];
        }
        trail[seam.texel as usize] = value * (1.0 / Seam::UNITS as f32);
    }
}
