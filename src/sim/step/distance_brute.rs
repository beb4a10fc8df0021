//! `distance_brute`: its parameters and bindings. Twin of `shaders/distance_brute.comp`.

use super::distance::{DistanceInputs, candidate_distance, found_by, place_in_other};
use crate::mesh::surface::NONE;
use crate::mesh::trees::nearest::{is_nearer, nearest_on_face};
use crate::sim::arrays::Arrays;
use crate::sim::kernels::{
    DistanceBrute, DistanceBruteArgs, DistanceBruteConstants, DistanceBruteParams,
};
use crate::sim::plan::Plan;
use crate::sim::state::State;
use crate::sim::work::{Call, StepKernel};
use crate::strict::{root, settled};

impl Plan<'_> {
    /// Compares every triangle with every texel.
    pub fn distance_brute(&self) -> Call<DistanceBrute> {
        Call {
            on: (),
            constants: DistanceBruteConstants {
                sign_rule: self.settings.distance.sign as u32,
            },
            params: DistanceBruteParams {
                thread_count: self.distances.thread_count,
                job_count: self.distances.jobs.len() as u32,
                first_vertex_normal: self.first_vertex_normal(),
                reach: self.lengths.reach,
            },
        }
    }
}

impl StepKernel for DistanceBrute {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> DistanceBruteArgs<'s> {
        DistanceBruteArgs {
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
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        distance_brute(
            &call.constants,
            &call.params,
            &DistanceInputs::of(&a.setup, &a.jobs, &a.pairs),
            &mut a.distances,
            &mut a.nearest,
        );
    }
}

/// Signed distance to other objects, by looking at all their triangles.
pub fn distance_brute(
    constants: &DistanceBruteConstants,
    params: &DistanceBruteParams,
    inputs: &DistanceInputs,
    distances: &mut [f32],
    nearest: &mut [u32],
) {
    let sides = inputs.sides(params.first_vertex_normal);
    let one = |i: u32| {
        let (job, here) = inputs.sample_of(params.job_count, i)?;

        let mut least = params.reach;
        let mut triangle = NONE;
        for pair in &inputs.pairs[job.first_pair as usize..][..job.pair_count as usize] {
            let place = place_in_other(pair, here.position);
            let mut square = 3.4e38;
            let mut found = NONE;
            let mut slot = pair.first_face;
            for k in pair.first_face..pair.first_face + pair.face_count {
                let face = &inputs.faces[k as usize];
                let square_there = nearest_on_face(face, place).square;
                if is_nearer(square_there, face.triangle, square, found) {
                    (square, found, slot) = (square_there, face.triangle, k);
                }
            }
            let point = nearest_on_face(&inputs.faces[slot as usize], place);
            let distance = root(point.square);
            let rule = constants.sign_rule;
            let candidate =
                candidate_distance(&sides, rule, pair, slot, place, &point, params.reach);
            if candidate < least {
                least = candidate;
                triangle = if distance < params.reach { found } else { NONE };
            }
        }
        Some((here.texel as usize, least, triangle))
    };
    for (texel, least, triangle) in found_by(params.thread_count, one) {
        distances[texel] = settled(least);
        nearest[texel] = triangle;
    }
}
