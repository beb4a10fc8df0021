//! Twin of `shaders/distance_brute.comp`.

use super::distance::{DistanceInputs, job_of, place_in_other};
use super::nearest::{nearest_on_face, outside_by_pseudonormal};
use crate::mesh::surface::NONE;
use crate::sim::kernels::DistanceBruteParams;

/// Signed distance to other objects, by looking at every triangle of theirs.
pub fn distance_brute(
    params: &DistanceBruteParams,
    inputs: &DistanceInputs,
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

        let mut least = params.reach;
        let mut triangle = NONE;
        for pair in &inputs.pairs[job.first_pair as usize..][..job.pair_count as usize] {
            let place = place_in_other(pair, here.position);
            let mut square = 3.4e38;
            let mut slot = pair.first_face;
            for candidate_slot in pair.first_face..pair.first_face + pair.face_count {
                let candidate =
                    nearest_on_face(&inputs.faces[candidate_slot as usize], place).square;
                if candidate < square {
                    (slot, square) = (candidate_slot, candidate);
                }
            }
            let feature = nearest_on_face(&inputs.faces[slot as usize], place).feature;
            let outside = outside_by_pseudonormal(&sides, slot, place, feature);
            let distance = square.sqrt();
            let within = distance < params.reach;
            let clamped = if within { distance } else { params.reach };
            let signed_distance = if outside || !(within || pair.is_closed == 1) {
                clamped
            } else {
                -clamped
            };
            if signed_distance < least {
                least = signed_distance;
                triangle = if within {
                    inputs.faces[slot as usize].triangle
                } else {
                    NONE
                };
            }
        }
        distances[here.texel as usize] = least;
        nearest[here.texel as usize] = triangle;
    }
}
