//! The kernels by which a population grows and shrinks: their parameters, bindings and twins.
//!
//! A slot and an id stay together for good, and a particle that is dead is a slot that waits. Those that divide claim cells; those that
//! have won are numbered by their ids, as are the dead, and number by number a dead particle's id goes to a particle that is born. So ids
//! never collide, and neither the order of slots nor that of invocations shows. If fewer are dead than divide, numbers begin at another
//! particle in each step.
//!
//! Where objects have windows of the particle buffer, a dead particle lies in the window of the object on which it died, so deaths change
//! no window. A birth on another object changes two, and [`windows`](super::windows) puts the buffer in order at the end of the step.
//!
//! **Invariant:** births minus deaths is the change of the number of living particles.

use crate::mesh::surface::NONE;
use crate::rng::{Purpose, random, seed_word, unit};
use crate::scene::settings::Strategy;
use crate::sim::arrays::Arrays;
use crate::sim::cells::birthplace;
use crate::sim::claims::rank_of;
use crate::sim::field::texel_at;
use crate::sim::kernels::{
    CountCells, CountCellsArgs, CountCellsConstants, CountCellsParams, Divide, DivideArgs,
    DivideBegin, DivideBeginArgs, DivideBeginConstants, DivideBeginParams, DivideConstants,
    DivideList, DivideListArgs, DivideListParams, DivideNumber, DivideNumberArgs,
    DivideNumberParams, DivideParams, DivideSettle, DivideSettleArgs, DivideSettleConstants,
    DivideSettleParams,
};
use crate::sim::paint::NO_GO_BELOW;
use crate::sim::plan::Plan;
use crate::sim::state::State;
use crate::sim::step::advance::AdvanceInputs;
use crate::sim::types::{Border, Motion, Particle, Population};
use crate::sim::work::{Call, StepKernel};
use crate::strict::turn_of;

impl Plan<'_> {
    /// Counts the particles in each cell.
    #[must_use]
    pub fn count_cells(&self) -> Call<CountCells> {
        Call {
            on: (),
            constants: CountCellsConstants {
                paths: self.means.paths,
            },
            params: CountCellsParams {
                particle_count: self.particle_count(),
                pitch: self.setup.atlas.pitch,
            },
        }
    }

    /// Particles die, or claim cells to divide into.
    #[must_use]
    pub fn divide(&self) -> Call<Divide> {
        let population = &self.settings.population;
        let reach = |window: u32| (window / 2) as i32;
        Call {
            on: (),
            constants: DivideConstants {
                painted: self.means.painted,
                selects: self.strategy != Strategy::None,
                hunger: self.is_hungry(),
                paths: self.means.paths,
            },
            params: DivideParams {
                particle_count: self.particle_count(),
                seed: seed_word(self.settings.seed),
                time_step: self.time_step(),
                salt: self.division_salt(),
                pitch: self.setup.atlas.pitch,
                division_reach: reach(population.division_window),
                division_least: population.division_least,
                division_most: population.division_most,
                division_probability: population.division_probability,
                survival_reach: reach(population.survival_window),
                survival_least: population.survival_least,
                survival_most: population.survival_most,
                death_probability: population.death_probability,
                hunger: population.hunger,
                transfer_threshold: self.lengths.threshold,
            },
        }
    }

    /// The lowest rank gets a cell.
    #[must_use]
    pub fn divide_settle(&self) -> Call<DivideSettle> {
        Call {
            on: (),
            constants: DivideSettleConstants {
                paths: self.means.paths,
            },
            params: DivideSettleParams {
                particle_count: self.particle_count(),
                salt: self.division_salt(),
            },
        }
    }

    /// Numbers particles that divide, and ids that wait.
    #[must_use]
    pub fn divide_number(&self) -> Call<DivideNumber> {
        Call {
            on: (),
            constants: (),
            params: DivideNumberParams {
                particle_count: self.particle_count(),
            },
        }
    }

    /// Lists the particles that divide.
    #[must_use]
    pub fn divide_list(&self) -> Call<DivideList> {
        Call {
            on: (),
            constants: (),
            params: DivideListParams {
                particle_count: self.particle_count(),
                offset: self.division_words()[1],
            },
        }
    }

    /// Particles are born.
    #[must_use]
    pub fn divide_begin(&self) -> Call<DivideBegin> {
        Call {
            on: (),
            constants: DivideBeginConstants {
                windows: self.strategy.has_windows(),
                hunger: self.is_hungry(),
                paths: self.means.paths,
            },
            params: DivideBeginParams {
                particle_count: self.particle_count(),
                seed: seed_word(self.settings.seed),
                time_step: self.time_step(),
                pitch: self.setup.atlas.pitch,
            },
        }
    }

    /// Makes ranks differ from step to step, and from those of particles that walk.
    fn division_salt(&self) -> u32 {
        self.division_words()[0]
    }

    /// Random numbers of the step.
    fn division_words(&self) -> [u32; 4] {
        let seed = seed_word(self.settings.seed);
        random(seed, 1, self.time_step(), Purpose::Claim)
    }
}

