//! One simulation step, as a script: one line per kernel, in order. Each kernel's file has its parameters, its bindings and its twin; the
//! barriers between kernels follow from the bindings.

pub mod advance;
pub mod diffuse;
pub mod diffuse_seams;
pub mod digest;
pub mod distance;
pub mod distance_brute;
pub mod distance_merge;
pub mod distance_raster;
pub mod distance_tiles;
pub mod exchange_seams;
pub mod limit;
pub mod occupancy;
pub mod population;
pub mod project;
pub mod respawn;
pub mod scent;
pub mod scent_across;
pub mod sort;
pub mod trail_across;
pub mod transfer;
pub mod unfold;
pub mod windows;

use super::claims::FREE;
use super::distance::TILE_SAMPLES;
use super::plan::Plan;
use super::roles::Pair;
use super::sorting::Segment;
use super::spread::{Pass, passes};
use super::work::{Call, Counter, Step, StepKernel};
use crate::gpu::{DispatchGroups, Threads};
use crate::scene::settings::{DistanceMethod, Strategy};
use advance::{Form, Terms};
use exchange_seams::Field;
use limit::KeyHalf;

/// The step by this plan.
#[must_use]
pub fn step(plan: &Plan<'_>) -> Step {
    let mut step = Step::default();
    let s = &mut step;
    bring_changes(s, plan);
    take_distances(s, plan);
    cross_contacts(s, plan);
    if plan.breeds {
        breed(s, plan);
    }
    act(s, plan);
    s.side_by_side(
        |s| {
            change_objects(s, plan);
            if let Some(segment) = plan.segment {
                sort(s, plan, segment);
            }
        },
        |s| {
            feed(s, plan);
            spread(s, plan);
        },
    );
    step
}

impl Step {
    /// Adds the kernels by which particles act: some depend on whether pulses are live.
    pub fn add_acts(&mut self, plan: &Plan<'_>) {
        act(self, plan);
    }
}

/// Uploads values that have changed. They are part of the step's commands, so queued steps keep theirs.
fn bring_changes(s: &mut Step, plan: &Plan<'_>) {
    let changes = &plan.changes;
    if let Some(poses) = &changes.poses {
        s.write(poses, |s| &s.objects.poses, |a| &mut a.poses);
    }
    if let Some(poses) = &changes.poses_before {
        s.write(poses, |s| &s.objects.poses_before, |a| &mut a.poses_before);
    }
    if let Some(physarums) = &changes.physarums {
        s.write(physarums, |s| &s.objects.physarums, |a| &mut a.physarums);
    }
    if let Some(rates) = &changes.rates {
        s.write(rates, |s| &s.objects.rates, |a| &mut a.rates);
    }
    if !plan.shells.is_empty() {
        s.write(&plan.shells, |s| &s.objects.shells, |a| &mut a.shells);
    }
}

/// Computes distances between objects; only objects that have moved have jobs.
fn take_distances(s: &mut Step, plan: &Plan<'_>) {
    let update = &plan.distances;
    if update.jobs.is_empty() {
        return;
    }
    s.write(&update.jobs, |s| &s.near.jobs, |a| &mut a.jobs);
    s.write(&update.pairs, |s| &s.near.pairs, |a| &mut a.pairs);
    s.write(&update.moves, |s| &s.near.moves, |a| &mut a.moves);
    match plan.settings.distance.method {
        DistanceMethod::Bvh => {
            let texels = Threads(update.tile_count() * TILE_SAMPLES);
            s.reset(NONE_LISTED, |s| &s.near.tile_groups);
            s.reset(NONE_LISTED, |s| &s.near.covered_groups);
            s.run(Threads(update.tile_count()), plan.distance_tiles());
            s.run_at_most(texels, Counter::Tiles, plan.distance());
        }
        DistanceMethod::Brute => s.run(Threads(update.thread_count), plan.distance_brute()),
        DistanceMethod::Raster => {
            for (round, draw) in (0..).zip(plan.distance_raster()) {
                s.add(draw);
                s.run(Threads(update.thread_count), plan.distance_merge(round));
            }
        }
    }
    s.run(plan.seams(), plan.exchange_seams(Field::Distances));
    if plan.finds_across() {
        match plan.settings.distance.method {
            DistanceMethod::Bvh => s.run(Counter::Covered, plan.unfold()),
            _ => s.run(Threads(update.thread_count), plan.unfold()),
        }
    }
}

