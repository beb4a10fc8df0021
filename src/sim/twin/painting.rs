//! Brushes on the simulation by twins.

use glam::UVec2;

use super::{Simulation, exchange_seams, paint, teleport};
use crate::error::Result;
use crate::sim::paint::{Dab, Painted, Places};

impl Simulation {
    /// One dab of a brush; as [`crate::sim::Simulation::paint`].
    ///
    /// # Errors
    /// When a number of the dab is out of its range, or it has too many texels.
    pub fn paint(&mut self, dab: &Dab) -> Result<Painted> {
        let settings = &self.course.settings;
        let a = &mut self.arrays;
        let texels = dab.texels(&a.setup, &a.poses)?;
        let painted = Painted::of(&texels, a.poses.len());
        if texels.is_empty() {
            return Ok(painted);
        }
        if dab.makes_bias() && a.bias.is_empty() {
            a.bias = vec![0.0; a.trail.len()];
        }
        if dab.makes_looks() && a.weights.is_empty() {
            a.weights = vec![0.0; a.trail.len()];
        }
        let count = texels.len() as u32;
        let entries: Vec<UVec2> = (texels.iter())
            .map(|texel| UVec2::new(texel.texel, texel.weight.to_bits()))
            .collect();
        if let Some(params) = dab.of_trail(count) {
            paint(&params, &entries, &mut a.trail);
            exchange_seams(&a.setup.atlas.seams, &mut a.trail);
        }
        if let Some(params) = dab.of_bias(count).filter(|_| !a.bias.is_empty()) {
            paint(&params, &entries, &mut a.bias);
            exchange_seams(&a.setup.atlas.seams, &mut a.bias);
        }
        if let Some(params) = dab.of_looks(count).filter(|_| !a.weights.is_empty()) {
            paint(&params, &entries, &mut a.weights);
            exchange_seams(&a.setup.atlas.seams, &mut a.weights);
        }
        if let Some(params) = dab.of_particles(settings) {
            let Places { places, ranges } = dab.places(&a.setup, &texels, settings.seed);
            teleport(
                &params,
                &places,
                &ranges,
                &a.setup.surface.triangles,
                &mut a.particles,
                &mut a.motions,
            );
        }
        Ok(painted)
    }
}
