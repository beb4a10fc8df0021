//! The kernels that keep the ring of windows in order: what they take, read and write, and their twins. A window holds
//! one object's particles; particles in flight lie in front of the first window that they have yet to pass.
//!
//! **Invariant:** the windows lie one behind the other in the ring and share all its slots.
//!
//! **Invariant:** after an object's turn, particles in flight are the first of the next object's window, one for each
//! transfer, and no others are in flight.

use super::turn::Turn;
use crate::gpu::DispatchGroups;
use crate::gpu::Kernel as _;
use crate::sim::arrays::Arrays;
use crate::sim::kernels::{
    Advance, DefragmentScan, DefragmentScanArgs, DefragmentSequential, DefragmentSequentialArgs,
    DefragmentSwap, DefragmentSwapArgs, MoveBorder, MoveBorderArgs, TransferIn,
};
use crate::sim::kernels::{
    DefragmentScanParams, DefragmentSequentialParams, DefragmentSwapParams, MoveBorderConstants,
    MoveBorderParams,
};
use crate::sim::loops::dispatches_of;
use crate::sim::plan::Plan;
use crate::sim::state::State;
use crate::sim::types::{Flow, Motion, Particle, Transfer, Window};
use crate::sim::work::{Call, StepKernel};

impl Plan<'_> {
    /// Ends the turn of an object, or of all.
    pub fn move_border(&self, turn: Turn) -> Call<MoveBorder> {
        Call {
            on: (),
            constants: MoveBorderConstants {
                windows: self.strategy.has_windows(),
            },
            params: MoveBorderParams {
                object: turn.object(),
                object_count: self.object_count(),
                particle_count: self.particle_count(),
                capacity: self.means.capacity,
                transfer_group: TransferIn::GROUP_SIZE,
                particle_group: Advance::GROUP_SIZE,
            },
        }
    }

    /// Lists particles in wrong windows.
    #[must_use]
    pub fn defragment_scan(&self, turn: Turn) -> Call<DefragmentScan> {
        Call {
            on: (),
            constants: (),
            params: DefragmentScanParams {
                next_object: turn.next(self.object_count()),
                particle_count: self.particle_count(),
                capacity: self.means.capacity,
            },
        }
    }

    /// Exchanges them.
    #[must_use]
    pub fn defragment_swap(&self) -> Call<DefragmentSwap> {
        let capacity = self.means.capacity;
        Call {
            on: (),
            constants: (),
            params: DefragmentSwapParams { capacity },
        }
    }

    /// The parts of one pass by one invocation: enough for full lists, each entry of which takes two rounds at the most.
    pub fn defragment_sequential(
        &self,
        turn: Turn,
    ) -> impl Iterator<Item = Call<DefragmentSequential>> + use<> {
        let first = DefragmentSequentialParams {
            next_object: turn.next(self.object_count()),
            object_count: self.object_count(),
            particle_count: self.particle_count(),
            part: 0,
        };
        let parts = dispatches_of(2 * u64::from(self.means.capacity));
        (0..parts).map(move |part| Call {
            on: (),
            constants: (),
            params: DefragmentSequentialParams { part, ..first },
        })
    }
}

impl StepKernel for MoveBorder {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> MoveBorderArgs<'s> {
        MoveBorderArgs {
            flow: &s.transfers.flow,
            windows: &s.transfers.windows,
            groups: &s.transfers.groups,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        let t = &mut a.transfers;
        move_border(
            &call.constants,
            &call.params,
            &mut t.flow[0],
            &mut t.windows,
            &mut t.groups,
        );
    }
}

impl StepKernel for DefragmentScan {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> DefragmentScanArgs<'s> {
        DefragmentScanArgs {
            departing: &s.transfers.departing,
            motions: &s.motions.texels,
            windows: &s.transfers.windows,
            flow: &s.transfers.flow,
            particle_indices: &s.transfers.particle_indices,
            transfer_indices: &s.transfers.transfer_indices,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        let t = &mut a.transfers;
        defragment_scan(
            &call.params,
            &t.departing,
            &a.motions,
            &t.windows,
            &mut t.flow[0],
            &mut t.particle_indices,
            &mut t.transfer_indices,
        );
    }
}

impl StepKernel for DefragmentSwap {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> DefragmentSwapArgs<'s> {
        DefragmentSwapArgs {
            flow: &s.transfers.flow,
            particle_indices: &s.transfers.particle_indices,
            transfer_indices: &s.transfers.transfer_indices,
            departing: &s.transfers.departing,
            particles: &s.particles.texels,
            motions: &s.motions.texels,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        let t = &mut a.transfers;
        defragment_swap(
            &call.params,
            &t.flow[0],
            &t.particle_indices,
            &t.transfer_indices,
            &mut t.departing,
            &mut a.particles,
            &mut a.motions,
        );
    }
}

