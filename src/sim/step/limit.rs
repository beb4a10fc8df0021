//! The kernels that decide which particles leave if more are selected than the lists of transfers hold: their parameters, bindings and
//! twins. The particles with the smallest keys leave. A key is the particle's id, mixed by a bijection that differs from step to step: no
//! two keys are equal, no particle is always first, and the order of invocations has no effect.

use crate::gpu::{DispatchGroups, Kernel as _};
use crate::rng::{Purpose, random, seed_word};
use crate::sim::arrays::Arrays;
use crate::sim::buffers::LIMIT_BINS_COUNT as BINS;
use crate::sim::kernels::{
    CloseList, CloseListArgs, CloseListParams, LimitCount, LimitCountArgs, LimitCountParams,
    LimitList, LimitListArgs, LimitListParams, LimitPick, LimitPickArgs, LimitPickParams,
    TransferIn,
};
use crate::sim::plan::Plan;
use crate::sim::state::State;
use crate::sim::types::{Flow, Motion, Particle};
use crate::sim::work::{Call, StepKernel};

/// The half of the keys that is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeyHalf {
    /// The upper one, first.
    Upper,
    /// The lower one, of the keys with the limit's upper half.
    Lower,
}

impl Plan<'_> {
    /// Fixes the number of particles that leave.
    #[must_use]
    pub fn close_list(&self) -> Call<CloseList> {
        Call {
            on: (),
            constants: (),
            params: CloseListParams {
                particle_count: self.particle_count(),
                capacity: self.means.capacity,
                transfer_group: TransferIn::GROUP_SIZE,
                limit_group: LimitCount::GROUP_SIZE,
            },
        }
    }

    /// Is there room in the lists for every particle?
    #[must_use]
    pub fn lists_hold_all(&self) -> bool {
        self.means.capacity >= self.particle_count()
    }

    /// Counts the selected particles by half of their keys.
    #[must_use]
    pub fn limit_count(&self, half: KeyHalf) -> Call<LimitCount> {
        Call {
            on: (),
            constants: (),
            params: LimitCountParams {
                particle_count: self.particle_count(),
                salt: self.salt(),
                is_low: u32::from(half == KeyHalf::Lower),
            },
        }
    }

    /// Finds half of the limit.
    #[must_use]
    pub fn limit_pick(&self, half: KeyHalf) -> Call<LimitPick> {
        Call {
            on: (),
            constants: (),
            params: LimitPickParams {
                capacity: self.means.capacity,
                is_low: u32::from(half == KeyHalf::Lower),
            },
        }
    }

    /// Lists those within the limit.
    #[must_use]
    pub fn limit_list(&self) -> Call<LimitList> {
        Call {
            on: (),
            constants: (),
            params: LimitListParams {
                particle_count: self.particle_count(),
                capacity: self.means.capacity,
                salt: self.salt(),
            },
        }
    }

    /// Makes keys differ from step to step.
    fn salt(&self) -> u32 {
        let seed = seed_word(self.settings.seed);
        random(seed, 0, self.time_step(), Purpose::Limit)[0]
    }
}

impl StepKernel for CloseList {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> CloseListArgs<'s> {
        CloseListArgs {
            flow: &s.transfers.flow,
            groups: &s.transfers.groups,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        let t = &mut a.transfers;
        close_list(&call.params, &mut t.flow[0], &mut t.groups);
    }
}

impl StepKernel for LimitCount {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> LimitCountArgs<'s> {
        LimitCountArgs {
            particles: &s.particles.texels,
            motions: &s.motions.texels,
            flow: &s.transfers.flow,
            bins: &s.transfers.limit_bins,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        let t = &mut a.transfers;
        limit_count(
            &call.params,
            &a.particles,
            &a.motions,
            &t.flow[0],
            &mut t.limit_bins,
        );
    }
}

impl StepKernel for LimitPick {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> LimitPickArgs<'s> {
        LimitPickArgs {
            flow: &s.transfers.flow,
            bins: &s.transfers.limit_bins,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        let t = &mut a.transfers;
        limit_pick(&call.params, &mut t.flow[0], &mut t.limit_bins);
    }
}

impl StepKernel for LimitList {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> LimitListArgs<'s> {
        LimitListArgs {
            particles: &s.particles.texels,
            motions: &s.motions.texels,
            flow: &s.transfers.flow,
            particle_indices: &s.transfers.particle_indices,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        let t = &mut a.transfers;
        limit_list(
            &call.params,
            &a.particles,
            &mut a.motions,
            &mut t.flow[0],
            &mut t.particle_indices,
        );
    }
}

/// The finalizer of MurmurHash3 (Appleby), a bijection.
fn key_of(salt: u32, id: u32) -> u32 {
    let mut h = id.wrapping_add(salt);
    h ^= h >> 16;
    h = h.wrapping_mul(0x85eb_ca6b);
    h ^= h >> 13;
    h = h.wrapping_mul(0xc2b2_ae35);
    h ^ (h >> 16)
}

/// Twin of `shaders/close_list.comp`.
pub fn close_list(params: &CloseListParams, flow: &mut Flow, groups: &mut [DispatchGroups]) {
    let leaving = flow.wanted.min(params.capacity);
    let excess = flow.wanted - leaving;
    flow.leaving = leaving;
    flow.selected = flow.selected.saturating_add(flow.wanted);
    flow.refused = flow.refused.saturating_add(excess);
    flow.most_wanted = flow.most_wanted.max(flow.wanted);
    flow.wanted = 0;
    flow.listed = 0;
    let if_full = |count| if excess > 0 { count } else { 0 };
    groups[0] = DispatchGroups::of(leaving, params.transfer_group);
    groups[1] = DispatchGroups::of(if_full(params.particle_count), params.limit_group);
    groups[2] = DispatchGroups::of(if_full(1), 1);
}

/// Twin of `shaders/limit_count.comp`.
pub fn limit_count(
    params: &LimitCountParams,
    particles: &[Particle],
    motions: &[Motion],
    flow: &Flow,
    bins: &mut [u32],
) {
    for (particle, motion) in particles.iter().zip(motions) {
        let key = key_of(params.salt, particle.id);
        if !motion.is_selected() {
            continue;
        }
        if params.is_low == 0 {
            bins[(key / BINS) as usize] += 1;
        } else if key / BINS == flow.limit / BINS {
            bins[(key % BINS) as usize] += 1;
        }
    }
}

/// Twin of `shaders/limit_pick.comp`.
pub fn limit_pick(params: &LimitPickParams, flow: &mut Flow, bins: &mut [u32]) {
    let is_upper = params.is_low == 0;
    let room = if is_upper { params.capacity } else { flow.rest };
    let upper = if is_upper { 0 } else { flow.limit };
    let mut before = 0;
    for (i, count) in (0..).zip(bins) {
        if before < room && room <= before + *count {
            flow.limit = if is_upper { i * BINS } else { upper + i };
            flow.rest = room - before;
        }
        before += std::mem::take(count);
    }
}

/// Twin of `shaders/limit_list.comp`. The kernel may list in another order.
pub fn limit_list(
    params: &LimitListParams,
    particles: &[Particle],
    motions: &mut [Motion],
    flow: &mut Flow,
    particle_indices: &mut [u32],
) {
    for (slot, (particle, motion)) in (0..).zip(particles.iter().zip(motions)) {
        if !motion.is_selected() {
            continue;
        }
        if key_of(params.salt, particle.id) <= flow.limit {
            particle_indices[flow.listed as usize] = slot;
            flow.listed += 1;
        } else {
            motion.flags &= !Motion::SELECTED;
        }
    }
}
