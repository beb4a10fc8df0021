//! `digest`: its parameters and bindings. Twin of `shaders/digest.comp`.

use crate::gpu::Kernel as _;
use crate::sim::arrays::Arrays;
use crate::sim::kernels::{Digest, DigestArgs, DigestParams, Scent};
use crate::sim::plan::Plan;
use crate::sim::state::State;
use crate::sim::types::Meal;
use crate::sim::work::{Call, StepKernel};

impl Plan<'_> {
    /// Subtracts the eaten meals.
    #[must_use]
    pub fn digest(&self) -> Call<Digest> {
        let food_set = &self.setup.food_set;
        Call {
            on: (),
            constants: (),
            params: DigestParams {
                food_count: food_set.places.len() as u32,
                scented_count: food_set.scented_count(),
                scent_group: Scent::GROUP_SIZE,
            },
        }
    }
}

impl StepKernel for Digest {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> DigestArgs<'s> {
        let food = s.food();
        DigestArgs {
            meals: &food.meals,
            groups: &food.groups,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        a.scent_is_due = digest(&call.params, &mut a.meals);
    }
}

/// Subtracts from each food the eaten meals. Returns whether any scent has changed: then [`super::scent`] is due.
pub fn digest(params: &DigestParams, meals: &mut [Meal]) -> bool {
    let mut is_due = false;
    for meal in &mut meals[..params.food_count as usize] {
        let eaten = std::mem::take(&mut meal.eaten);
        if meal.amount == 0 || eaten == 0 {
            continue;
        }
        meal.remaining = meal.remaining.saturating_sub(eaten);
        let level = meal.level;
        meal.smell();
        is_due |= meal.level != level;
    }
    is_due
}
