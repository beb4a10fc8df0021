//! A state in the order that a strategy needs.

use super::ground::Ground;
use super::setup::Setup;
use super::snapshot::Snapshot;
use super::types::{Motion, Particle, Pose, Window};
use crate::scene::settings::Strategy;

/// Puts a state in the order that a strategy needs: with windows, each object's particles together. Particles in flight, which
/// checkpoints of earlier versions have, land where objects stand now. A state that is in order stays as it is.
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
    if !state.transfers.in_flight.is_empty() {
        land_all(&mut state, setup, poses);
        // They have lain in other windows.
        state.transfers.windows.clear();
    }
    if !strategy.has_windows() {
        state.transfers.windows.clear();
    } else if state.transfers.windows.len() != objects {
        into_windows(&mut state, setup);
    }
    state
}

/// All that are in flight arrive.
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
}

/// Sorts particles by object.
fn into_windows(state: &mut Snapshot, setup: &Setup) {
    let objects = setup.poses.len();
    let object = |slot: usize| {
        let triangle = state.particles[slot].triangle;
        setup.surface.triangles[triangle as usize].object as usize
    };
    let mut counts = vec![0; objects];
    (0..state.particles.len()).for_each(|slot| counts[object(slot)] += 1);
    let mut order: Vec<usize> = (0..state.particles.len()).collect();
    order.sort_by_key(|&slot| object(slot));
    let particles: Vec<Particle> = order.iter().map(|&slot| state.particles[slot]).collect();
    let motions: Vec<Motion> = order.iter().map(|&slot| state.motions[slot]).collect();
    (state.particles, state.motions) = (particles, motions);
    let mut start = 0;
    state.transfers.windows.clear();
    for count in counts {
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
