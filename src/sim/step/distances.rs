//! The part of a step that takes distances between objects, where something has moved.

use super::super::kernels::DistanceMergeParams;
use super::super::params::StepParams;
use super::super::pipelines::Kernels;
use super::super::samples::TILE_SAMPLES;
use super::super::state::State;
use super::arguments;
use crate::gpu::{DispatchGroups, Recorder, Threads};
use crate::scene::settings::DistanceMethod;

/// Which of the groups of a list are those of the kernel that works on it.
const LISTED: usize = 0;

/// They, and how many entries they are, while none is listed.
const NONE_LISTED: [DispatchGroups; 2] = [
    DispatchGroups { x: 0, y: 1, z: 1 },
    DispatchGroups { x: 0, y: 0, z: 0 },
];

/// Where nothing has moved there are no jobs, and nothing is recorded.
pub(super) fn distance(rec: &mut Recorder, k: &Kernels, s: &State, params: &StepParams) {
    let update = &params.distance_update;
    if update.jobs.is_empty() {
        return;
    }
    rec.update_long(&s.distance_jobs, &update.jobs);
    rec.update_long(&s.distance_pairs, &update.pairs);
    rec.update_long(&s.distance_moves, &update.moves);
    match params.distance_method {
        DistanceMethod::Bvh => {
            rec.update_long(&s.tile_groups, &NONE_LISTED);
            rec.update_long(&s.covered_groups, &NONE_LISTED);
            rec.dispatch(
                &k.distance_tiles,
                Threads(params.distance_tiles.tile_count),
                arguments::distance_tiles(s),
                params.distance_tiles,
            );
            rec.dispatch_at_most(
                &k.distance,
                Threads(params.distance.tile_count * TILE_SAMPLES),
                (&s.tile_groups, LISTED),
                arguments::distance(s),
                params.distance,
            );
        }
        DistanceMethod::Brute => rec.dispatch(
            &k.distance_brute,
            Threads(update.thread_count),
            arguments::distance_brute(s),
            params.distance_brute,
        ),
        DistanceMethod::Raster => distance_raster(rec, k, s, params),
    }
    // Gutters are filled, as those of the trail are.
    let seams = Threads(params.exchange_seams.seam_count);
    let distances = arguments::exchange_distances(s);
    rec.dispatch(&k.exchange_seams, seams, distances, params.exchange_seams);
    if params.sees_across {
        unfold(rec, k, s, params);
    }
}

fn unfold(rec: &mut Recorder, k: &Kernels, s: &State, params: &StepParams) {
    let args = arguments::unfold(s);
    if params.distance_method == DistanceMethod::Bvh {
        let covered = (&s.covered_groups, LISTED);
        rec.dispatch_indirect(&k.unfold, covered, args, params.unfold);
    } else {
        let threads = Threads(params.unfold.thread_count);
        rec.dispatch(&k.unfold, threads, args, params.unfold);
    }
}

/// In each round every job has one of its pairs: what is nearest on the other object is drawn, and counts if it is less
/// far than those of the rounds before.
fn distance_raster(rec: &mut Recorder, k: &Kernels, s: &State, params: &StepParams) {
    let update = &params.distance_update;
    let (Some(raster), Some(pipeline)) = (&s.raster, &k.distance_raster) else {
        unreachable!("both are there while the method is");
    };
    for round in 0..update.rounds() {
        let draws = raster
            .ranges
            .draws(update, round, params.distance_merge.reach);
        if !draws.is_empty() {
            rec.pass_as_kernel("distance_raster", &raster.targets(), |pass| {
                for draw in &draws {
                    pass.draw(
                        pipeline,
                        draw.vertices,
                        draw.instances,
                        arguments::distance_raster(s, raster),
                        draw.params,
                    );
                }
            });
            rec.copy_image(&raster.target, &raster.winners);
        }
        rec.dispatch(
            &k.distance_merge,
            Threads(update.thread_count),
            arguments::distance_merge(s, raster),
            DistanceMergeParams {
                round,
                ..params.distance_merge
            },
        );
    }
}
