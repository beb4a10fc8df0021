//! Twin of `shaders/distance_tiles.comp`: which faces of other objects are near tiles of samples.

use super::bvh::{UNLIMITED, is_in_box, nearest_on, slack_of};
use super::distance::{
    DistanceInputs, TILE_INSIDE, TILE_OUTSIDE, TILE_UNKNOWN, job_of, place_in_other,
};
use super::nearest::nearest_on_face;
use super::sign::is_outside;
use crate::mesh::surface::NONE;
use crate::scene::settings::SignRule;
use crate::sim::distance::TILE_SAMPLES;
use crate::sim::kernels::{DistanceTilesConstants, DistanceTilesParams};

/// The hints of all tiles of the jobs.
#[must_use]
pub fn distance_tiles(
    constants: &DistanceTilesConstants,
    params: &DistanceTilesParams,
    inputs: &DistanceInputs,
) -> Vec<u32> {
    let sides = inputs.sides(params.first_vertex_normal);
    let mut hints = vec![0; (params.tile_count * params.hint_count) as usize];
    for i in 0..params.tile_count {
        let jobs = &inputs.jobs[..params.job_count as usize];
        let job = jobs[job_of(jobs, i * TILE_SAMPLES)];
        let in_job = i - job.first_thread / TILE_SAMPLES;
        if in_job * TILE_SAMPLES >= job.sample_count {
            continue;
        }
        let tile = inputs.tiles[(job.first_tile + in_job) as usize];
        let near = params.reach + tile.radius;

        for p in 0..job.pair_count.min(params.hint_count) {
            let pair = &inputs.pairs[(job.first_pair + p) as usize];
            let place = place_in_other(pair, tile.center);
            let is_closed = pair.is_closed == 1;
            let decides = constants.sign_rule == SignRule::Pseudonormal as u32 || !is_closed;
            let may_be_inside = is_closed && is_in_box(inputs.nodes, pair.first_node, place);
            let reach = if may_be_inside { UNLIMITED } else { near };
            let slot = nearest_on(inputs.nodes, inputs.faces, pair.first_node, place, reach);
            let mut hint = if decides { TILE_OUTSIDE } else { TILE_UNKNOWN };
            if slot != NONE {
                let point = nearest_on_face(&inputs.faces[slot as usize], place);
                let distance = point.square.sqrt();
                let slack = slack_of(&inputs.nodes[pair.first_node as usize]);
                let beyond = near + slack;
                let searches = distance <= beyond || !decides;
                let outside = || {
                    let (rule, root) = (constants.sign_rule, pair.first_node);
                    is_outside(&sides, rule, root, slot, place, &point)
                };
                hint = if searches {
                    slot
                } else if is_closed && !outside() {
                    TILE_INSIDE
                } else {
                    TILE_OUTSIDE
                };
            }
            hints[(i * params.hint_count + p) as usize] = hint;
        }
    }
    hints
}
