//! Twin of `shaders/exchange_seams.comp`.

use crate::sim::types::Seam;

/// Fills the gutter texels of `trail` from the owned texels across the seams.
pub fn exchange_seams(seams: &[Seam], trail: &mut [f32]) {
    for seam in seams {
        let mut value = seam.weight[0] * trail[seam.source[0] as usize];
        for k in 1..4 {
            value += seam.weight[k] * trail[seam.source[k] as usize];
        }
        trail[seam.texel as usize] = value;
    }
}
