//! Brushes on the simulation by twins.

use glam::UVec2;

use super::{Simulation, exchange_seams, paint, summon};
use crate::error::Result;
use crate::sim::paint::{Dab, Painted, Places};

impl Simulation {
    /// One dab of a brush; as [`crate::sim::Simulation::paint`].
    ///
    /// # Errors
    /// When a number of the dab is out of its range, or it has too many texels.
    pub fn paint(&mut self, dab: &Dab) -> Result<Painted> {
        let texels = dab.texels(&self.setup, &self.poses)?;
        let painted = Painted::of(&texels, self.poses.len());
        if texels.is_empty() {
            return Ok(painted);
        }
        if dab.makes_bias() && self.bias.is_empty() {
            self.bias = vec![0.0; self.trail.len()];
        }
        let count = texels.len() as u32;
        let entries: Vec<UVec2> = (texels.iter())
            .map(|texel| UVec2::new(texel.texel, texel.weight.to_bits()))
            .collect();
        if let Some(params) = dab.of_trail(count) {
            paint(&params, &entries, &mut self.trail);
            exchange_seams(&self.setup.atlas.seams, &mut self.trail);
        }
        if let Some(params) = dab.of_bias(count).filter(|_| !self.bias.is_empty()) {
            paint(&params, &entries, &mut self.bias);
            exchange_seams(&self.setup.atlas.seams, &mut self.bias);
        }
        if let Some(params) = dab.of_particles(&self.settings) {
            let Places { places, ranges } = dab.places(&self.setup, &texels, self.settings.seed);
            summon(
                &params,
                &places,
                &ranges,
                &self.setup.surface.triangles,
                &mut self.particles,
                &mut self.motions,
            );
        }
        Ok(painted)
    }
}
