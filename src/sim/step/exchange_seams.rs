//! `exchange_seams`: its parameters and bindings. Twin of `shaders/exchange_seams.comp`.

use crate::sim::arrays::Arrays;
use crate::sim::field::fill_gutters;
use crate::sim::kernels::{
    ExchangeSeams, ExchangeSeamsArgs, ExchangeSeamsConstants, ExchangeSeamsParams,
};
use crate::sim::plan::Plan;
use crate::sim::state::State;
use crate::sim::types::Seam;
use crate::sim::work::{Call, StepKernel};

/// The field whose gutters are filled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    /// The new trail.
    Trail,
    /// Distances to other objects.
    Distances,
    /// The scent with what crosses from other objects.
    Scent,
}

impl Plan<'_> {
    /// Fills the gutters of a field, so that sensors see no seam.
    pub fn exchange_seams(&self, of: Field) -> Call<ExchangeSeams> {
        Call {
            on: of,
            constants: ExchangeSeamsConstants {
                paths: self.means.paths,
            },
            params: ExchangeSeamsParams {
                seam_count: self.setup.atlas.seams.len() as u32,
            },
        }
    }
}

impl StepKernel for ExchangeSeams {
    type On = Field;

    fn args<'s>(call: &Call<Self>, s: &'s State) -> ExchangeSeamsArgs<'s> {
        ExchangeSeamsArgs {
            seams: &s.atlas.seams,
            trail: match call.on {
                Field::Trail => &s.trail.back,
                Field::Distances => &s.near.distances,
                Field::Scent => s.food().around(),
            },
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        let field = match call.on {
            Field::Trail => &mut a.next_trail,
            Field::Distances => &mut a.distances,
            Field::Scent => &mut a.around,
        };
        exchange_seams(&a.setup.atlas.seams, field);
    }
}

/// Fills the gutter texels of `trail` from the owned texels across the seams.
pub fn exchange_seams(seams: &[Seam], trail: &mut [f32]) {
    fill_gutters(seams, trail);
}