/// Sums up the scents that sensors read where they cross contacts, if objects have moved or food may have been eaten. It comes before they
/// read.
fn cross_contacts(s: &mut Step, plan: &Plan<'_>) {
    if plan.scent_crosses() && !plan.scents_stay {
        s.run(plan.samples(), plan.scent_across());
        s.run(plan.seams(), plan.exchange_seams(Field::Scent));
    }
}

/// Particles that enter another object change to it, or restart, by the strategy.
fn change_objects(s: &mut Step, plan: &Plan<'_>) {
    match plan.strategy {
        Strategy::None => {}
        Strategy::Respawn => {
            select(s, plan);
            s.run(Counter::Transfers, plan.respawn());
        }
        Strategy::Scattered | Strategy::Direct => {
            select(s, plan);
            transfer(s, plan);
        }
        Strategy::Sequential | Strategy::Parallel => {
            select(s, plan);
            transfer(s, plan);
            s.run(Threads(1), plan.move_borders());
            defragment(s, plan);
        }
    }
}

/// Particles divide, or die, by how crowded it is round them.
fn breed(s: &mut Step, plan: &Plan<'_>) {
    let particles = Threads(plan.particle_count());
    s.fill(0, |s| &s.growth().occupants, |a| &mut a.occupants);
    s.fill(FREE, |s| &s.growth().nursery, |a| &mut a.nursery);
    s.fill(0, |s| &s.growth().id_marks, |a| &mut a.id_marks);
    s.run(particles, plan.count_cells());
    s.run(particles, plan.divide());
    s.run(particles, plan.divide_settle());
    s.run(Threads(1), plan.divide_number());
    s.run(particles, plan.divide_list());
    s.run(particles, plan.divide_begin());
}

/// Every particle senses, turns and walks. With one particle a cell it claims the cell that it would come to, and stays if it has not won it.
fn act(s: &mut Step, plan: &Plan<'_>) {
    let terms = plan.terms();
    if !plan.rules.is_crowded() {
        return by_forms(s, plan, terms, |form| plan.advance(terms, form));
    }
    s.fill(FREE, |s| &s.crowd().goals, |a| &mut a.goals);
    s.fill(FREE, |s| &s.crowd().bids, |a| &mut a.bids);
    by_forms(s, plan, terms, |form| plan.wish(terms, form));
    s.run(Threads(plan.particle_count()), plan.arrive());
}

/// Sensors read straight ahead in the atlas where they can; particles whose sensors must walk follow in a second dispatch, those near another
/// object in a third, and those of both kinds in a fourth.
fn by_forms<K: StepKernel>(
    s: &mut Step,
    plan: &Plan<'_>,
    terms: Terms,
    call: impl Fn(Form) -> Call<K>,
) {
    let forms = plan.forms_of_advance(terms);
    if !forms.is_empty() {
        // No particle is listed yet.
        let none = DispatchGroups {
            x: 0,
            y: plan.walker_rows(),
            z: 1,
        };
        s.reset([0; 3], |s| &s.walkers.count);
        s.reset([none; 3], |s| &s.walkers.groups);
    }
    s.run(Threads(plan.particle_count()), call(Form::All));
    let why = "each has particles of its own; they count by atomic additions and claim cells by atomic minima, and other words have one writer";
    s.unordered(why, advance::shared_by_forms, |s| {
        for &(form, listed) in forms {
            s.run(listed, call(form));
        }
    });
}

