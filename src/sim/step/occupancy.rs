//! The kernels by which particles walk, one a cell: their parameters, bindings and twins.
//!
//! Every particle takes its cell, and claims the one that it would come to. Of those that claim a cell the lowest rank wins,
//! once the cell is empty: a particle in it must win its own cell first, and have a lower rank. So it ends as if particles moved one after
//! the other by their ranks, but for rows of particles that are longer than there are rounds. Those that have won nothing stay. Particles
//! that come over from other objects claim the cells that are free after that. A cell that a particle of its object claims counts as taken,
//! also where that particle lacks a round and stays.

use glam::UVec4;

use crate::rng::{Purpose, random, seed_word};
use crate::scene::settings::Strategy;
use crate::sim::arrays::Arrays;
use crate::sim::claims::{Claimed, LANDING, NO_RANK, SHARED, may_come, rank_of};
use crate::sim::field::{atlas_position, texel_at};
use crate::sim::ground::{Flight, Ground};
use crate::sim::kernels::{
    Arrive, ArriveArgs, ArriveConstants, ArriveParams, Claim, ClaimArgs, ClaimConstants,
    ClaimParams, LandClaim, LandClaimArgs, LandClaimConstants, LandClaimParams, LandSettle,
    LandSettleArgs, LandSettleConstants, LandSettleParams, Wish, WishArgs, WishConstants,
    WishParams,
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
                food: self.has_food(),
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
    pub fn claim(&self) -> Call<Claim> {
        Call {
            on: (),
            constants: ClaimConstants {
                mortal: self.is_mortal(),
                paths: self.means.paths,
            },
            params: ClaimParams {
                particle_count: self.particle_count(),
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
                rounds: self.rules.rounds,
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
                rounds: self.rules.rounds,
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
            motions_before: &s.motions.texels,
            wishes: &crowd.wishes.texels,
            claims: &crowd.claims.texels,
            strips: &s.surface.strips,
            physarums: &s.objects.physarums,
            homes: s.homes(),
            cells: &crowd.cells,
            goals: &crowd.goals,
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
            (&a.particles, &mut a.motions),
            (&mut a.wishes, &mut a.claims),
            (&mut a.cells, &mut a.goals),
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
            bids: &crowd.bids,
            goals: &crowd.goals,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        claim(
            &call.constants,
            &call.params,
            &a.claims,
            &a.cells,
            (&mut a.bids, &mut a.goals),
        );
    }
}

impl StepKernel for Arrive {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> ArriveArgs<'s> {
        let (crowd, food) = (s.crowd(), s.food.as_ref());
        ArriveArgs {
            particles: &s.particles.texels,
            motions: &s.motions.texels,
            particles_before: &s.particles.texels,
            motions_before: &s.motions.texels,
            wishes: &crowd.wishes.texels,
            claims: &crowd.claims.texels,
            strips: &s.surface.strips,
            cells: &crowd.cells,
            goals: &crowd.goals,
            bids: &crowd.bids,
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
            (&a.wishes, &a.claims),
            Claimed {
                cells: &a.cells,
                goals: &a.goals,
                bids: &a.bids,
            },
            (&mut t.flow[0], &mut t.particle_indices),
            &mut a.meals,
            &mut a.deposits,
        );
    }
}

impl StepKernel for LandClaim {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> LandClaimArgs<'s> {
        let crowd = s.crowd();
        LandClaimArgs {
            transfers: &s.transfers.transfers,
            flow: &s.transfers.flow,
            particles: &s.particles.texels,
            strips: &s.surface.strips,
            homes: s.homes(),
            cells: &crowd.cells,
            goals: &crowd.goals,
            bids: &crowd.bids,
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
            (&a.cells, &a.goals, &mut a.bids),
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
            bids: &s.crowd().bids,
            flux: &s.transfers.flux,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        let t = &mut a.transfers;
        land_settle(
            &call.params,
            &t.flow[0],
            (&a.particles, &mut a.motions),
            &a.bids,
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
    (particles, motions): (&[Particle], &mut [Motion]),
    (wishes, claims): (&mut [Particle], &mut [UVec4]),
    (cells, goals): (&mut [u32], &mut [u32]),
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
        let (particle, motion) = (particles[slot], motions[slot]);
        if constants.mortal && motion.is_dead() {
            claims[slot] = UVec4::new(0, 0, NO_RANK, 0);
            continue;
        }
        let own = own_parameters(
            constants.own_physarum,
            constants.looks.then_some(params.second_look),
            inputs,
            &particle,
            params.pitch,
        );
        let (w, pending) = walking.whole(inputs, &own, (&particle, &motion));
        wishes[slot] = Particle {
            triangle: w.triangle,
            u: w.u,
            v: w.v,
            id: particle.id,
        };
        motions[slot] = Motion {
            heading_p: settled(w.heading[0]),
            heading_h: settled(w.heading[1]),
            pending,
            flags: if constants.food { motion.flags } else { 0 },
        };

        let texel = texel_of(w.triangle, w.u, w.v);
        let goal = inputs.homes[texel as usize];
        let own_cell = inputs.homes[texel_of(particle.triangle, particle.u, particle.v) as usize];
        let rank = rank_of(particle.id, params.salt);
        claims[slot] = UVec4::new(goal, own_cell, rank, texel);
        cells[own_cell as usize] = rank;
        goals[own_cell as usize] = goal;
    }
}

/// Twin of `shaders/claim.comp`.
pub fn claim(
    constants: &ClaimConstants,
    params: &ClaimParams,
    claims: &[UVec4],
    cells: &[u32],
    (bids, goals): (&mut [u32], &mut [u32]),
) {
    for claim in &claims[..params.particle_count as usize] {
        if constants.mortal && claim.z == NO_RANK {
            continue;
        }
        if cells[claim.y as usize] != claim.z {
            goals[claim.y as usize] = SHARED;
        }
        if may_come(claim.z, cells[claim.x as usize]) {
            let bid = &mut bids[claim.x as usize];
            *bid = (*bid).min(claim.z);
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
    (wishes, claims): (&[Particle], &[UVec4]),
    claimed: Claimed<'_>,
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
        let claim = claims[slot];
        if constants.mortal && claim.z == NO_RANK {
            continue;
        }
        let (particle, moved) = (particles[slot], wishes[slot]);
        let before = motions[slot].flags;
        let previous = inputs.position_of(particle.triangle, [particle.u, particle.v]);
        let round = claimed.won_in(claim.x, claim.z, params.rounds + 1);
        if claim.x == claim.y || round.is_some_and(|round| round <= params.rounds) {
            let position = inputs.position_of(moved.triangle, [moved.u, moved.v]);
            let arrival = arriving.at(previous, position, before, constants.selects);
            particles[slot] = moved;
            motions[slot].flags = arrival.flags();
            arrival.note(slot, flow, particle_indices, meals, deposits);
            continue;
        }
        if round.is_some() {
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
    (cells, goals, bids): (&[u32], &[u32], &mut [u32]),
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
        let claimed = Claimed { cells, goals, bids };
        if !claimed.is_open(transfer.cell, params.rounds) {
            continue;
        }
        let rank = rank_of(particles[transfer.particle as usize].id, params.salt);
        let bid = &mut bids[transfer.cell as usize];
        *bid = (*bid).min(LANDING + rank);
    }
}

/// Twin of `shaders/land_settle.comp`.
pub fn land_settle(
    params: &LandSettleParams,
    flow: &Flow,
    (particles, motions): (&[Particle], &mut [Motion]),
    bids: &[u32],
    transfers: &mut [Transfer],
    flux: &mut [u32],
) {
    for transfer in &mut transfers[..flow.leaving.min(params.capacity) as usize] {
        let slot = transfer.particle as usize;
        let id = particles[slot].id;
        let (source, target) = (transfer.source, transfer.target);
        let comes = source != target;
        if comes && bids[transfer.cell as usize] == LANDING + rank_of(id, params.salt) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sim::claims::FREE;

    /// A particle: the cell that it is in, the one that it would come to, and its rank.
    #[derive(Clone, Copy)]
    struct Walker {
        cell: usize,
        goal: usize,
        rank: u32,
    }

    /// A random crowd on a ring of cells, and the number of these. In some all would come to the next cell, in others some to any; in some
    /// ranks fall along the ring, so that rows are long; some share a cell.
    fn crowd(case: u32) -> (usize, Vec<Walker>) {
        let mut drawn = 0;
        let mut below = |limit: u32| {
            drawn += 1;
            random(case, drawn, 0, Purpose::Claim)[0] % limit
        };
        let cells = 2 + below(23);
        let count = 1 + below(cells);
        let (is_straight, falls) = (below(2) == 0, below(2) == 0);
        let salt = below(u32::MAX);
        let mut ranks: Vec<u32> = (0..count).map(|id| rank_of(id, salt)).collect();
        if falls {
            ranks.sort_unstable();
            ranks.reverse();
        }
        let mut taken: Vec<u32> = (0..cells).collect();
        while taken.len() > ranks.len() {
            let left = below(taken.len() as u32);
            taken.remove(left as usize);
        }
        let mut walkers = Vec::new();
        for (cell, rank) in taken.into_iter().zip(ranks) {
            let goal = match is_straight || below(4) > 0 {
                true => (cell + 1) % cells,
                false => below(cells),
            };
            let cell = match is_straight || below(12) > 0 {
                true => cell,
                false => below(cells),
            };
            walkers.push(Walker {
                cell: cell as usize,
                goal: goal as usize,
                rank,
            });
        }
        (cells as usize, walkers)
    }

    /// The words of the cells after `wish` and `claim`: `cells`, `goals` and `bids`.
    fn words_of(cell_count: usize, walkers: &[Walker]) -> [Vec<u32>; 3] {
        let mut cells = vec![FREE; cell_count];
        let mut goals = vec![0; cell_count];
        let mut bids = vec![FREE; cell_count];
        let mut claims = Vec::new();
        for &Walker { cell, goal, rank } in walkers {
            claims.push(UVec4::new(goal as u32, cell as u32, rank, 0));
            goals[cell] = goal as u32;
            cells[cell] = rank;
        }
        let params = ClaimParams {
            particle_count: walkers.len() as u32,
        };
        let constants = ClaimConstants::default();
        claim(
            &constants,
            &params,
            &claims,
            &cells,
            (&mut bids, &mut goals),
        );
        [cells, goals, bids]
    }

    /// Walkers that move one after the other, or in rounds. What moves within its cell has moved from the beginning.
    struct Floor<'a> {
        walkers: &'a [Walker],
        /// The ranks that each cell held at the start.
        first: Vec<Vec<u32>>,
        /// How many are in each cell.
        inside: Vec<usize>,
        moved: Vec<bool>,
    }

    impl<'a> Floor<'a> {
        fn new(cell_count: usize, walkers: &'a [Walker]) -> Self {
            let mut first = vec![Vec::new(); cell_count];
            for walker in walkers {
                first[walker.cell].push(walker.rank);
            }
            Self {
                walkers,
                inside: first.iter().map(Vec::len).collect(),
                first,
                moved: (walkers.iter())
                    .map(|walker| walker.goal == walker.cell)
                    .collect(),
            }
        }

        /// Does it wait for a cell that is empty? A shared one stays taken to the end.
        fn may_move(&self, k: usize) -> bool {
            let goal = self.walkers[k].goal;
            !self.moved[k] && self.inside[goal] == 0 && self.first[goal].len() < 2
        }

        fn take(&mut self, k: usize) {
            let Walker { cell, goal, .. } = self.walkers[k];
            self.moved[k] = true;
            self.inside[cell] -= 1;
            self.inside[goal] += 1;
        }

        /// Of those that claim an empty cell the lowest rank has it; one that was left is for higher ranks than that in it.
        fn take_round(&mut self) {
            let claims = |&k: &usize| {
                let Walker { goal, rank, .. } = self.walkers[k];
                self.may_move(k) && self.first[goal].iter().all(|&before| rank > before)
            };
            let claiming: Vec<usize> = (0..self.walkers.len()).filter(claims).collect();
            for &k in &claiming {
                let Walker { goal, rank, .. } = self.walkers[k];
                let mut others = claiming.iter().map(|&other| self.walkers[other]);
                if others.all(|other| other.goal != goal || other.rank >= rank) {
                    self.take(k);
                }
            }
        }
    }

    fn by_rounds(cell_count: usize, walkers: &[Walker], rounds: u32) -> Vec<bool> {
        let mut floor = Floor::new(cell_count, walkers);
        for _ in 0..rounds {
            floor.take_round();
        }
        floor.moved
    }

    fn one_by_one(cell_count: usize, walkers: &[Walker]) -> Vec<bool> {
        let mut floor = Floor::new(cell_count, walkers);
        let mut order: Vec<usize> = (0..walkers.len()).collect();
        order.sort_unstable_by_key(|&k| walkers[k].rank);
        for k in order {
            if floor.may_move(k) {
                floor.take(k);
            }
        }
        floor.moved
    }

    /// Would catch: a rule of claims by which other particles move than in rounds that are carried out, or than one after the other where
    /// there are rounds enough; and a number of particles that lack one round which is not that of those that the round lets move.
    #[test]
    fn particles_move_as_in_rounds_and_as_one_after_the_other() {
        const ROUNDS: [u32; 3] = [1, 3, 14];
        let mut left_over = [0_usize; 3];
        let (mut shared, mut full) = (0, 0);
        for case in 0..3000 {
            let (cell_count, walkers) = crowd(case);
            let [cells, goals, bids] = words_of(cell_count, &walkers);
            let claimed = Claimed {
                cells: &cells,
                goals: &goals,
                bids: &bids,
            };
            // What moves within its own cell needs no round.
            let round_of = |walker: &Walker, rounds: u32| match walker.goal == walker.cell {
                true => Some(0),
                false => claimed.won_in(walker.goal as u32, walker.rank, rounds),
            };
            let moved = |rounds: u32| -> Vec<bool> {
                let rounds = walkers.iter().map(|walker| round_of(walker, rounds));
                rounds.map(|round| round.is_some()).collect()
            };
            for (rounds, left_over) in ROUNDS.into_iter().zip(&mut left_over) {
                let ends =
                    [rounds, rounds + 1].map(|rounds| by_rounds(cell_count, &walkers, rounds));
                assert_eq!(moved(rounds), ends[0], "case {case}, {rounds} rounds");
                let more = ends.map(|end| end.into_iter().filter(|&moved| moved).count());
                let last = Some(rounds + 1);
                let lacking = walkers
                    .iter()
                    .filter(|&walker| round_of(walker, rounds + 1) == last);
                let lacking = lacking.count();
                assert_eq!(lacking, more[1] - more[0], "case {case}, {rounds} rounds");
                *left_over += lacking;
            }
            // No row is longer than there are particles.
            let end = one_by_one(cell_count, &walkers);
            assert_eq!(moved(walkers.len() as u32), end, "case {case}");
            shared += usize::from(goals.contains(&SHARED));
            full += usize::from(!cells.contains(&FREE));
        }
        // Rows are longer than the rounds in some, even than the most; some have shared cells, and in some all are taken.
        assert!(
            left_over.into_iter().all(|count| count > 5),
            "{left_over:?}"
        );
        assert!(shared > 200 && full > 200, "{shared}, {full}");
    }
}
