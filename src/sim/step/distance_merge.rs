//! `distance_merge`: its parameters and bindings. Twin of `shaders/distance_merge.comp`.

use super::distance::{DistanceInputs, candidate_distance, found_by, place_in_other};
use crate::mesh::surface::NONE;
use crate::mesh::trees::nearest::nearest_on_face;
use crate::sim::arrays::Arrays;
use crate::sim::kernels::{
    DistanceMerge, DistanceMergeArgs, DistanceMergeConstants, DistanceMergeParams,
};
use crate::sim::plan::Plan;
use crate::sim::state::State;
use crate::sim::work::{Call, StepKernel};
use crate::strict::{root, settled};

impl Plan<'_> {
    /// Computes the distances to the faces that a round has drawn.
    pub fn distance_merge(&self, round: u32) -> Call<DistanceMerge> {
        Call {
            on: (),
            constants: DistanceMergeConstants {
                sign_rule: self.settings.distance.sign as u32,
            },
            params: DistanceMergeParams {
                thread_count: self.distances.thread_count,
                job_count: self.distances.jobs.len() as u32,
                first_vertex_normal: self.first_vertex_normal(),
                reach: self.lengths.reach,
                round,
            },
        }
    }
}

impl StepKernel for DistanceMerge {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> DistanceMergeArgs<'s> {
        DistanceMergeArgs {
            jobs: &s.near.jobs,
            pairs: &s.near.pairs,
            samples: &s.near.samples,
            faces: &s.trees.faces,
            pseudonormals: &s.trees.pseudonormals,
            corners: &s.surface.corners,
            distances: &s.near.distances,
            nearest: &s.near.nearest,
            nodes: &s.trees.nodes,
            dipoles: &s.trees.dipoles,
            winners: &s.raster().winners,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        distance_merge(
            &call.constants,
            &call.params,
            &DistanceInputs::of(&a.setup, &a.jobs, &a.pairs),
            &a.winners,
            &mut a.distances,
            &mut a.nearest,
        );
    }
}

/// Signed distance to the faces that were drawn, if it is less than that to earlier objects.
pub fn distance_merge(
    constants: &DistanceMergeConstants,
    params: &DistanceMergeParams,
    inputs: &DistanceInputs,
    winners: &[u32],
    distances: &mut [f32],
    nearest: &mut [u32],
) {
    let sides = inputs.sides(params.first_vertex_normal);
    let one = |i: u32| {
        let (job, here) = inputs.sample_of(params.job_count, i)?;
        let texel = here.texel as usize;

        let (mut least, mut triangle) = if params.round == 0 {
            (params.reach, NONE)
        } else {
            (distances[texel], nearest[texel])
        };
        let winner = if params.round < job.pair_count {
            winners[texel]
        } else {
            0
        };
        if winner != 0 {
            let pair = &inputs.pairs[(job.first_pair + params.round) as usize];
            let place = place_in_other(pair, here.position);
            let slot = winner - 1;
            let face = &inputs.faces[slot as usize];
            let point = nearest_on_face(face, place);
            let distance = root(point.square);
            let rule = constants.sign_rule;
            let candidate =
                candidate_distance(&sides, rule, pair, slot, place, &point, params.reach);
            if candidate < least {
                least = candidate;
                triangle = if distance < params.reach {
                    face.triangle
                } else {
                    NONE
                };
            }
        }
        Some((texel, least, triangle))
    };
    for (texel, least, triangle) in found_by(params.thread_count, one) {
        distances[texel] = settled(least);
        nearest[texel] = triangle;
    }
}
