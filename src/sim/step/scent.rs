//! `scent`: its parameters and bindings. Twin of `shaders/scent.comp`.

use glam::UVec2;

use crate::sim::arrays::Arrays;
use crate::sim::food::{FoodSet, scent_at};
use crate::sim::kernels::{Scent, ScentArgs, ScentConstants, ScentParams};
use crate::sim::plan::Plan;
use crate::sim::state::State;
use crate::sim::types::Meal;
use crate::sim::work::{Call, StepKernel};

impl Plan<'_> {
    /// Sums up the scents of food and markers.
    #[must_use]
    pub fn scent(&self) -> Call<Scent> {
        Call {
            on: (),
            constants: ScentConstants {
                paths: self.means.paths,
            },
            params: ScentParams {
                scented_count: self.setup.food_set.scented_count(),
            },
        }
    }
}

impl StepKernel for Scent {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> ScentArgs<'s> {
        let food = s.food();
        ScentArgs {
            scented: &food.scented,
            falloffs: &food.falloffs,
            meals: &food.meals,
            field: &food.scent,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        if a.scent_is_due {
            let FoodSet {
                scented, falloffs, ..
            } = &a.setup.food_set;
            scent(&call.params, scented, falloffs, &a.meals, &mut a.scent);
        }
    }
}

/// Sums up the scents of food and markers, at every texel that any reaches.
pub fn scent(
    params: &ScentParams,
    scented: &[UVec2],
    falloffs: &[UVec2],
    meals: &[Meal],
    field: &mut [f32],
) {
    for i in 0..params.scented_count as usize {
        let here = &falloffs[scented[i].y as usize..scented[i + 1].y as usize];
        field[scented[i].x as usize] = scent_at(here, meals);
    }
}
