//! The kernels by which particles walk, one a cell: their parameters, bindings and twins.
//!
//! Every particle takes its cell, and wishes to come to another one. In each round they claim these cells, and the lowest rank wins each
//! that is free: what winners leave is free in the next round, for particles of higher ranks than theirs. So it ends as if particles moved one
//! after the other by their ranks, but for rows of particles that are longer than there are rounds. Then winners move, and those that have won
//! nothing stay. Particles that come over from other objects claim the cells that are free after that.

use glam::UVec4;

use crate::rng::{Purpose, random, seed_word};
use crate::scene::settings::Strategy;
use crate::sim::arrays::Arrays;
use crate::sim::claims::{
    FREE, LANDING, NO_RANK, REFUSED, SHARED_CELL, claim_of, comes_too_early, is_taken, is_won,
    rank_of, taken_by,
};
use crate::sim::field::{atlas_position, texel_at};
use crate::sim::ground::{Flight, Ground};
use crate::sim::kernels::{
    Arrive, ArriveArgs, ArriveConstants, ArriveParams, Claim, ClaimArgs, ClaimConstants,
    ClaimParams, LandClaim, LandClaimArgs, LandClaimConstants, LandClaimParams, LandSettle,
    LandSettleArgs, LandSettleConstants, LandSettleParams, Settle, SettleArgs, SettleConstants,
    SettleParams, Wish, WishArgs, WishConstants, WishParams,
};
use crate::sim::plan::Plan;
use crate::sim::state::State;
use crate::sim::step::advance::{AdvanceInputs, Arriving, Walking, own_parameters};
use crate::sim::types::{Flow, Meal, Motion, Particle, Transfer};
use crate::sim::work::{Call, StepKernel};
use crate::strict::{settled, turn_of};

impl Plan<'_> {
    /// Where particles would come to.
    #[must_use]
    pub fn wish(&self) -> Call<Wish> {
        Call {
            on: (),
            constants: WishConstants {
                border_reflects: self.border_reflects(),
                own_physarum: self.own_physarum,
                painted: self.means.painted,
                pulses: !self.shells.is_empty(),
                looks: self.has_looks(),
                mortal: self.is_mortal(),
                paths: self.means.paths,
            },
            params: WishParams {
                particle_count: self.particle_count(),
                salt: self.claim_salt(),
                attempts: self.settings.physarum.edge_crossing_attempts,
                pitch: self.setup.atlas.pitch,
                shell_count: self.shells.len() as u32,
                second_look: self.object_count(),
            },
        }
    }

    /// Particles claim cells.
    #[must_use]
    pub fn claim(&self, round: u32) -> Call<Claim> {
        Call {
            on: (),
            constants: ClaimConstants {
                mortal: self.is_mortal(),
                paths: self.means.paths,
            },
            params: ClaimParams {
                particle_count: self.particle_count(),
                round,
            },
        }
    }

    /// What winners leave is free.
    #[must_use]
    pub fn settle(&self, round: u32) -> Call<Settle> {
        Call {
            on: (),
            constants: SettleConstants {
                mortal: self.is_mortal(),
                paths: self.means.paths,
            },
            params: SettleParams {
                particle_count: self.particle_count(),
                round,
            },
        }
    }

    /// Winners move, and the others stay.
    #[must_use]
    pub fn arrive(&self) -> Call<Arrive> {
        Call {
            on: (),
            constants: ArriveConstants {
                selects: self.strategy != Strategy::None,
                food: self.has_food(),
                mortal: self.is_mortal(),
                hunger: self.is_hungry(),
                paths: self.means.paths,
            },
            params: ArriveParams {
                particle_count: self.particle_count(),
                seed: seed_word(self.settings.seed),
                time_step: self.time_step(),
                pitch: self.setup.atlas.pitch,
                transfer_capacity: self.means.capacity,
                transfer_threshold: self.lengths.threshold,
                fed_steps: self.settings.feeding.fed_steps,
                fed_deposit: self.settings.feeding.fed_deposit,
            },
        }
    }

    /// Particles that come over claim cells.
    #[must_use]
    pub fn land_claim(&self) -> Call<LandClaim> {
        Call {
            on: (),
            constants: LandClaimConstants {
                paths: self.means.paths,
            },
            params: LandClaimParams {
                capacity: self.means.capacity,
                salt: self.claim_salt(),
                pitch: self.setup.atlas.pitch,
            },
        }
    }

    /// Those that have won none stay on their objects.
    #[must_use]
    pub fn land_settle(&self) -> Call<LandSettle> {
        Call {
            on: (),
            constants: LandSettleConstants {
                paths: self.means.paths,
            },
            params: LandSettleParams {
                capacity: self.means.capacity,
                salt: self.claim_salt(),
                seed: seed_word(self.settings.seed),
                time_step: self.time_step(),
                object_count: self.object_count(),
            },
        }
    }

    /// Makes ranks differ from step to step.
    fn claim_salt(&self) -> u32 {
        let seed = seed_word(self.settings.seed);
        random(seed, 0, self.time_step(), Purpose::Claim)[0]
    }
}

