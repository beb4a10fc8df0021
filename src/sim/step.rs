//! One simulation step: every dispatch and every barrier, in order, and nothing else.

use super::kernels::{AdvanceArgs, DiffuseArgs, DiffuseSeamsArgs, ExchangeSeamsArgs};
use super::params::StepParams;
use super::state::{Kernels, State};
use super::types::Pose;
use crate::gpu::{
    Access::{Copy, Kernel},
    Recorder, Threads,
};

/// As many as fit an update.
const POSES_AN_UPDATE: usize = 65_536 / size_of::<Pose>();

/// Records a kernel and the barrier behind it, after which the same kernel may come again: that is how one is timed
/// alone.
pub type Record = fn(&mut Recorder, &Kernels, &State, &StepParams);

/// The kernels of a step, in order, by name.
pub const KERNELS: [(&str, Record); 4] = [
    ("advance", advance),
    ("diffuse", diffuse),
    ("diffuse_seams", diffuse_seams),
    ("exchange_seams", exchange_seams),
];

/// Records one step, after which the objects are where `moved` says, if they have moved. Each barrier names what it separates; the recorder refuses a dispatch that reads what was
/// written and not yet made visible.
pub fn record(
    rec: &mut Recorder,
    k: &Kernels,
    s: &mut State,
    params: &StepParams,
    moved: Option<&[Pose]>,
) {
    if let Some(poses) = moved {
        pose(rec, s, poses);
    }
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
pub fn pose(rec: &mut Recorder, s: &State, poses: &[Pose]) {
    // Kernels and pictures before this one have read the old ones; a picture's own barriers end in `Kernel`.
    rec.barrier(Kernel, Copy, &[&s.poses]);
    for (i, part) in poses.chunks(POSES_AN_UPDATE).enumerate() {
        if i > 0 {
            rec.barrier(Copy, Copy, &[&s.poses]);
        }
        rec.update(&s.poses, i * POSES_AN_UPDATE, part);
    }
    rec.barrier(Copy, Kernel, &[&s.poses]);
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
        },
        params.advance,
    );
    // diffuse takes up what advance has deposited and clears what it has read; the next step moves particles on.
    rec.barrier(
        Kernel,
        Kernel,
        &[
            &s.deposits.front,
            &s.deposits.back,
            &s.particles,
            &s.motions,
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
