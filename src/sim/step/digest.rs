//! `digest`: what it takes, reads and writes. Twin of `shaders/digest.comp`.

use crate::gpu::Kernel as _;
use crate::sim::arrays::Arrays;
use crate::sim::kernels::DigestParams;
use crate::sim::kernels::{Digest, DigestArgs, Scent};
use crate::sim::plan::Plan;
use crate::sim::state::State;
use crate::sim::types::Meal;
use crate::sim::work::{Call, StepKernel};

impl Plan<'_> {
    /// Takes away what was eaten.
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

/// Takes from each food what was eaten of it. Says whether the smell of any has become another: then [`super::scent`] is
/// due.
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