impl StepKernel for Wish {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> WishArgs<'s> {
        let crowd = s.crowd();
        WishArgs {
            particles: &s.particles.texels,
            motions: &s.motions.texels,
            wishes: &crowd.wishes.texels,
            wish_motions: &crowd.motions.texels,
            claims: &crowd.claims.texels,
            strips: &s.surface.strips,
            physarums: &s.objects.physarums,
            homes: s.homes(),
            cells: &crowd.cells,
            bias: s.bias.as_ref(),
            looks: s.looks.as_ref(),
            shells: &s.objects.shells,
            corners: &s.surface.corners,
            vertices: &s.surface.vertices,
            poses: &s.objects.poses.texels,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        let setup = &a.setup;
        wish(
            &call.constants,
            &call.params,
            &AdvanceInputs {
                poses: &a.poses,
                bias: &a.bias,
                shells: &a.shells,
                looks: &a.weights,
                homes: &setup.homes,
                ..AdvanceInputs::of_surface(setup, &a.physarums)
            },
            (&a.particles, &a.motions),
            (&mut a.wishes, &mut a.wish_motions),
            &mut a.claims,
            &mut a.cells,
        );
    }
}

impl StepKernel for Claim {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> ClaimArgs<'s> {
        let crowd = s.crowd();
        ClaimArgs {
            claims: &crowd.claims.texels,
            cells: &crowd.cells,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        claim(&call.constants, &call.params, &mut a.claims, &mut a.cells);
    }
}

impl StepKernel for Settle {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> SettleArgs<'s> {
        let crowd = s.crowd();
        SettleArgs {
            claims: &crowd.claims.texels,
            cells: &crowd.cells,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        settle(&call.constants, &call.params, &a.claims, &mut a.cells);
    }
}

impl StepKernel for Arrive {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> ArriveArgs<'s> {
        let (crowd, food) = (s.crowd(), s.food.as_ref());
        ArriveArgs {
            particles: &s.particles.texels,
            motions: &s.motions.texels,
            wishes: &crowd.wishes.texels,
            wish_motions: &crowd.motions.texels,
            claims: &crowd.claims.texels,
            strips: &s.surface.strips,
            cells: &crowd.cells,
            deposits: &s.deposits.front,
            distances: &s.near.distances.texels,
            flow: &s.transfers.flow,
            particle_indices: &s.transfers.particle_indices,
            plates: food.map(|food| &food.plates),
            meals: food.map(|food| &food.meals),
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        let setup = &a.setup;
        let t = &mut a.transfers;
        arrive(
            &call.constants,
            &call.params,
            &AdvanceInputs {
                distances: &a.distances,
                plates: &setup.food_set.plates,
                ..AdvanceInputs::of_surface(setup, &a.physarums)
            },
            (&mut a.particles, &mut a.motions),
            (&a.wishes, &a.wish_motions),
            (&a.claims, &a.cells),
            (&mut t.flow[0], &mut t.particle_indices),
            &mut a.meals,
            &mut a.deposits,
        );
    }
}

impl StepKernel for LandClaim {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> LandClaimArgs<'s> {
        LandClaimArgs {
            transfers: &s.transfers.transfers,
            flow: &s.transfers.flow,
            particles: &s.particles.texels,
            strips: &s.surface.strips,
            homes: s.homes(),
            cells: &s.crowd().cells,
            triangles: &s.surface.triangles,
            corners: &s.surface.corners,
            vertices: &s.surface.vertices,
            poses: &s.objects.poses.texels,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        land_claim(
            &call.params,
            &Ground::of(&a.setup, &a.poses),
            &AdvanceInputs {
                homes: &a.setup.homes,
                ..AdvanceInputs::of_surface(&a.setup, &a.physarums)
            },
            &a.transfers.flow[0],
            &a.particles,
            &mut a.transfers.transfers,
            &mut a.cells,
        );
    }
}

