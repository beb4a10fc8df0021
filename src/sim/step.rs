//! One simulation step: every dispatch, in order, and nothing else. The recorder finds the barriers between them.

mod distances;
mod feeding;
mod sorting;

use super::kernels::{
    AdvanceArgs, DefragmentScanArgs, DefragmentSequentialArgs, DefragmentSwapArgs, DiffuseArgs,
    DiffuseSeamsArgs, ExchangeSeamsArgs, MoveBorderArgs, RespawnArgs, TransferInArgs,
    TransferOutArgs,
};
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
        diffuse_seams(rec, k, s, &first_half);
        s.trail.swap();
    }
    diffuse(rec, k, s, params);
    diffuse_seams(rec, k, s, params);
    exchange_seams(rec, k, s, params);
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
            respawn(rec, k, s, all);
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
                match turn.strategy {
                    Strategy::Sequential => defragment_sequential(rec, k, s, &turn),
                    Strategy::Parallel => {
                        defragment_scan(rec, k, s, &turn);
                        defragment_swap(rec, k, s, &turn);
                    }
                    _ => {}
                }
                s.transfers.swap();
            }
        }
    }
}

/// Where sensors read straight ahead in the atlas, those particles come in a second dispatch whose sensors must walk; those
/// that may have to do with another object come in a third, or in a fourth, if their sensors must walk, too.
fn advance<'s>(rec: &mut Recorder, k: &Kernels, s: &'s State, turn: &Turn) {
    let deposits = s.unused.counted(k.outgrows_block, &s.deposits);
    let food = s.food.as_ref();
    let meals = food.map_or(&s.no_meals, |food| &food.meals);
    let args = |walker_groups: &'s _| AdvanceArgs {
        particles: &s.particles_view,
        motions: &s.motions_view,
        strips: &s.strips,
        trail: &s.trail.front_views.texels,
        previous_deposits: &s.deposits.back_views.texels,
        deposits: deposits.block,
        low_deposits: deposits.low,
        high_deposits: deposits.high,
        corners: &s.corners,
        vertices: &s.vertices,
        poses: &s.poses_view,
        distances: &s.distance_views.distances,
        physarums: &s.physarums,
        across: &s.across_views.places,
        across_triangles: &s.across_views.triangles,
        surroundings: &s.across_views.surroundings,
        windows: &s.transfers.window_texels,
        flow: &s.transfers.flow,
        particle_indices: &s.transfers.particle_indices,
        particles_before: &s.particles_view,
        motions_before: &s.motions_view,
        walkers: &s.walkers_view,
        walker_count: &s.walker_count,
        walker_groups,
        bias: s.bias_texels(),
        scent: food.map_or(&s.trail.front_views.texels, |food| &food.scent_views.texels),
        plates: food.map_or(&s.deposits.back_views.texels, |food| {
            &food.plate_views.texels
        }),
        meals,
    };
    if k.walk_sensors.is_some() {
        empty_walkers(rec, s, turn);
    }
    if turn.strategy.has_windows() {
        let groups = &s.transfers.groups;
        rec.dispatch_indirect(
            &k.advance,
            groups,
            WINDOW,
            args(&s.walker_groups),
            turn.advance,
        );
    } else {
        let threads = Threads(turn.advance.particle_count);
        rec.dispatch(&k.advance, threads, args(&s.walker_groups), turn.advance);
    }
    // Those who were listed follow; they list nobody.
    let listed = [
        (WALKING, &k.walk_sensors),
        (NEARBY, &k.advance_near),
        (WALKING_NEARBY, &k.walk_near),
    ];
    for (list, kernel) in listed {
        let Some(kernel) = kernel else { continue };
        rec.dispatch_indirect(
            kernel,
            &s.walker_groups,
            list,
            args(&s.no_groups),
            turn.advance,
        );
    }
}

/// Nobody is listed yet whose sensors must walk, or who is near another object.
fn empty_walkers(rec: &mut Recorder, s: &State, turn: &Turn) {
    let rows = turn.advance.walker_rows;
    let none = DispatchGroups {
        x: 0,
        y: rows,
        z: 1,
    };
    rec.update(&s.walker_count, 0, &[0; 3]);
    rec.update(&s.walker_groups, 0, &[none; 3]);
}

fn transfer_in(rec: &mut Recorder, k: &Kernels, s: &State, turn: &Turn) {
    rec.dispatch_indirect(
        &k.transfer_in,
        &s.transfers.groups,
        TRANSFERS,
        TransferInArgs {
            arriving: &s.transfers.arriving,
            departing: &s.transfers.departing,
            flow: &s.transfers.flow,
            particles: &s.particles_view,
            motions: &s.motions_view,
            triangles: &s.triangles,
            corners: &s.corners,
            vertices: &s.vertices,
            poses: &s.poses_view,
        },
        turn.transfer_in,
    );
}