impl StepKernel for CountCells {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> CountCellsArgs<'s> {
        CountCellsArgs {
            particles: &s.particles.texels,
            motions: &s.motions.texels,
            strips: &s.surface.strips,
            homes: s.homes(),
            occupants: &s.growth().occupants,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        let setup = &a.setup;
        count_cells(
            &call.params,
            &AdvanceInputs {
                homes: &setup.homes,
                ..AdvanceInputs::of_surface(setup, &a.physarums)
            },
            (&a.particles, &a.motions),
            &mut a.occupants,
        );
    }
}

impl StepKernel for Divide {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> DivideArgs<'s> {
        let growth = s.growth();
        DivideArgs {
            particles: &s.particles.texels,
            motions: &s.motions.texels,
            strips: &s.surface.strips,
            homes: s.homes(),
            occupants: &growth.occupants,
            nests: &growth.nests,
            bias: s.bias.as_ref(),
            nursery: &growth.nursery,
            births: &growth.births.texels,
            id_marks: &growth.id_marks,
            distances: &s.near.distances.texels,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        let setup = &a.setup;
        divide(
            &call.constants,
            &call.params,
            &AdvanceInputs {
                homes: &setup.homes,
                bias: &a.bias,
                distances: &a.distances,
                ..AdvanceInputs::of_surface(setup, &a.physarums)
            },
            (&setup.nests, &a.occupants),
            (&a.particles, &mut a.motions),
            (&mut a.births, &mut a.nursery),
            &mut a.id_marks,
        );
    }
}

impl StepKernel for DivideSettle {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> DivideSettleArgs<'s> {
        let growth = s.growth();
        DivideSettleArgs {
            particles: &s.particles.texels,
            nursery: &growth.nursery,
            births: &growth.births.texels,
            id_marks: &growth.id_marks,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        divide_settle(
            &call.params,
            &a.particles,
            &a.nursery,
            &mut a.births,
            &mut a.id_marks,
        );
    }
}

impl StepKernel for DivideNumber {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> DivideNumberArgs<'s> {
        let growth = s.growth();
        DivideNumberArgs {
            id_marks: &growth.id_marks,
            ids_before: &growth.ids_before,
            population: &growth.population,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        divide_number(
            &call.params,
            &a.id_marks,
            &mut a.ids_before,
            &mut a.population[0],
        );
    }
}

impl StepKernel for DivideList {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> DivideListArgs<'s> {
        let growth = s.growth();
        DivideListArgs {
            particles: &s.particles.texels,
            births: &growth.births.texels,
            id_marks: &growth.id_marks,
            ids_before: &growth.ids_before,
            population: &growth.population,
            parents: &growth.parents.texels,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        divide_list(
            &call.params,
            (&a.particles, &a.births),
            (&a.id_marks, &a.ids_before),
            &a.population[0],
            &mut a.parents,
        );
    }
}

impl StepKernel for DivideBegin {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> DivideBeginArgs<'s> {
        let growth = s.growth();
        DivideBeginArgs {
            particles: &s.particles.texels,
            motions: &s.motions.texels,
            strips: &s.surface.strips,
            nests: &growth.nests,
            parents: &growth.parents.texels,
            births: &growth.births.texels,
            id_marks: &growth.id_marks,
            ids_before: &growth.ids_before,
            population: &growth.population,
            borders: &s.transfers.borders,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        let setup = &a.setup;
        divide_begin(
            &call.constants,
            &call.params,
            &AdvanceInputs::of_surface(setup, &a.physarums),
            (&setup.nests, &a.births, &a.parents),
            (&a.id_marks, &a.ids_before),
            &a.population[0],
            (&mut a.particles, &mut a.motions),
            &mut a.transfers.borders,
        );
    }
}

/// A bit for each particle's id, in two sets: of particles that divide, and of those that are dead. Twin of
/// `shaders/include/id_marks.glsl`.
struct IdMarks;

impl IdMarks {
    /// Words of a set.
    fn words(count: u32) -> usize {
        count.div_ceil(u32::BITS) as usize
    }

    /// The word of an id in its set.
    fn word(id: u32) -> usize {
        (id / u32::BITS) as usize
    }

    fn bit(id: u32) -> u32 {
        1 << (id % u32::BITS)
    }

