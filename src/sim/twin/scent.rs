//! Twin of `shaders/scent.comp`.

use glam::UVec2;

use crate::sim::food::scent_at;
use crate::sim::kernels::ScentParams;
use crate::sim::types::Meal;

/// Sums up what sensors read more for food and markers, at every texel that any reaches.
pub fn scent(
    params: &ScentParams,
    scented: &[UVec2],
    whiffs: &[UVec2],
    meals: &[Meal],
    field: &mut [f32],
) {
    for i in 0..params.scented_count as usize {
        let here = &whiffs[scented[i].y as usize..scented[i + 1].y as usize];
        field[scented[i].x as usize] = scent_at(here, meals);
    }
}
