//! The kernels by which particles walk, one a cell: their parameters, bindings and twins.
//!
//! Every particle takes its cell, senses, turns, walks, and claims the cell that it would come to; `shaders/include/claims.glsl` says which
//! claim wins. Those that have won nothing stay. Particles that come over from other objects claim the cells that are free after that. A cell
//! that a particle of its object claims counts as taken, also where that particle lacks a round, or its rank is too low, and stays.

use glam::UVec4;
use rayon::prelude::*;

use crate::rng::{Purpose, random, seed_word};
use crate::scene::settings::Strategy;
use crate::sim::arrays::Arrays;
use crate::sim::claims::{self, Claimed, LANDING, rank_of};
use crate::sim::field::{atlas_position, texel_at};
use crate::sim::ground::{Flight, Ground};
use crate::sim::kernels::{
    Advance, AdvanceConstants, AdvanceParams, Arrive, ArriveArgs, ArriveConstants, ArriveParams,
    LandClaim, LandClaimArgs, LandClaimConstants, LandClaimParams, LandSettle, LandSettleArgs,
    LandSettleConstants, LandSettleParams, Wish, WishArgs, WishConstants, WishParams,
};
use crate::sim::plan::Plan;
use crate::sim::state::State;
use crate::sim::step::advance::{AdvanceInputs, Arriving, Form, Terms, Walked, walked};
use crate::sim::types::{Flow, Meal, Motion, Particle, Transfer};
use crate::sim::work::{Call, StepKernel};
use crate::strict::turn_of;

/// The specialization constants that `advance` and `wish` share, and others.
macro_rules! constants_of_turns {
    ($Constants:ident, $from:expr, $($others:tt)*) => {
        $Constants {
            border_reflects: $from.border_reflects,
            own_physarum: $from.own_physarum,
            across: $from.across,
            sensing: $from.sensing,
            painted: $from.painted,
            food: $from.food,
            pulses: $from.pulses,
            looks: $from.looks,
            random_ties: $from.random_ties,
            random_turns: $from.random_turns,
            mortal: $from.mortal,
            sensor_noise: $from.sensor_noise,
            favourite_density: $from.favourite_density,
            gravity: $from.gravity,
            decrowding: $from.decrowding,
            distance: $from.distance,
            cells: $from.cells,
            reach: $from.reach,
            sensitivity: $from.sensitivity,
            paths: $from.paths,
            $($others)*
        }
    };
}

/// The parameters that they share, and others.
macro_rules! params_of_turns {
    ($Params:ident, $from:expr, $($others:tt)*) => {
        $Params {
            particle_count: $from.particle_count,
            seed: $from.seed,
            time_step: $from.time_step,
            attempts: $from.attempts,
            pitch: $from.pitch,
            transfer_threshold: $from.transfer_threshold,
            deepest: $from.deepest,
            last_texel: $from.last_texel,
            walker_rows: $from.walker_rows,
            fed_attraction: $from.fed_attraction,
            outlook_unit: $from.outlook_unit,
            shell_count: $from.shell_count,
            second_look: $from.second_look,
            sensor_share: $from.sensor_share,
            sensitivity: $from.sensitivity,
            random_turn: $from.random_turn,
            may_turn: $from.may_turn,
            $($others)*
        }
    };
}

