//! Twin of `shaders/paint.comp`.

use crate::sim::TINY_TRAIL;
use crate::sim::kernels::PaintParams;
use crate::strict::within;
use glam::UVec2;

/// One dab of a brush on a field; the dab is texels and the bits of their weights.
pub fn paint(params: &PaintParams, dab: &[UVec2], field: &mut [f32]) {
    for entry in &dab[..params.texel_count as usize] {
        let texel = entry.x as usize;
        let weight = f32::from_bits(entry.y);
        let before = field[texel];
        let kept = before * (1.0 - params.fade * weight);
        let is_freed = before < params.no_go && params.fade > 0.0;
        let value = if is_freed { 0.0 } else { kept } + params.amount * weight;
        let value = within(value, params.lowest, params.highest.max(before));
        field[texel] = if value.abs() < TINY_TRAIL { 0.0 } else { value };
    }
}
