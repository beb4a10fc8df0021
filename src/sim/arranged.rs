//! A state in the order that a strategy needs.

use super::ground::Ground;
use super::setup::Setup;
use super::snapshot::Snapshot;
use super::types::{Motion, Particle, Pose, Window};
use crate::scene::settings::Strategy;

/// Puts a state in the order that a strategy needs: with windows, each object's particles together; without turns,
/// none in flight: those land where objects stand now. A state that is in order stays as it is.
#[must_use]
pub fn arranged(
    mut state: Snapshot,
    setup: &Setup,
    poses: &[Pose],
    strategy: Strategy,
) -> Snapshot {
    let objects = setup.poses.len();
    if objects > 1 {
        state.transfers.flux.resize(objects * objects, 0);
    }
    if !strategy.has_turns() {
        land_all(&mut state, setup, poses);
    }
    if !strategy.has_windows() {
        state.transfers.windows.clear();
    } else if state.transfers.windows.len() != objects {
        into_windows(&mut state, setup);
    }
    state
}

/// Everybody in flight arrives.
fn land_all(state: &mut Snapshot, setup: &Setup, poses: &[Pose]) {
    let ground = Ground::of(setup, poses);
    for transfer in std::mem::take(&mut state.transfers.in_flight) {
        let slot = transfer.particle as usize;
        ground.land(
            &transfer,
            &mut state.particles[slot],
            &mut state.motions[slot],
        );
        let flow = &mut state.transfers.flow;
        flow.arrived = flow.arrived.saturating_add(1);
    }
    state.transfers.flow.leaving = 0;
    state.transfers.flow.carried = 0;
}

/// Sorts particles by object; those in flight lie in front of the first window, where the next step expects them.
fn into_windows(state: &mut Snapshot, setup: &Setup) {
    let objects = setup.poses.len();
    let place = |slot: usize| {
        if state.motions[slot].in_flight() {
            0
        } else {
            let triangle = state.particles[slot].triangle;
            1 + setup.surface.triangles[triangle as usize].object as usize
        }
    };
    let mut counts = vec![0; objects + 1];
    (0..state.particles.len()).for_each(|slot| counts[place(slot)] += 1);
    let mut order: Vec<usize> = (0..state.particles.len()).collect();
    order.sort_by_key(|&slot| place(slot));
    let mut slot_of = vec![0; order.len()];
    for (new, &old) in order.iter().enumerate() {
        slot_of[old] = new as u32;
    }
    let particles: Vec<Particle> = order.iter().map(|&slot| state.particles[slot]).collect();
    let motions: Vec<Motion> = order.iter().map(|&slot| state.motions[slot]).collect();
    (state.particles, state.motions) = (particles, motions);
    for transfer in &mut state.transfers.in_flight {
        transfer.particle = slot_of[transfer.particle as usize];
    }
    let mut start = 0;
    state.transfers.windows.clear();
    for object in 0..objects {
        let count = counts[object + 1] + if object == 0 { counts[0] } else { 0 };
        state.transfers.windows.push(Window { start, count });
        start += count;
    }
    let ring = order.len() as u32;
    for window in &mut state.transfers.windows {
        // The window behind the last slot begins at the first one.
        window.start = if window.start == ring {
            0
        } else {
            window.start
        };
    }
}