impl Plan<'_> {
    /// `wish`, or a form of it: particles sense, turn and walk to where they would come to.
    #[must_use]
    pub fn wish(&self, terms: Terms, form: Form) -> Call<Wish> {
        let Call {
            constants, params, ..
        } = self.advance(terms, form);
        Call {
            on: form,
            constants: constants_of_turns!(WishConstants, constants, apart: self.means.apart),
            params: params_of_turns!(WishParams, params, salt: self.claim_salt()),
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
                salt: self.claim_salt(),
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
    type On = Form;

    fn name(form: Form) -> &'static str {
        match form {
            Form::All => "wish",
            _ => Advance::name(form),
        }
    }

    fn args<'s>(call: &Call<Self>, s: &'s State) -> WishArgs<'s> {
        let crowd = s.crowd();
        WishArgs {
            particles_before: &s.particles.texels,
            motions: &s.motions.texels,
            motions_before: &s.motions.texels,
            wishes: &crowd.wishes.texels,
            claims: &crowd.claims.texels,
            strips: &s.surface.strips,
            physarums: &s.objects.physarums,
            homes: s.homes(),
            goals: &crowd.goals,
            bids: &crowd.bids,
            bias: s.bias.as_ref(),
            looks: s.looks.as_ref(),
            shells: &s.objects.shells,
            corners: &s.surface.corners,
            vertices: &s.surface.vertices,
            poses: &s.objects.poses.texels,
            trail: &s.trail.front,
            previous_deposits: &s.deposits.back,
            distances: &s.near.distances.texels,
            across: &s.across.places.texels,
            across_triangles: &s.across.triangles.texels,
            surroundings: &s.across.surroundings.texels,
            scent: s.food.as_ref().map(|food| food.sensed()),
            walkers: &s.walkers.slots.texels,
            walkers_near: &s.walkers.near.texels,
            walker_count: &s.walkers.count,
            // The forms for listed particles list no others: no dispatch may write its own groups.
            walker_groups: match call.on {
                Form::All => Some(&s.walkers.groups),
                _ => None,
            },
        }
    }

    /// The first form processes every particle, and the others have none.
    fn twin(call: &Call<Self>, a: &mut Arrays) {
        if call.on != Form::All {
            return;
        }
        let wished = wished(&call.constants, &call.params, a);
        for (slot, wished) in wished.into_iter().enumerate() {
            let Some((walked, claim)) = wished else {
                a.claims[slot] = UVec4::ZERO;
                continue;
            };
            if let Some(form) = walked.form {
                a.forms[form] += 1;
            }
            let flags = if call.constants.food {
                walked.motion.flags
            } else {
                0
            };
            a.motions[slot] = Motion {
                flags,
                ..walked.motion
            };
            a.wishes[slot] = walked.particle;
            a.claims[slot] = claim;
            let cells = (&mut a.goals[..], &mut a.bids[..]);
            claims::claim(claim.y, claim.x, call.params.salt, cells);
        }
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
                goals: &a.goals,
                bids: &a.bids,
                salt: call.params.salt,
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
            (&a.goals, &mut a.bids),
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
            &mut t.flow[0],
            (&a.particles, &mut a.motions),
            &a.bids,
            &mut t.transfers,
            &mut t.flux,
        );
    }
}