fn move_border(rec: &mut Recorder, k: &Kernels, s: &State, turn: &Turn) {
    rec.dispatch(
        &k.move_border,
        Threads(1),
        MoveBorderArgs {
            flow: &s.transfers.flow,
            windows: &s.transfers.windows,
            groups: &s.transfers.groups,
        },
        turn.move_border,
    );
}

fn transfer_out(rec: &mut Recorder, k: &Kernels, s: &State, turn: &Turn) {
    rec.dispatch_indirect(
        &k.transfer_out,
        &s.transfers.groups,
        TRANSFERS,
        TransferOutArgs {
            flow: &s.transfers.flow,
            particle_indices: &s.transfers.particle_indices,
            particles: &s.particles_view,
            motions: &s.motions_view,
            nearest: &s.distance_views.nearest,
            strips: &s.strips,
            departing: &s.transfers.departing,
            flux: &s.transfers.flux,
            triangles: &s.triangles,
            halfedges: &s.halfedges,
            corners: &s.corners,
            vertices: &s.vertices,
            poses: &s.poses_view,
            physarums: &s.physarums,
            roots: &s.roots,
            nodes: &s.nodes,
            faces: &s.faces,
            pseudonormals: &s.pseudonormals,
            dipoles: &s.dipoles,
            poses_before: &s.poses_before_view,
            bias: s.bias_texels(),
        },
        turn.transfer_out,
    );
}

fn defragment_scan(rec: &mut Recorder, k: &Kernels, s: &State, turn: &Turn) {
    rec.dispatch_indirect(
        &k.defragment_scan,
        &s.transfers.groups,
        TRANSFERS,
        DefragmentScanArgs {
            departing: &s.transfers.departing,
            motions: &s.motions_view,
            windows: &s.transfers.windows,
            flow: &s.transfers.flow,
            particle_indices: &s.transfers.particle_indices,
            transfer_indices: &s.transfers.transfer_indices,
        },
        turn.defragment_scan,
    );
}

fn defragment_swap(rec: &mut Recorder, k: &Kernels, s: &State, turn: &Turn) {
    rec.dispatch_indirect(
        &k.defragment_swap,
        &s.transfers.groups,
        TRANSFERS,
        DefragmentSwapArgs {
            flow: &s.transfers.flow,
            particle_indices: &s.transfers.particle_indices,
            transfer_indices: &s.transfers.transfer_indices,
            departing: &s.transfers.departing,
            particles: &s.particles_view,
            motions: &s.motions_view,
        },
        turn.defragment_swap,
    );
}

fn defragment_sequential(rec: &mut Recorder, k: &Kernels, s: &State, turn: &Turn) {
    for part in turn.sequential_parts() {
        rec.dispatch(
            &k.defragment_sequential,
            Threads(1),
            DefragmentSequentialArgs {
                flow: &s.transfers.flow,
                windows: &s.transfers.windows,
                departing: &s.transfers.departing,
                particles: &s.particles_view,
                motions: &s.motions_view,
                particle_indices: &s.transfers.particle_indices,
                transfer_indices: &s.transfers.transfer_indices,
            },
            part,
        );
    }
}

fn respawn(rec: &mut Recorder, k: &Kernels, s: &State, turn: &Turn) {
    rec.dispatch_indirect(
        &k.respawn,
        &s.transfers.groups,
        TRANSFERS,
        RespawnArgs {
            flow: &s.transfers.flow,
            particle_indices: &s.transfers.particle_indices,
            particles: &s.particles_view,
            motions: &s.motions_view,
            triangles: &s.triangles,
            area_shares: &s.transfers.area_shares,
            object_triangles: &s.transfers.object_triangles,
        },
        turn.respawn,
    );
}

fn diffuse(rec: &mut Recorder, k: &Kernels, s: &State, params: &StepParams) {
    let spread = (s.unused).spread(k.outgrows_block, &s.trail, &s.deposits);
    rec.dispatch(
        &k.diffuse,
        Threads(params.diffuse.lane_count),
        DiffuseArgs {
            blocks: &s.blocks,
            trail: &s.trail.front_views.quads,
            deposits: &s.deposits.front_views.quads,
            density: &s.density_views.quads,
            next_trail: &spread.next_trail,
            next_trail_quads: spread.next_trail_quads,
            previous_deposits: &spread.previous_deposits,
            previous_deposits_quads: spread.previous_deposits_quads,
        },
        params.diffuse,
    );
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
            low_next_trail: &s.trail.back_views.low,
            high_next_trail: &s.trail.back_views.high,
        },
        params.diffuse_seams,
    );
}

fn exchange_seams(rec: &mut Recorder, k: &Kernels, s: &State, params: &StepParams) {
    rec.dispatch(
        &k.exchange_seams,
        Threads(params.exchange_seams.seam_count),
        ExchangeSeamsArgs {
            seams: &s.seams,
            trail: &s.trail.back_views.texels,
            low_trail: &s.trail.back_views.low,
            high_trail: &s.trail.back_views.high,
        },
        params.exchange_seams,
    );
}
