//! One simulation step: every dispatch and every barrier, in order, and nothing else.

use super::kernels::{
    AdvanceArgs, DiffuseArgs, DiffuseSeamsArgs, DistanceArgs, DistanceBruteArgs, ExchangeSeamsArgs,
};
use super::params::StepParams;
use super::state::{Kernels, State};
use super::types::{Physarum, Pose};
use crate::gpu::{
    Access::{Copy, Kernel},
    Recorder, Threads,
};
use crate::scene::settings::DistanceMethod;

/// Records a kernel and the barrier behind it, after which the same kernel may come again: that is how one is timed
/// alone.
pub type Record = fn(&mut Recorder, &Kernels, &State, &StepParams);

/// The kernels of a step, in order, by name.
pub const KERNELS: [(&str, Record); 5] = [
    ("distance", distance),
    ("advance", advance),
    ("diffuse", diffuse),
    ("diffuse_seams", diffuse_seams),
    ("exchange_seams", exchange_seams),
];

/// What the host has found to be others than in the step before.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Changes {
    /// World from object, one an object.
    pub poses: Option<Vec<Pose>>,
    /// What particles do, one an object.
    pub physarums: Option<Vec<Physarum>>,
}

/// Records one step, after which the objects are where `changes` say. Each barrier names what
/// it separates; the recorder refuses a dispatch that reads what was written and not yet made visible.
pub fn record(
    rec: &mut Recorder,
    k: &Kernels,
    s: &mut State,
    params: &StepParams,
    changes: &Changes,
) {
    pose(rec, s, changes);
    distance(rec, k, s, params);
    advance(rec, k, s, params);
    if let Some(first_half) = params.first_half() {
        diffuse(rec, k, s, &first_half);
        diffuse_seams(rec, k, s, &first_half);
        s.trail.swap();
    }
    diffuse(rec, k, s, params);
    diffuse_seams(rec, k, s, params);
    exchange_seams(rec, k, s, params);
    s.trail.swap();
    s.deposits.swap();
}

/// Brings the objects to new poses. They travel in the command buffer, so steps recorded earlier keep theirs.
/// What particles do on each object comes the same way.
pub fn pose(rec: &mut Recorder, s: &State, changes: &Changes) {
    // Kernels and pictures before this one have read the old ones; a picture's own barriers end in `Kernel`.
    if let Some(poses) = &changes.poses {
        rec.barrier(Kernel, Copy, &[&s.poses]);
        rec.update_long(&s.poses, poses);
        rec.barrier(Copy, Kernel, &[&s.poses]);
    }
    if let Some(physarums) = &changes.physarums {
        rec.barrier(Kernel, Copy, &[&s.physarums]);
        rec.update_long(&s.physarums, physarums);
        rec.barrier(Copy, Kernel, &[&s.physarums]);
    }
}

/// Where nothing has moved there are no jobs, and nothing is recorded.
fn distance(rec: &mut Recorder, k: &Kernels, s: &State, params: &StepParams) {
    let update = &params.distance_update;
    if update.jobs.is_empty() {
        return;
    }
    rec.update_long(&s.distance_jobs, &update.jobs);
    rec.update_long(&s.distance_pairs, &update.pairs);
    rec.barrier(Copy, Kernel, &[&s.distance_jobs, &s.distance_pairs]);
    match params.distance_method {
        DistanceMethod::Bvh => rec.dispatch(
            &k.distance,
            Threads(update.thread_count),
            DistanceArgs {
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
            params.distance,
        ),
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
    }
    // Gutter texels are filled from those that were written; the next update writes other jobs.
    rec.barrier(Kernel, Kernel, &[&s.distances, &s.nearest]);
    rec.barrier(Kernel, Copy, &[&s.distance_jobs, &s.distance_pairs]);
    rec.dispatch(
        &k.exchange_seams,
        Threads(params.exchange_seams.seam_count),
        ExchangeSeamsArgs {
            seams: &s.seams,
            trail: &s.distances,
        },
        params.exchange_seams,
    );
    // What follows reads distances.
    rec.barrier(Kernel, Kernel, &[&s.distances]);
}

fn advance(rec: &mut Recorder, k: &Kernels, s: &State, params: &StepParams) {
    rec.dispatch(
        &k.advance,
        Threads(params.advance.particle_count),
        AdvanceArgs {
            particles: &s.particles,
            motions: &s.motions,
            triangles: &s.triangles,
            halfedges: &s.halfedges,
            atlas_maps: &s.atlas_maps,
            trail: &s.trail.front,
            previous_deposits: &s.deposits.back,
            deposits: &s.deposits.front,
            corners: &s.corners,
            vertices: &s.vertices,
            poses: &s.poses,
            physarums: &s.physarums,
            distances: &s.distances,
        },
        params.advance,
    );
    // diffuse takes up what advance has deposited and clears what it has read; the next step moves particles on, and
    // takes distances anew.
    rec.barrier(
        Kernel,
        Kernel,
        &[
            &s.deposits.front,
            &s.deposits.back,
            &s.particles,
            &s.motions,
            &s.distances,
        ],
    );
}

fn diffuse(rec: &mut Recorder, k: &Kernels, s: &State, params: &StepParams) {
    rec.dispatch(
        &k.diffuse,
        Threads(params.diffuse.lane_count),
        DiffuseArgs {
            blocks: &s.blocks,
            trail: &s.trail.front_views.quads,
            deposits: &s.deposits.front_views.quads,
            density: &s.density_views.quads,
            next_trail: &s.trail.back.cast(),
            previous_deposits: &s.deposits.back.cast(),
        },
        params.diffuse,
    );
    // diffuse_seams writes some texels over; the next step counts deposits from zero.
    rec.barrier(Kernel, Kernel, &[&s.trail.back, &s.deposits.back]);
}

fn diffuse_seams(rec: &mut Recorder, k: &Kernels, s: &State, params: &StepParams) {
    rec.dispatch(
        &k.diffuse_seams,
        Threads(params.diffuse_seams.row_count),
        DiffuseSeamsArgs {
            rows: &s.exchange_rows,
            entries: &s.exchange_entries,
            trail: &s.trail.front_views.texels,
            deposits: &s.deposits.front_views.texels,
            density: &s.density_views.texels,
            next_trail: &s.trail.back,
        },
        params.diffuse_seams,
    );
    // The gutter is filled from texels that were written here; a second half of the step reads them, and writes over
    // those that were read.
    rec.barrier(Kernel, Kernel, &[&s.trail.back, &s.trail.front]);
}

fn exchange_seams(rec: &mut Recorder, k: &Kernels, s: &State, params: &StepParams) {
    rec.dispatch(
        &k.exchange_seams,
        Threads(params.exchange_seams.seam_count),
        ExchangeSeamsArgs {
            seams: &s.seams,
            trail: &s.trail.back,
        },
        params.exchange_seams,
    );
    // The next step senses the new trail, and writes its own over the old one.
    rec.barrier(Kernel, Kernel, &[&s.trail.back, &s.trail.front]);
}