impl StepKernel for DefragmentSequential {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> DefragmentSequentialArgs<'s> {
        DefragmentSequentialArgs {
            flow: &s.transfers.flow,
            windows: &s.transfers.windows,
            departing: &s.transfers.departing,
            particles: &s.particles.texels,
            motions: &s.motions.texels,
            particle_indices: &s.transfers.particle_indices,
            transfer_indices: &s.transfers.transfer_indices,
        }
    }

    /// The first part does all of it.
    fn twin(call: &Call<Self>, a: &mut Arrays) {
        let t = &mut a.transfers;
        if call.params.part == 0 {
            defragment_sequential(
                &call.params,
                &mut t.flow[0],
                &t.windows,
                &mut t.departing,
                &mut a.particles,
                &mut a.motions,
            );
        }
    }
}

/// Twin of `shaders/move_border.comp`: ends an object's turn.
pub fn move_border(
    constants: &MoveBorderConstants,
    params: &MoveBorderParams,
    flow: &mut Flow,
    windows: &mut [Window],
    groups: &mut [DispatchGroups],
) {
    let now = flow;
    let leaving = now.wanted.min(params.capacity);
    now.leaving = leaving;
    now.carried = now.passing;
    now.selected = now.selected.saturating_add(now.wanted - now.passing);
    now.refused = now.refused.saturating_add(now.wanted - leaving);
    if params.object == 0 {
        now.asked_before = now.asking;
        now.asking = 0;
    }
    now.asking += now.wanted - now.passing;
    let all = now.asking + now.asked_before;
    let enough = if now.refused > 0 { all } else { 0 };
    now.most_wanted = now.most_wanted.max(now.wanted).max(enough);
    now.mismatches += u32::from(now.stayers != now.outside);
    now.wanted = 0;
    now.passing = 0;
    now.stayers = 0;
    now.outside = 0;
    groups[0] = DispatchGroups::of(leaving, params.transfer_group);
    if constants.windows {
        let object = params.object as usize;
        let next = (object + 1) % params.object_count as usize;
        windows[object].count -= leaving;
        let ring = params.particle_count;
        let window = &mut windows[next];
        window.start = Window::slot(window.start, ring - leaving, ring);
        window.count += leaving;
        groups[1] = DispatchGroups::of(window.count, params.particle_group);
    }
}

/// Twin of `shaders/defragment_scan.comp`: lists what lies in the wrong place. The kernel may append in another order.
pub fn defragment_scan(
    params: &DefragmentScanParams,
    departing: &[Transfer],
    motions: &[Motion],
    windows: &[Window],
    flow: &mut Flow,
    particle_indices: &mut [u32],
    transfer_indices: &mut [u32],
) {
    let start = windows[params.next_object as usize].start;
    for i in 0..flow.leaving {
        let slot = Window::slot(start, i, params.particle_count);
        if !motions[slot as usize].in_flight() {
            particle_indices[flow.stayers as usize] = slot;
            flow.stayers += 1;
        }
        let particle = departing[i as usize].particle;
        if Window::offset(start, particle, params.particle_count) >= flow.leaving {
            transfer_indices[flow.outside as usize] = i;
            flow.outside += 1;
        }
    }
}

/// Twin of `shaders/defragment_swap.comp`: exchanges what the scan has listed, pair by pair.
pub fn defragment_swap(
    params: &DefragmentSwapParams,
    flow: &Flow,
    particle_indices: &[u32],
    transfer_indices: &[u32],
    departing: &mut [Transfer],
    particles: &mut [Particle],
    motions: &mut [Motion],
) {
    let pairs = flow.stayers.min(flow.outside).min(params.capacity) as usize;
    for (&inside, &transfer) in particle_indices.iter().zip(transfer_indices).take(pairs) {
        let outside = std::mem::replace(&mut departing[transfer as usize].particle, inside);
        particles.swap(inside as usize, outside as usize);
        motions.swap(inside as usize, outside as usize);
    }
}

/// Twin of `shaders/defragment_sequential.comp`: the same as all of its parts, by one pass.
pub fn defragment_sequential(
    params: &DefragmentSequentialParams,
    flow: &mut Flow,
    windows: &[Window],
    departing: &mut [Transfer],
    particles: &mut [Particle],
    motions: &mut [Motion],
) {
    let ring = params.particle_count;
    let start = windows[params.next_object as usize].start;
    let mut next = 0;
    for transfer in &mut departing[..flow.leaving as usize] {
        let outside = transfer.particle;
        if Window::offset(start, outside, ring) < flow.leaving {
            continue;
        }
        let mut inside = Window::slot(start, next, ring);
        while next + 1 < flow.leaving && motions[inside as usize].in_flight() {
            next += 1;
            inside = Window::slot(start, next, ring);
        }
        next += 1;
        transfer.particle = inside;
        particles.swap(inside as usize, outside as usize);
        motions.swap(inside as usize, outside as usize);
    }
    flow.outside = 0;
}
