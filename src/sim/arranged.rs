//! A state in the order that a strategy needs.

use rayon::prelude::*;

use super::ground::Ground;
use super::setup::Setup;
use super::snapshot::Snapshot;
use super::sorting::Bins;
use super::types::{Pose, Window};
use crate::scene::settings::Strategy;

/// Puts a state in the order that a strategy needs: with windows, each object's particles together; and at the start, particles that are
/// near each other in the atlas, an order that steps maintain. Particles in flight, which checkpoints of earlier versions have, land at the
/// present poses. A state that is in order does not change.
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
        // The old windows belong to another strategy.
        state.transfers.windows.clear();
    }
    if !strategy.has_windows() {
        state.transfers.windows.clear();
        if state.step == 0 && strategy.may_sort() {
            sort(&mut state, setup);
        }
    } else if state.transfers.windows.len() != objects {
        sort(&mut state, setup);
        state.transfers.windows = windows(&state, setup);
    }
    state
}

/// Lets all particles in flight land.
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

/// Puts particles in the order of their bins, which are numbered object by object.
fn sort(state: &mut Snapshot, setup: &Setup) {
    let Bins { tile_shift, count } = setup.bins;
    let bins = state.particles.par_iter();
    let bins = bins.map(|particle| Bins::of(tile_shift, &setup.strips, particle));
    let bins: Vec<u32> = bins.collect();
    let mut places = vec![0_usize; count as usize + 1];
    bins.iter().for_each(|&bin| places[bin as usize + 1] += 1);
    for bin in 0..count as usize {
        places[bin + 1] += places[bin];
    }
    // One table after the other, because second copies of both take much memory.
    state.particles = scattered(&state.particles, &bins, places.clone());
    state.motions = scattered(&state.motions, &bins, places);
}

/// Elements in the order of their bins, each of which begins at its place.
fn scattered<T: Copy>(elements: &[T], bins: &[u32], mut places: Vec<usize>) -> Vec<T> {
    let mut sorted = elements.to_vec();
    for (element, &bin) in elements.iter().zip(bins) {
        let place = &mut places[bin as usize];
        sorted[*place] = *element;
        *place += 1;
    }
    sorted
}

/// The windows of particles that are in the order of objects.
fn windows(state: &Snapshot, setup: &Setup) -> Vec<Window> {
    let mut counts = vec![0; setup.poses.len()];
    for particle in &state.particles {
        counts[setup.strips[particle.triangle as usize].shape.object as usize] += 1;
    }
    let ring = state.particles.len() as u32;
    let windows = counts.into_iter().scan(0, |start, count| {
        let window = Window {
            // A window that would begin behind the last slot begins at the first one.
            start: if *start == ring { 0 } else { *start },
            count,
        };
        *start += count;
        Some(window)
    });
    windows.collect()
}