/// Fixes which of the particles that `advance` has listed leave. If it has found more than the lists hold, those with the smallest keys are
/// listed again; otherwise these kernels have no groups.
fn select(s: &mut Step, plan: &Plan<'_>) {
    s.run(Threads(1), plan.close_list());
    if plan.lists_hold_all() {
        return;
    }
    for half in [KeyHalf::Upper, KeyHalf::Lower] {
        s.run(Counter::Excess, plan.limit_count(half));
        s.run(Counter::Limit, plan.limit_pick(half));
    }
    s.run(Counter::Excess, plan.limit_list());
}

/// Moves selected particles to their target objects.
fn transfer(s: &mut Step, plan: &Plan<'_>) {
    s.run(Counter::Transfers, plan.transfer_out());
    if plan.rules.is_crowded() {
        s.run(Counter::Transfers, plan.land_claim());
        s.run(Counter::Transfers, plan.land_settle());
    }
    s.run(Counter::Transfers, plan.transfer_in());
}

/// Moves particles in other windows into their objects' windows.
fn defragment(s: &mut Step, plan: &Plan<'_>) {
    if plan.strategy == Strategy::Sequential {
        for first in plan.runs(plan.most_candidates()) {
            s.run(Threads(1), plan.defragment_scan(first));
        }
        for first in plan.runs(plan.most_entries()) {
            s.run(Threads(1), plan.defragment_swap(first));
        }
    } else {
        s.run(Counter::Candidates, plan.defragment_scan(0));
        s.run(Counter::Strays, plan.defragment_swap(0));
    }
}

/// Subtracts the meals eaten, updates the scent field if a scent has changed, and adds to the trail what food projects into it.
fn feed(s: &mut Step, plan: &Plan<'_>) {
    if !plan.has_food() {
        return;
    }
    let none = DispatchGroups { x: 0, y: 0, z: 1 };
    s.reset([none], |s| &s.food().groups);
    s.run(Threads(plan.foods()), plan.digest());
    s.run(Counter::Scented, plan.scent());
    if plan.projects() {
        s.run(plan.projected(), plan.project());
    }
}

/// The trail spreads, takes up the deposits and decays.
fn spread(s: &mut Step, plan: &Plan<'_>) {
    for pass in Pass::of(passes(plan.settings, plan.setup)) {
        diffuse(s, plan, pass);
        if pass == Pass::Last {
            // Gutters are filled, so that the next step's sensors see no seam.
            s.run(plan.seams(), plan.exchange_seams(Field::Trail));
        }
        s.swap(Pair::Trail);
    }
    s.swap(Pair::Deposits);
}

/// Texels beside seams come after the others, by their rows; before both, covered texels take what spreads from other objects.
fn diffuse(s: &mut Step, plan: &Plan<'_>, pass: Pass) {
    if plan.trail_crosses() {
        s.run(plan.samples(), plan.trail_across());
    }
    let texels = plan.diffuse(pass);
    let rows = plan.diffuse_seams(pass);
    s.run(Threads(texels.params.lane_count), texels);
    s.run(Threads(rows.params.row_count), rows);
}

/// Sorts a segment of the particles.
fn sort(s: &mut Step, plan: &Plan<'_>, segment: Segment) {
    let particles = Threads(segment.count);
    s.run(particles, plan.sort_count(segment));
    s.run(plan.bin_runs(), plan.sort_sums());
    s.run(plan.bin_runs(), plan.sort_scan());
    s.run(particles, plan.sort_scatter(segment));
}

/// The groups of the kernel that works on a list, and the number of its entries, for an empty list.
const NONE_LISTED: [DispatchGroups; 2] = [
    DispatchGroups { x: 0, y: 1, z: 1 },
    DispatchGroups { x: 0, y: 0, z: 0 },
];