impl StepKernel for LandSettle {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> LandSettleArgs<'s> {
        LandSettleArgs {
            transfers: &s.transfers.transfers,
            flow: &s.transfers.flow,
            particles: &s.particles.texels,
            motions: &s.motions.texels,
            cells: &s.crowd().cells,
            flux: &s.transfers.flux,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        let t = &mut a.transfers;
        land_settle(
            &call.params,
            &t.flow[0],
            (&a.particles, &mut a.motions),
            &a.cells,
            &mut t.transfers,
            &mut t.flux,
        );
    }
}

/// Twin of `shaders/wish.comp`.
pub fn wish(
    constants: &WishConstants,
    params: &WishParams,
    inputs: &AdvanceInputs,
    (particles, motions): (&[Particle], &[Motion]),
    (wishes, wish_motions): (&mut [Particle], &mut [Motion]),
    claims: &mut [UVec4],
    cells: &mut [u32],
) {
    let walking = Walking {
        attempts: params.attempts,
        own_physarum: constants.own_physarum,
        border_reflects: constants.border_reflects,
        pitch: params.pitch,
        bias: constants.painted.then_some(inputs.bias),
        shells: if constants.pulses {
            &inputs.shells[..params.shell_count as usize]
        } else {
            &[]
        },
    };
    let texel_of = |triangle: u32, u: f32, v: f32| {
        texel_at(inputs.position_of(triangle, [u, v]), params.pitch)
    };
    for slot in 0..params.particle_count as usize {
        let (particle, motion) = (&particles[slot], &motions[slot]);
        if constants.mortal && motion.is_dead() {
            claims[slot] = UVec4::new(0, 0, NO_RANK, 0);
            continue;
        }
        let texel = texel_of(particle.triangle, particle.u, particle.v);
        let own_cell = inputs.homes[texel as usize];
        let cell = &mut cells[own_cell as usize];
        let rank = rank_of(particle.id, params.salt);
        *cell = match is_taken(*cell) {
            true => SHARED_CELL,
            false => taken_by(rank),
        };
        let own = own_parameters(
            constants.own_physarum,
            constants.looks.then_some(params.second_look),
            inputs,
            particle,
            params.pitch,
        );
        let (w, pending) = walking.whole(inputs, &own, (particle, motion));
        wishes[slot] = Particle {
            triangle: w.triangle,
            u: w.u,
            v: w.v,
            id: particle.id,
        };
        wish_motions[slot] = Motion {
            heading_p: settled(w.heading[0]),
            heading_h: settled(w.heading[1]),
            pending,
            flags: 0,
        };
        let texel = texel_of(w.triangle, w.u, w.v);
        claims[slot] = UVec4::new(inputs.homes[texel as usize], own_cell, rank, texel);
    }
}

/// Twin of `shaders/claim.comp`.
pub fn claim(
    constants: &ClaimConstants,
    params: &ClaimParams,
    claims: &mut [UVec4],
    cells: &mut [u32],
) {
    for claim in &mut claims[..params.particle_count as usize] {
        if constants.mortal && claim.z == NO_RANK {
            continue;
        }
        if claim.z == REFUSED {
            continue;
        }
        let cell = &mut cells[claim.x as usize];
        if params.round == 0 && comes_too_early(claim.z, *cell) {
            claim.z = REFUSED;
            continue;
        }
        *cell = (*cell).min(claim_of(claim.z, params.round));
    }
}

/// Twin of `shaders/settle.comp`.
pub fn settle(
    constants: &SettleConstants,
    params: &SettleParams,
    claims: &[UVec4],
    cells: &mut [u32],
) {
    for claim in &claims[..params.particle_count as usize] {
        if constants.mortal && claim.z == NO_RANK {
            continue;
        }
        let left = claim.y as usize;
        if cells[claim.x as usize] == claim_of(claim.z, params.round)
            && cells[left] == taken_by(claim.z)
        {
            cells[left] = FREE;
        }
    }
}