/// Where each particle would come to, and its claim; `None` if it is dead. Twin of `shaders/wish.comp`.
fn wished(
    constants: &WishConstants,
    params: &WishParams,
    a: &Arrays,
) -> Vec<Option<(Walked, UVec4)>> {
    let inputs = AdvanceInputs::of_arrays(a);
    let of_turns = constants_of_turns!(AdvanceConstants, constants, selects: false, hunger: false);
    let with =
        params_of_turns!(AdvanceParams, params, transfer_capacity: 0, fed_steps: 0, fed_deposit: 0);
    let cell_at = |at: &Particle| {
        let position = inputs.position_of(at.triangle, [at.u, at.v]);
        let texel = texel_at(position, params.pitch);
        (inputs.homes[texel as usize], texel)
    };
    (0..params.particle_count as usize)
        .into_par_iter()
        .map(|slot| {
            let (particle, motion) = (&a.particles[slot], &a.motions[slot]);
            if constants.mortal && motion.is_dead() {
                return None;
            }
            let walked = walked(&of_turns, &with, &inputs, (particle, motion));
            let (goal, texel) = cell_at(&walked.particle);
            let (cell, _) = cell_at(particle);
            Some((walked, UVec4::new(goal, cell, texel, 1)))
        })
        .collect()
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
        let [goal, cell, _, is_alive] = claims[slot].to_array();
        if constants.mortal && is_alive == 0 {
            continue;
        }
        let (particle, moved) = (particles[slot], wishes[slot]);
        let before = motions[slot].flags;
        let previous = inputs.position_of(particle.triangle, [particle.u, particle.v]);
        let round = claimed.won_in(cell, goal, params.rounds + 1);
        if goal == cell || round.is_some_and(|round| round <= params.rounds) {
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
    (goals, bids): (&[u32], &mut [u32]),
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
        let claimed = Claimed {
            goals,
            bids,
            salt: params.salt,
        };
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
    flow: &mut Flow,
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
        if transfer.stays == 2 {
            flow.crossed = flow.crossed.wrapping_sub(1);
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
    use crate::sim::claims::{FREE, SHARED, claim_of};

    /// A particle: the cell that it is in, and the one that it would come to.
    #[derive(Clone, Copy)]
    struct Walker {
        cell: usize,
        goal: usize,
    }

    /// Walkers on a ring of cells.
    struct Crowd {
        cell_count: usize,
        salt: u32,
        walkers: Vec<Walker>,
    }

    /// A random crowd. In some all would come to the next cell, in others some to any; in some ranks fall along the ring, so that rows are
    /// long; some share a cell.
    fn crowd(case: u32) -> Crowd {
        let mut drawn = 0;
        let mut below = |limit: u32| {
            drawn += 1;
            random(case, drawn, 0, Purpose::Claim)[0] % limit
        };
        let cell_count = 2 + below(23);
        let count = 1 + below(cell_count);
        let (is_straight, falls) = (below(2) == 0, below(2) == 0);
        let salt = below(u32::MAX);
        let mut ring: Vec<u32> = (0..cell_count).collect();
        if falls {
            ring.sort_unstable_by_key(|&cell| u32::MAX - rank_of(cell, salt));
        }
        let mut taken: Vec<u32> = (0..cell_count).collect();
        while taken.len() > count as usize {
            let left = below(taken.len() as u32);
            taken.remove(left as usize);
        }
        let mut walkers = Vec::new();
        for place in taken {
            let goal = match is_straight || below(4) > 0 {
                true => (place + 1) % cell_count,
                false => below(cell_count),
            };
            let place = match is_straight || below(12) > 0 {
                true => place,
                false => below(cell_count),
            };
            let [cell, goal] = [place, goal].map(|place| ring[place as usize] as usize);
            walkers.push(Walker { cell, goal });
        }
        Crowd {
            cell_count: cell_count as usize,
            salt,
            walkers,
        }
    }

    impl Crowd {
        /// The words of the cells after `wish`: `goals` and `bids`.
        fn words(&self) -> [Vec<u32>; 2] {
            let mut goals = vec![FREE; self.cell_count];
            let mut bids = vec![FREE; self.cell_count];
            for &Walker { cell, goal } in &self.walkers {
                let words = (&mut goals[..], &mut bids[..]);
                claims::claim(cell as u32, goal as u32, self.salt, words);
            }
            [goals, bids]
        }

        fn rank(&self, cell: usize) -> u32 {
            rank_of(cell as u32, self.salt)
        }

        /// Do no others that would come to the same cell come before it?
        fn is_first(&self, walker: Walker, mut others: impl Iterator<Item = Walker>) -> bool {
            let there = self.rank(walker.goal);
            let claim = |walker: Walker| claim_of(self.rank(walker.cell), there);
            others.all(|other| other.goal != walker.goal || claim(other) >= claim(walker))
        }
    }

    /// Walkers that move one after the other, or in rounds. What moves within its cell has moved from the beginning.
    struct Floor<'a> {
        crowd: &'a Crowd,
        /// How many each cell held at the start.
        first: Vec<usize>,
        /// How many are in each cell.
        inside: Vec<usize>,
        moved: Vec<bool>,
    }

    impl<'a> Floor<'a> {
        fn new(crowd: &'a Crowd) -> Self {
            let mut first = vec![0; crowd.cell_count];
            for walker in &crowd.walkers {
                first[walker.cell] += 1;
            }
            Self {
                crowd,
                inside: first.clone(),
                first,
                moved: (crowd.walkers.iter())
                    .map(|walker| walker.goal == walker.cell)
                    .collect(),
            }
        }

        /// Does it wait for a cell that is empty? A shared one stays taken to the end.
        fn may_move(&self, k: usize) -> bool {
            let goal = self.crowd.walkers[k].goal;
            !self.moved[k] && self.inside[goal] == 0 && self.first[goal] < 2
        }

        fn take(&mut self, k: usize) {
            let Walker { cell, goal } = self.crowd.walkers[k];
            self.moved[k] = true;
            self.inside[cell] -= 1;
            self.inside[goal] += 1;
        }

        /// Of those that claim an empty cell the lowest claim has it; one that was left is for higher ranks than its own.
        fn take_round(&mut self) {
            let crowd = self.crowd;
            let claims = |&k: &usize| {
                let Walker { cell, goal } = crowd.walkers[k];
                self.may_move(k) && (self.first[goal] == 0 || crowd.rank(cell) > crowd.rank(goal))
            };
            let claiming: Vec<usize> = (0..crowd.walkers.len()).filter(claims).collect();
            for &k in &claiming {
                let others = claiming.iter().map(|&other| crowd.walkers[other]);
                if crowd.is_first(crowd.walkers[k], others) {
                    self.take(k);
                }
            }
        }
    }

    fn by_rounds(crowd: &Crowd, rounds: u32) -> Vec<bool> {
        let mut floor = Floor::new(crowd);
        for _ in 0..rounds {
            floor.take_round();
        }
        floor.moved
    }

    /// Those in one cell move at once, by the rank of the cell. Of those that would come to a cell which was empty only the first one does.
    fn one_by_one(crowd: &Crowd) -> Vec<bool> {
        let mut floor = Floor::new(crowd);
        let mut order: Vec<usize> = (0..crowd.cell_count).collect();
        order.sort_unstable_by_key(|&cell| crowd.rank(cell));
        for cell in order {
            let moves = |&k: &usize| {
                let walker = crowd.walkers[k];
                let comes = floor.first[walker.goal] > 0
                    || crowd.is_first(walker, crowd.walkers.iter().copied());
                walker.cell == cell && floor.may_move(k) && comes
            };
            let moving: Vec<usize> = (0..crowd.walkers.len()).filter(moves).collect();
            for k in moving {
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
            let crowd = crowd(case);
            let [goals, bids] = crowd.words();
            let claimed = Claimed {
                goals: &goals,
                bids: &bids,
                salt: crowd.salt,
            };
            // What moves within its own cell needs no round.
            let round_of = |walker: &Walker, rounds: u32| match walker.goal == walker.cell {
                true => Some(0),
                false => claimed.won_in(walker.cell as u32, walker.goal as u32, rounds),
            };
            let moved = |rounds: u32| -> Vec<bool> {
                let rounds = crowd.walkers.iter().map(|walker| round_of(walker, rounds));
                rounds.map(|round| round.is_some()).collect()
            };
            for (rounds, left_over) in ROUNDS.into_iter().zip(&mut left_over) {
                let ends = [rounds, rounds + 1].map(|rounds| by_rounds(&crowd, rounds));
                assert_eq!(moved(rounds), ends[0], "case {case}, {rounds} rounds");
                let more = ends.map(|end| end.into_iter().filter(|&moved| moved).count());
                let last = Some(rounds + 1);
                let lacking =
                    (crowd.walkers.iter()).filter(|&walker| round_of(walker, rounds + 1) == last);
                let lacking = lacking.count();
                assert_eq!(lacking, more[1] - more[0], "case {case}, {rounds} rounds");
                *left_over += lacking;
            }
            // No row is longer than there are particles.
            let most = crowd.walkers.len() as u32;
            assert_eq!(moved(most), one_by_one(&crowd), "case {case}");
            shared += usize::from(goals.contains(&SHARED));
            full += usize::from(!goals.contains(&FREE));
        }
        // Rows are longer than the rounds in some, even than the most; some have shared cells, and in some all are taken.
        assert!(
            left_over.into_iter().all(|count| count > 5),
            "{left_over:?}"
        );
        assert!(shared > 200 && full > 200, "{shared}, {full}");
    }
}
