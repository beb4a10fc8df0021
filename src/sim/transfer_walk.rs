//! A straight walk that changes once from the first object to the second, at their first crossing, some attempts at a time, for the queries
//! of `myxo query transfer`. Twin of the functions of `shaders/transfer_queries.comp`.

use super::crossing::Terrain;
use super::types::Walker;
use super::walker::WALK_OUT_OF_ATTEMPTS;
use crate::mesh::surface::NONE;

const SOURCE: u32 = 0;
const TARGET: u32 = 1;

/// The walk is on the first object.
pub const PHASE_ON_SOURCE: u32 = 0;
/// Both walkers are on the second.
pub const PHASE_ON_TARGET: u32 = 1;
/// The walk has ended.
pub const PHASE_DONE: u32 = 2;

/// Continues a query's two walkers over at most so many edges.
pub fn walk_on(terrain: &Terrain, attempts: u32, phase: &mut u32, walkers: &mut [Walker]) {
    match *phase {
        PHASE_DONE => {}
        PHASE_ON_SOURCE => walk_on_source(terrain, attempts, phase, walkers),
        _ => walk_on_target(terrain, attempts, phase, walkers),
    }
}

fn walk_on_source(terrain: &Terrain, attempts: u32, phase: &mut u32, walkers: &mut [Walker]) {
    let mut w = walkers[0];
    let place = |position| terrain.ground.place_in(TARGET, position);
    let mut from = place(terrain.flight_of_walker(&w).position);
    for k in 0..attempts {
        if w.status != WALK_OUT_OF_ATTEMPTS {
            break;
        }
        let before = w.remaining;
        let stands_on_edge = k > 0 || w.entered_by != NONE;
        terrain.walk::<true>(&mut w, u32::from(stands_on_edge));
        let on = terrain.flight_of_walker(&w);
        let to = place(on.position);
        if let Some(meeting) = terrain.meeting_between(TARGET, [from, to], &on, 1.0) {
            let rest = w.remaining + (1.0 - meeting.t) * (before - w.remaining);
            for (w, side) in walkers.iter_mut().zip([1.0, -1.0]) {
                *w = Walker {
                    status: WALK_OUT_OF_ATTEMPTS,
                    ..terrain.walker_from(&meeting, side, rest)
                };
            }
            *phase = PHASE_ON_TARGET;
            return;
        }
        from = to;
    }
    walkers[0] = w;
    if w.status != WALK_OUT_OF_ATTEMPTS {
        *phase = PHASE_DONE;
    }
}

fn walk_on_target(terrain: &Terrain, attempts: u32, phase: &mut u32, walkers: &mut [Walker]) {
    for w in walkers.iter_mut() {
        if w.status == WALK_OUT_OF_ATTEMPTS {
            terrain.walk::<true>(w, attempts);
        }
    }
    if walkers.iter().all(|w| w.status != WALK_OUT_OF_ATTEMPTS) {
        if terrain.inner_is_better(SOURCE, &walkers[0], &walkers[1]) {
            walkers[0] = walkers[1];
        }
        *phase = PHASE_DONE;
    }
}
