//! A state in the order that a strategy needs.

use rayon::prelude::*;

use super::ground::Ground;
use super::setup::Setup;
use super::snapshot::Snapshot;
use super::sorting::{Bins, most_parts, part_bits};
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
    let tiles = (tile_shift, part_bits(count, false));
    let parts = state.particles.par_iter();
    let parts = parts.map(|particle| Bins::part_of(tiles, &setup.strips, particle));
    let parts: Vec<u32> = parts.collect();
    let count = most_parts(count) as usize;
    let mut places = vec![0_usize; count + 1];
    parts
        .iter()
        .for_each(|&part| places[part as usize + 1] += 1);
    for part in 0..count {
        places[part + 1] += places[part];
    }
    // One table after the other, because second copies of both take much memory.
    state.particles = scattered(&state.particles, &parts, places.clone());
    state.motions = scattered(&state.motions, &parts, places);
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
