//! The part of a step that takes distances between objects, where something has moved.

use super::super::draws::DistanceRasterArgs;
use super::super::kernels::{
    DistanceArgs, DistanceBruteArgs, DistanceMergeArgs, DistanceMergeParams, DistanceTilesArgs,
    ExchangeSeamsArgs, UnfoldArgs,
};
use super::super::params::StepParams;
use super::super::pipelines::Kernels;
use super::super::samples::TILE_SAMPLES;
use super::super::state::State;
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
                DistanceTilesArgs {
                    jobs: &s.distance_jobs,
                    pairs: &s.distance_views.pairs,
                    tiles: &s.tiles,
                    faces: &s.faces,
                    pseudonormals: &s.pseudonormals,
                    corners: &s.corners,
                    hints: &s.hints,
                    nodes: &s.nodes,
                    dipoles: &s.dipoles,
                    candidates: &s.candidates,
                    tile_states: &s.tile_states,
                    listed: &s.listed_tiles,
                    groups: &s.tile_groups,
                    moves: &s.distance_moves,
                    margins: &s.margins,
                },
                params.distance_tiles,
            );
            rec.dispatch_at_most(
                &k.distance,
                Threads(params.distance.tile_count * TILE_SAMPLES),
                (&s.tile_groups, LISTED),
                DistanceArgs {
                    pairs: &s.distance_views.pairs,
                    samples: &s.distance_views.samples,
                    faces: &s.faces,
                    pseudonormals: &s.pseudonormals,
                    corners: &s.corners,
                    distances: &s.distances,
                    nearest: &s.nearest,
                    nodes: &s.nodes,
                    dipoles: &s.dipoles,
                    hints: &s.distance_views.hints,
                    candidates: &s.distance_views.candidates,
                    listed: &s.distance_views.listed,
                    listed_groups: &s.tile_groups,
                    groups: &s.covered_groups,
                    covered: &s.covered,
                    surroundings: &s.surroundings,
                },
                params.distance,
            );
        }
        DistanceMethod::Brute => rec.dispatch(
            &k.distance_brute,
            Threads(update.thread_count),
            DistanceBruteArgs {
                jobs: &s.distance_jobs,
                pairs: &s.distance_pairs,
                samples: &s.samples,
                faces: &s.faces,
                pseudonormals: &s.pseudonormals,
                corners: &s.corners,
                distances: &s.distances,
                nearest: &s.nearest,
                nodes: &s.nodes,
                dipoles: &s.dipoles,
            },
            params.distance_brute,
        ),
        DistanceMethod::Raster => distance_raster(rec, k, s, params),
    }
    rec.dispatch(
        &k.exchange_seams,
        Threads(params.exchange_seams.seam_count),
        ExchangeSeamsArgs {
            seams: &s.seams,
            trail: &s.distance_views.distances,
            low_trail: &s.distance_views.distances,
            high_trail: &s.distance_views.distances,
        },
        params.exchange_seams,
    );
    if params.sees_across {
        unfold(rec, k, s, params);
    }
    if params.distance_method == DistanceMethod::Bvh {}
}

fn unfold(rec: &mut Recorder, k: &Kernels, s: &State, params: &StepParams) {
    let args = UnfoldArgs {
        jobs: &s.distance_jobs,
        pairs: &s.distance_views.pairs,
        samples: &s.distance_views.samples,
        owners: &s.owners,
        distances: &s.distance_views.distances,
        nearest: &s.distance_views.nearest,
        triangles: &s.triangles,
        halfedges: &s.halfedges,
        corners: &s.corners,
        vertices: &s.vertices,
        strips: &s.strips,
        across: &s.across,
        surroundings: &s.surroundings,
        across_triangles: &s.across_triangles,
        listed: &s.distance_views.listed,
        groups: &s.covered_groups,
        covered: &s.distance_views.covered,
    };
    if params.distance_method == DistanceMethod::Bvh {
        rec.dispatch_indirect(&k.unfold, &s.covered_groups, LISTED, args, params.unfold);
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
                        DistanceRasterArgs {
                            outlines: &raster.outlines,
                            bounds: &raster.bounds,
                            slots: &raster.slots,
                            nodes: &s.nodes,
                            places: &raster.places,
                            faces: &s.faces,
                        },
                        draw.params,
                    );
                }
            });
            rec.copy_image(&raster.target, &raster.winners);
        }
        rec.dispatch(
            &k.distance_merge,
            Threads(update.thread_count),
            DistanceMergeArgs {
                jobs: &s.distance_jobs,
                pairs: &s.distance_pairs,
                samples: &s.samples,
                faces: &s.faces,
                pseudonormals: &s.pseudonormals,
                corners: &s.corners,
                distances: &s.distances,
                nearest: &s.nearest,
                nodes: &s.nodes,
                dipoles: &s.dipoles,
                winners: &raster.winners,
            },
            DistanceMergeParams {
                round,
                ..params.distance_merge
            },
        );
    }
}
