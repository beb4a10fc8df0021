//! Twin of `shaders/distance_merge.comp`.

use super::distance::{DistanceInputs, candidate_distance, job_of, place_in_other};
use crate::mesh::surface::NONE;
use crate::mesh::trees::nearest::nearest_on_face;
use crate::sim::kernels::{DistanceMergeConstants, DistanceMergeParams};

/// Signed distance to the faces that were drawn, where it is less than that to the objects before.
pub fn distance_merge(
    constants: &DistanceMergeConstants,
    params: &DistanceMergeParams,
    inputs: &DistanceInputs,
    winners: &[u32],
    distances: &mut [f32],
    nearest: &mut [u32],
) {
    let sides = inputs.sides(params.first_vertex_normal);
    for i in 0..params.thread_count {
        let job = inputs.jobs[job_of(&inputs.jobs[..params.job_count as usize], i)];
        if i - job.first_thread >= job.sample_count {
            continue;
        }
        let here = inputs.samples[(job.first_sample + (i - job.first_thread)) as usize];
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
            let distance = point.square.sqrt();
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
        distances[texel] = least;
        nearest[texel] = triangle;
    }
}