    /// How many ids below this one are marked, of those in its word.
    fn below(word: u32, id: u32) -> u32 {
        (word & (Self::bit(id) - 1)).count_ones()
    }
}

/// What the division of a particle depends on.
struct Surroundings<'a> {
    pitch: u32,
    homes: &'a [u32],
    nests: &'a [u32],
    occupants: &'a [u32],
    /// If some was painted.
    bias: Option<&'a [f32]>,
    /// Signed distances to other objects, and that below which a place is covered, if particles leave such places.
    covered_below: Option<(&'a [f32], f32)>,
}

impl Surroundings<'_> {
    /// The cell of a texel beside a cell.
    fn beside(&self, cell: u32, column: i32, row: i32) -> u32 {
        let texel = cell as i32 + row * self.pitch as i32 + column;
        self.homes[texel as usize]
    }

    /// Particles in the cells of a window.
    fn count(&self, cell: u32, reach: i32) -> u32 {
        let mut sum = 0u32;
        for row in -reach..=reach {
            for column in -reach..=reach {
                let beside = self.beside(cell, column, row);
                sum = sum.wrapping_add(self.occupants[beside as usize]);
            }
        }
        sum
    }

    fn is_free(&self, cell: u32) -> bool {
        let cell = cell as usize;
        self.nests[cell] != NONE
            && self.occupants[cell] == 0
            && self.bias.is_none_or(|bias| bias[cell] >= NO_GO_BELOW)
            && self
                .covered_below
                .is_none_or(|(distances, threshold)| distances[cell] >= threshold)
    }

    /// One of the free cells of the eight round a cell, each as likely as the others.
    fn free_beside(&self, cell: u32, chance: u32) -> Option<u32> {
        // The middle one of nine is the cell itself.
        let places = (0..9).filter(|&place| place != 4);
        let cells = places.map(|place| self.beside(cell, place % 3 - 1, place / 3 - 1));
        let mut free: Vec<u32> = Vec::new();
        for beside in cells {
            // Over a border or a seam several places have the same cell.
            if self.is_free(beside) && !free.contains(&beside) {
                free.push(beside);
            }
        }
        let place = chance.checked_rem(free.len() as u32)?;
        Some(free[place as usize])
    }
}

/// Twin of `shaders/count_cells.comp`.
pub fn count_cells(
    params: &CountCellsParams,
    inputs: &AdvanceInputs,
    (particles, motions): (&[Particle], &[Motion]),
    occupants: &mut [u32],
) {
    let both = particles.iter().zip(motions);
    for (particle, motion) in both.take(params.particle_count as usize) {
        if motion.is_dead() {
            continue;
        }
        let position = inputs.position_of(particle.triangle, [particle.u, particle.v]);
        let cell = inputs.homes[texel_at(position, params.pitch) as usize];
        occupants[cell as usize] += 1;
    }
}

/// Twin of `shaders/divide.comp`.
pub fn divide(
    constants: &DivideConstants,
    params: &DivideParams,
    inputs: &AdvanceInputs,
    (nests, occupants): (&[u32], &[u32]),
    (particles, motions): (&[Particle], &mut [Motion]),
    (births, nursery): (&mut [u32], &mut [u32]),
    id_marks: &mut [u32],
) {
    let surroundings = Surroundings {
        pitch: params.pitch,
        homes: inputs.homes,
        nests,
        occupants,
        bias: constants.painted.then_some(inputs.bias),
        covered_below: constants
            .selects
            .then_some((inputs.distances, params.transfer_threshold)),
    };
    let dead = IdMarks::words(params.particle_count);
    for slot in 0..params.particle_count as usize {
        let (particle, motion) = (&particles[slot], &mut motions[slot]);
        let id = particle.id;
        births[slot] = NONE;
        if !motion.is_dead() {
            let position = inputs.position_of(particle.triangle, [particle.u, particle.v]);
            let cell = inputs.homes[texel_at(position, params.pitch) as usize];
            let words = random(params.seed, id, params.time_step, Purpose::Population);
            let crowd = surroundings.count(cell, params.survival_reach);
            let survives = (params.survival_least..=params.survival_most).contains(&crowd);
            let starves = constants.hunger && motion.hungry() >= params.hunger;
            if starves || (!survives && unit(words[0]) < params.death_probability) {
                *motion = Motion {
                    pending: 0.0,
                    flags: Motion::DEAD,
                    ..*motion
                };
            } else if !motion.has_stayed() && unit(words[1]) < params.division_probability {
                let crowd = surroundings.count(cell, params.division_reach);
                if (params.division_least..=params.division_most).contains(&crowd) {
                    let free = surroundings.free_beside(cell, words[2]);
                    births[slot] = free.unwrap_or(NONE);
                }
            }
        }
        if motion.is_dead() {
            id_marks[dead + IdMarks::word(id)] |= IdMarks::bit(id);
        }
        if births[slot] != NONE {
            let claim = &mut nursery[births[slot] as usize];
            *claim = (*claim).min(rank_of(id, params.salt));
        }
    }
}

