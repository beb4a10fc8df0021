//! Food in the simulation by twins.

use super::{Simulation, digest, scent};
use crate::error::Result;
use crate::gpu::Kernel as _;
use crate::mesh::atlas::Control;
use crate::scene::settings::Settings;
use crate::sim::food::{Pantry, places};
use crate::sim::kernels::{DigestParams, Scent, ScentParams};
use crate::sim::params::StepConstants;

impl Simulation {
    /// What was eaten in a step is taken away.
    pub(super) fn feed(&mut self, constants: &StepConstants) {
        self.fed_deposit = self.settings.feeding.fed_deposit;
        if constants.scent.is_none() {
            return;
        }
        let params = DigestParams {
            food_count: self.meals.len() as u32,
            scented_count: self.setup.pantry.scented_count(),
            scent_group: Scent::GROUP_SIZE,
        };
        if digest(&params, &mut self.meals) {
            self.smell();
        }
    }

    /// Of each food there is so much from now on, or all of it.
    pub(super) fn serve(&mut self, remaining: Option<&[u32]>) {
        self.meals = self.setup.pantry.meals(remaining);
        self.scent = vec![0.0; self.setup.pantry.plates.len()];
        self.smell();
    }

    /// Sums up what sensors read of food and markers.
    fn smell(&mut self) {
        let Pantry {
            scented, whiffs, ..
        } = &self.setup.pantry;
        let params = ScentParams {
            scented_count: self.setup.pantry.scented_count(),
        };
        scent(&params, scented, whiffs, &self.meals, &mut self.scent);
    }

    /// Takes over settings with other food; as [`crate::sim::Simulation::apply`].
    ///
    /// # Errors
    /// When a food lies off its object, or they reach too many texels.
    pub fn put_food(&mut self, settings: &Settings) -> Result<()> {
        let setup = &self.setup;
        let places = places(settings, &setup.surface, &setup.origins, setup.radius)?;
        let pantry = Pantry::new(
            &setup.surface,
            &setup.atlas,
            places,
            Some(&setup.pantry),
            &Control::default(),
        )?;
        let left: Vec<u32> = self.meals.iter().map(|meal| meal.remaining).collect();
        let left = pantry.kept(&setup.pantry, &left);
        self.setup.pantry = pantry;
        self.settings = settings.clone();
        self.serve(Some(&left));
        Ok(())
    }
}
