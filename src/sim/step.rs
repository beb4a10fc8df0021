//! One simulation step, as a script: a line a kernel, in order. What each reads and writes stands in `arguments`; the barriers
//! between them follow from that, and the recorder records them.

mod arguments;
mod distances;
mod feeding;
mod sorting;

use super::params::StepParams;
use super::pipelines::Kernels;
use super::state::State;
use super::turns::Turn;
use super::types::{Physarum, Pose};
use crate::gpu::{DispatchGroups, Recorder, Threads};
use crate::scene::settings::Strategy;

use distances::distance;
use feeding::feed;
use sorting::sort;

/// Which groups an indirect dispatch takes: one invocation a transfer, or one a particle of the window.
const TRANSFERS: usize = 0;
const WINDOW: usize = 1;

/// Which groups the particles take that advance has listed.
const WALKING: usize = 0;
const NEARBY: usize = 1;
const WALKING_NEARBY: usize = 2;

/// What the host has found to be others than in the step before.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Changes {
    /// World from object, one an object.
    pub poses: Option<Vec<Pose>>,
    /// The same in the step before this one.
    pub poses_before: Option<Vec<Pose>>,
    /// What particles do, one an object.
    pub physarums: Option<Vec<Physarum>>,
}

/// Records one step, after which the objects are where `changes` say.
pub fn record(
    rec: &mut Recorder,
    k: &Kernels,
    s: &mut State,
    params: &StepParams,
    changes: &Changes,
) {
    pose(rec, s, changes);
    distance(rec, k, s, params);
    walk_and_change_objects(rec, k, s, &params.turn);
    feed(rec, k, s);
    if let Some(first_half) = params.first_half() {
        diffuse(rec, k, s, &first_half);
        s.trail.swap();
    }
    diffuse(rec, k, s, params);
    // Gutters are filled, so that the next step's sensors see no seam.
    let seams = Threads(params.exchange_seams.seam_count);
    let trail = arguments::exchange_seams(s);
    rec.dispatch(&k.exchange_seams, seams, trail, params.exchange_seams);
    s.trail.swap();
    s.deposits.swap();
    if let Some(params) = &params.sort {
        sort(rec, k, s, params);
    }
}

/// Brings the objects to new poses. They travel in the command buffer, so steps recorded earlier keep theirs.
/// What particles do on each object comes the same way.
pub fn pose(rec: &mut Recorder, s: &State, changes: &Changes) {
    if let Some(poses) = &changes.poses {
        rec.update_long(&s.poses, poses);
    }
    if let Some(poses) = &changes.poses_before {
        rec.update_long(&s.poses_before, poses);
    }
    if let Some(physarums) = &changes.physarums {
        rec.update_long(&s.physarums, physarums);
    }
}

/// Every particle advances once. Those that go into another object change to it, as the strategy says.
fn walk_and_change_objects(rec: &mut Recorder, k: &Kernels, s: &mut State, all: &Turn) {
    match all.strategy {
        Strategy::None => advance(rec, k, s, all),
        Strategy::Respawn => {
            advance(rec, k, s, all);
            move_border(rec, k, s, all);
            let selected = (&s.transfers.groups, TRANSFERS);
            rec.dispatch_indirect(&k.respawn, selected, arguments::respawn(s), all.respawn);
        }
        Strategy::Direct => {
            advance(rec, k, s, all);
            move_border(rec, k, s, all);
            transfer_out(rec, k, s, all);
            s.transfers.swap();
            transfer_in(rec, k, s, all);
        }
        Strategy::Scattered | Strategy::Sequential | Strategy::Parallel => {
            for turn in (0..all.count).map(|object| all.of(object)) {
                transfer_in(rec, k, s, &turn);
                advance(rec, k, s, &turn);
                move_border(rec, k, s, &turn);
                transfer_out(rec, k, s, &turn);
                defragment(rec, k, s, &turn);
                s.transfers.swap();
            }
        }
    }
}

/// Where sensors read straight ahead in the atlas, those particles come in a second dispatch whose sensors must walk; those
/// that may have to do with another object come in a third, or in a fourth, if their sensors must walk, too.
fn advance(rec: &mut Recorder, k: &Kernels, s: &State, turn: &Turn) {
    if k.walk_sensors.is_some() {
        // No particle is listed yet.
        let none = DispatchGroups {
            x: 0,
            y: turn.advance.walker_rows,
            z: 1,
        };
        rec.update(&s.walker_count, 0, &[0; 3]);
        rec.update(&s.walker_groups, 0, &[none; 3]);
    }
    let args = |listed| arguments::advance(k, s, listed);
    if turn.strategy.has_windows() {
        let window = (&s.transfers.groups, WINDOW);
        rec.dispatch_indirect(&k.advance, window, args(&s.walker_groups), turn.advance);
    } else {
        let particles = Threads(turn.advance.particle_count);
        rec.dispatch(&k.advance, particles, args(&s.walker_groups), turn.advance);
    }
    // Those that were listed follow; they list no others.
    for (list, kernel) in [
        (WALKING, &k.walk_sensors),
        (NEARBY, &k.advance_near),
        (WALKING_NEARBY, &k.walk_near),
    ] {
        if let Some(kernel) = kernel {
            let listed = (&s.walker_groups, list);
            rec.dispatch_indirect(kernel, listed, args(&s.no_groups), turn.advance);
        }
    }
}

fn transfer_in(rec: &mut Recorder, k: &Kernels, s: &State, turn: &Turn) {
    let arriving = (&s.transfers.groups, TRANSFERS);
    let args = arguments::transfer_in(s);
    rec.dispatch_indirect(&k.transfer_in, arriving, args, turn.transfer_in);
}

fn move_border(rec: &mut Recorder, k: &Kernels, s: &State, turn: &Turn) {
    let args = arguments::move_border(s);
    rec.dispatch(&k.move_border, Threads(1), args, turn.move_border);
}

fn transfer_out(rec: &mut Recorder, k: &Kernels, s: &State, turn: &Turn) {
    let selected = (&s.transfers.groups, TRANSFERS);
    let args = arguments::transfer_out(s);
    rec.dispatch_indirect(&k.transfer_out, selected, args, turn.transfer_out);
}

/// Puts the window of the object in order that some have left.
fn defragment(rec: &mut Recorder, k: &Kernels, s: &State, turn: &Turn) {
    match turn.strategy {
        Strategy::Sequential => {
            for part in turn.sequential_parts() {
                let args = arguments::defragment_sequential(s);
                rec.dispatch(&k.defragment_sequential, Threads(1), args, part);
            }
        }
        Strategy::Parallel => {
            let left = (&s.transfers.groups, TRANSFERS);
            let args = arguments::defragment_scan(s);
            rec.dispatch_indirect(&k.defragment_scan, left, args, turn.defragment_scan);
            let args = arguments::defragment_swap(s);
            rec.dispatch_indirect(&k.defragment_swap, left, args, turn.defragment_swap);
        }
        _ => {}
    }
}

/// Texels beside seams come after the others, by their rows.
fn diffuse(rec: &mut Recorder, k: &Kernels, s: &State, params: &StepParams) {
    let spread = (s.unused).spread(k.outgrows_block, &s.trail, &s.deposits);
    let lanes = Threads(params.diffuse.lane_count);
    rec.dispatch(
        &k.diffuse,
        lanes,
        arguments::diffuse(s, &spread),
        params.diffuse,
    );
    let rows = Threads(params.diffuse_seams.row_count);
    let args = arguments::diffuse_seams(s);
    rec.dispatch(&k.diffuse_seams, rows, args, params.diffuse_seams);
}