/// Twin of `shaders/arrive.comp`.
#[expect(clippy::too_many_arguments, reason = "those of the kernel")]
pub fn arrive(
    constants: &ArriveConstants,
    params: &ArriveParams,
    inputs: &AdvanceInputs,
    (particles, motions): (&mut [Particle], &mut [Motion]),
    (wishes, wish_motions): (&[Particle], &[Motion]),
    (claims, cells): (&[UVec4], &[u32]),
    (flow, particle_indices): (&mut Flow, &mut [u32]),
    meals: &mut [Meal],
    deposits: &mut [u32],
) {
    let particle_indices = &mut particle_indices[..params.transfer_capacity as usize];
    for slot in 0..params.particle_count as usize {
        let arriving = Arriving {
            food: constants.food,
            hunger: constants.hunger,
            fed_steps: params.fed_steps,
            fed_deposit: params.fed_deposit,
            plates: inputs.plates,
            meals,
            distances: inputs.distances,
            threshold: params.transfer_threshold,
            pitch: params.pitch,
        };
        let (particle, claim) = (particles[slot], claims[slot]);
        if constants.mortal && claim.z == NO_RANK {
            continue;
        }
        let word = cells[claim.x as usize];
        let before = motions[slot].flags;
        let previous = inputs.position_of(particle.triangle, [particle.u, particle.v]);
        if claim.x == claim.y || is_won(word, claim.z) {
            let moved = wishes[slot];
            let position = inputs.position_of(moved.triangle, [moved.u, moved.v]);
            let arrival = arriving.at(previous, position, before, constants.selects);
            particles[slot] = moved;
            motions[slot] = Motion {
                flags: arrival.flags(),
                ..wish_motions[slot]
            };
            arrival.note(slot, flow, particle_indices, meals, deposits);
            continue;
        }
        if word == FREE && claim.z != REFUSED {
            flow.left_over = flow.left_over.saturating_add(1);
        }
        let mut flags = Motion::STAYED;
        if constants.food {
            let texel = texel_at(previous, params.pitch) as usize;
            let (fed_flags, meal) = arriving.fed_flags(texel, before);
            flags |= fed_flags;
            if let Some(meal) = meal {
                meals[meal].eaten += 1;
            }
        }
        let words = random(params.seed, particle.id, params.time_step, Purpose::Refused);
        let heading = turn_of(words[0]);
        motions[slot] = Motion {
            heading_p: heading.x,
            heading_h: heading.y,
            pending: 0.0,
            flags,
        };
    }
}

/// Twin of `shaders/land_claim.comp`.
pub fn land_claim(
    params: &LandClaimParams,
    ground: &Ground,
    inputs: &AdvanceInputs,
    flow: &Flow,
    particles: &[Particle],
    transfers: &mut [Transfer],
    cells: &mut [u32],
) {
    for transfer in &mut transfers[..flow.leaving.min(params.capacity) as usize] {
        if transfer.source == transfer.target {
            continue;
        }
        let flight = Flight {
            position: transfer.position,
            heading: transfer.heading,
            normal: transfer.normal,
        };
        let ([u, v], _) = ground.landing(transfer.triangle, &flight);
        let map = &inputs.strips[transfer.triangle as usize].map;
        let position = atlas_position(map, u, v);
        transfer.cell = inputs.homes[texel_at(position, params.pitch) as usize];
        let id = particles[transfer.particle as usize].id;
        let cell = &mut cells[transfer.cell as usize];
        *cell = (*cell).min(claim_of(rank_of(id, params.salt), LANDING));
    }
}

/// Twin of `shaders/land_settle.comp`.
pub fn land_settle(
    params: &LandSettleParams,
    flow: &Flow,
    (particles, motions): (&[Particle], &mut [Motion]),
    cells: &[u32],
    transfers: &mut [Transfer],
    flux: &mut [u32],
) {
    for transfer in &mut transfers[..flow.leaving.min(params.capacity) as usize] {
        let slot = transfer.particle as usize;
        let id = particles[slot].id;
        let (source, target) = (transfer.source, transfer.target);
        let comes = source != target;
        let claim = claim_of(rank_of(id, params.salt), LANDING);
        if comes && cells[transfer.cell as usize] == claim {
            continue;
        }
        transfer.stays = 1;
        if comes {
            transfer.target = source;
            let left = &mut flux[(source * params.object_count + target) as usize];
            *left = left.wrapping_sub(1);
            let returned = &mut flux[(source * params.object_count + source) as usize];
            *returned = returned.saturating_add(1);
        }
        let words = random(params.seed, id, params.time_step, Purpose::Refused);
        let heading = turn_of(words[1]);
        motions[slot] = Motion {
            heading_p: heading.x,
            heading_h: heading.y,
            pending: 0.0,
            flags: motions[slot].flags & !Motion::SELECTED,
        };
    }
}