/// Twin of `shaders/divide_settle.comp`.
pub fn divide_settle(
    params: &DivideSettleParams,
    particles: &[Particle],
    nursery: &[u32],
    births: &mut [u32],
    id_marks: &mut [u32],
) {
    let claims = particles.iter().zip(births);
    for (particle, cell) in claims.take(params.particle_count as usize) {
        if *cell == NONE {
            continue;
        }
        let id = particle.id;
        if nursery[*cell as usize] == rank_of(id, params.salt) {
            id_marks[IdMarks::word(id)] |= IdMarks::bit(id);
        } else {
            *cell = NONE;
        }
    }
}

/// Twin of `shaders/divide_number.comp`.
pub fn divide_number(
    params: &DivideNumberParams,
    id_marks: &[u32],
    ids_before: &mut [u32],
    population: &mut Population,
) {
    let words = IdMarks::words(params.particle_count);
    let sets = id_marks.chunks(words).zip(ids_before.chunks_mut(words));
    let mut sums = [0, 0];
    for (sum, (marks, before)) in sums.iter_mut().zip(sets) {
        for (word, before) in marks.iter().zip(before) {
            *before = *sum;
            *sum += word.count_ones();
        }
    }
    let [dividing, dead] = sums;
    let survivors = params.particle_count - dead;
    let died = population.living.wrapping_sub(survivors);
    let born = dividing.min(dead);
    *population = Population {
        living: survivors + born,
        births: population.births.saturating_add(born),
        deaths: population.deaths.saturating_add(died),
        refused: population.refused.saturating_add(dividing - born),
        born,
        died,
    };
}

/// Twin of `shaders/divide_list.comp`.
pub fn divide_list(
    params: &DivideListParams,
    (particles, births): (&[Particle], &[u32]),
    (id_marks, ids_before): (&[u32], &[u32]),
    population: &Population,
    parents: &mut [u32],
) {
    let last = IdMarks::words(params.particle_count) - 1;
    let dividing = ids_before[last] + id_marks[last].count_ones();
    let claims = particles.iter().zip(births);
    for (slot, (particle, &cell)) in (0..params.particle_count).zip(claims) {
        if cell == NONE {
            continue;
        }
        let word = IdMarks::word(particle.id);
        let mut number = ids_before[word] + IdMarks::below(id_marks[word], particle.id);
        if dividing > population.born {
            number = (number + (dividing - params.offset % dividing)) % dividing;
        }
        if number < population.born {
            parents[number as usize] = slot;
        }
    }
}

/// Twin of `shaders/divide_begin.comp`.
#[expect(clippy::too_many_arguments, reason = "those of the kernel")]
pub fn divide_begin(
    constants: &DivideBeginConstants,
    params: &DivideBeginParams,
    inputs: &AdvanceInputs,
    (nests, births, parents): (&[u32], &[u32], &[u32]),
    (id_marks, ids_before): (&[u32], &[u32]),
    population: &Population,
    (particles, motions): (&mut [Particle], &mut [Motion]),
    borders: &mut [Border],
) {
    let object_of = |triangle: u32| inputs.strips[triangle as usize].shape.object as usize;
    let dead = IdMarks::words(params.particle_count);
    for slot in 0..params.particle_count as usize {
        let Particle { id, triangle, .. } = particles[slot];
        let from = object_of(triangle);
        let word = dead + IdMarks::word(id);
        let marks = id_marks[word];
        if marks & IdMarks::bit(id) == 0 {
            continue;
        }
        let number = ids_before[word] + IdMarks::below(marks, id);
        if number >= population.born {
            continue;
        }
        let parent = parents[number as usize] as usize;
        let cell = births[parent];
        let triangle = nests[cell as usize];
        let map = &inputs.strips[triangle as usize].map;
        let [u, v] = birthplace(map, cell, params.pitch);
        let words = random(params.seed, id, params.time_step, Purpose::Population);
        let heading = turn_of(words[3]);
        particles[slot] = Particle { triangle, u, v, id };
        motions[slot] = Motion {
            heading_p: heading.x,
            heading_h: heading.y,
            pending: 0.0,
            flags: match constants.hunger {
                true => motions[parent].hungry() << Motion::HUNGRY_SHIFT,
                false => 0,
            },
        };
        let to = object_of(triangle);
        if constants.windows && from != to {
            borders[from].left += 1;
            borders[to].came += 1;
        }
    }
}
