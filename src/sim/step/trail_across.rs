//! `trail_across`: its parameters and bindings. Twin of `shaders/trail_across.comp`.

use crate::mesh::surface::NONE;
use crate::sim::arrays::Arrays;
use crate::sim::field::{blend_at, unpacked_position};
use crate::sim::kernels::{TrailAcross, TrailAcrossArgs, TrailAcrossConstants, TrailAcrossParams};
use crate::sim::plan::Plan;
use crate::sim::state::State;
use crate::sim::types::SurfaceSample;
use crate::sim::work::{Call, StepKernel};
use crate::strict::{reciprocal, settled};

impl Plan<'_> {
    /// Brings the trail of other objects to texels that they cover, from where it spreads over the line in which two surfaces meet.
    #[must_use]
    pub fn trail_across(&self) -> Call<TrailAcross> {
        Call {
            on: (),
            constants: TrailAcrossConstants {
                paths: self.means.paths,
            },
            params: TrailAcrossParams {
                sample_count: self.samples().0,
                pitch: self.setup.atlas.pitch,
                threshold: self.lengths.threshold,
                deepest: self.lengths.deepest,
            },
        }
    }
}

impl StepKernel for TrailAcross {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> TrailAcrossArgs<'s> {
        TrailAcrossArgs {
            samples: &s.near.samples.texels,
            distances: &s.near.distances.texels,
            across: &s.across.places.texels,
            trail: &s.trail.front,
            density: &s.atlas.spread.density,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        let inputs = TrailAcrossInputs {
            samples: &a.setup.distance.samples,
            distances: &a.distances,
            across: &a.across,
            density: &a.setup.atlas.density,
        };
        trail_across(&call.params, &inputs, &mut a.trail);
    }
}

/// Inputs of `trail_across`.
#[derive(Clone, Copy)]
pub struct TrailAcrossInputs<'a> {
    /// Surface points under texels.
    pub samples: &'a [SurfaceSample],
    /// Signed distance to other objects.
    pub distances: &'a [f32],
    /// The place on another object where walks continue.
    pub across: &'a [u32],
    /// Mean texel area by each texel's own; 0 where no triangle owns it.
    pub density: &'a [f32],
}

/// Gives covered texels the trail of their places on the other object.
pub fn trail_across(params: &TrailAcrossParams, inputs: &TrailAcrossInputs<'_>, trail: &mut [f32]) {
    for sample in &inputs.samples[..params.sample_count as usize] {
        let texel = sample.texel as usize;
        let (distance, place) = (inputs.distances[texel], inputs.across[texel]);
        let is_covered = params.deepest < distance && distance < params.threshold;
        if !is_covered || place == NONE {
            continue;
        }
        if let Some(value) = trail_at_open(params, inputs, trail, place) {
            trail[texel] = value;
        }
    }
}

/// The trail between the four texels round a place, as far as they are owned and nothing covers them; none where no texel is so.
fn trail_at_open(
    params: &TrailAcrossParams,
    inputs: &TrailAcrossInputs<'_>,
    trail: &[f32],
    place: u32,
) -> Option<f32> {
    let (first, way) = blend_at(unpacked_position(place, params.pitch), params.pitch);
    let below = first + params.pitch as usize;
    let texels = [first, first + 1, below, below + 1];
    let open = texels
        .map(|texel| inputs.density[texel] > 0.0 && inputs.distances[texel] >= params.threshold);
    let rest = way.map(|way| 1.0 - way);
    let weights = [
        rest[0] * rest[1],
        way[0] * rest[1],
        rest[0] * way[1],
        way[0] * way[1],
    ];
    let weights = [0, 1, 2, 3].map(|k| if open[k] { weights[k] } else { 0.0 });
    let values = [0, 1, 2, 3].map(|k| if open[k] { trail[texels[k]] } else { 0.0 });
    let total = (weights[0] + weights[1]) + (weights[2] + weights[3]);
    // No weight of an open texel is 0: places are the middles of parts of texels.
    let base = values[open.iter().position(|&open| open)?];
    let more = [0, 1, 2, 3].map(|k| weights[k] * (values[k] - base));
    let sum = (more[0] + more[1]) + (more[2] + more[3]);
    Some(settled(base + sum * reciprocal(total)))
}
