//! `project`: its parameters and bindings. Twin of `shaders/project.comp`.

use glam::UVec2;

use crate::sim::arrays::Arrays;
use crate::sim::food::LEVELS;
use crate::sim::kernels::{Project, ProjectArgs, ProjectConstants, ProjectParams};
use crate::sim::plan::Plan;
use crate::sim::state::State;
use crate::sim::types::Meal;
use crate::sim::work::{Call, StepKernel};

impl Plan<'_> {
    /// Adds to the trail what food projects into it.
    #[must_use]
    pub fn project(&self) -> Call<Project> {
        Call {
            on: (),
            constants: ProjectConstants {
                paths: self.means.paths,
            },
            params: ProjectParams {
                projected_count: self.projected().0,
                pitch: self.setup.atlas.pitch,
                covered: self.settings.feeding.projection_covered,
            },
        }
    }
}

impl StepKernel for Project {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> ProjectArgs<'s> {
        let food = s.food();
        ProjectArgs {
            projected: &food.projected,
            meals: &food.meals,
            deposits: &s.deposits.front,
            trail: &s.trail.front,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        let projected = &a.setup.food_set.projected;
        project(&call.params, projected, &a.meals, &a.deposits, &mut a.trail);
    }
}

/// Adds to the trail on food what remains of its projection, less where particles are.
pub fn project(
    params: &ProjectParams,
    projected: &[UVec2],
    meals: &[Meal],
    deposits: &[u32],
    trail: &mut [f32],
) {
    for entry in &projected[..params.projected_count as usize] {
        let (texel, meal) = (entry.x as usize, &meals[entry.y as usize]);
        let amount = meal.projection * (meal.level as f32 * (1.0 / LEVELS as f32));
        let damped = amount * params.covered;
        let is_damped = params.covered < 1.0 && is_covered(params.pitch, deposits, texel);
        trail[texel] += if is_damped { damped } else { amount };
    }
}

/// Did any particle deposit on the texel in this step, or on the eight around it?
fn is_covered(pitch: u32, deposits: &[u32], texel: usize) -> bool {
    let pitch = pitch as usize;
    let corner = texel - pitch - 1;
    (0..9).any(|k| deposits[corner + (k / 3) * pitch + k % 3] != 0)
}
