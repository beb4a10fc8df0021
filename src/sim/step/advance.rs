//! `advance` in its five forms: their parameters and bindings. Twin of `shaders/advance.comp` and of `shaders/include/turning.glsl`.

use rayon::prelude::*;

use crate::gpu::{AnyBuffer, Kernel as _};
use crate::mesh::strip::StripTriangle;
use crate::mesh::surface::{AtlasMap, NONE};
use crate::rng::{Purpose, random, seed_word, unit};
use crate::scene::settings::{PhysarumSettings, Sensing, Strategy};
use crate::sim::arrays::Arrays;
use crate::sim::field::{atlas_position, texel_at, trail_at, unpacked_position, weights_at};
use crate::sim::kernels::{Advance, AdvanceArgs, AdvanceConstants, AdvanceParams};
use crate::sim::looks::mixed_look;
use crate::sim::paint::NO_GO_BELOW;
use crate::sim::plan::Plan;
use crate::sim::pulse::{Sweep, swept};
use crate::sim::sensors::straight_ahead;
use crate::sim::setup::Setup;
use crate::sim::state::{Crowd, State};
use crate::sim::step::distance::along;
use crate::sim::strip_walk::StripWalk;
use crate::sim::surroundings::{COVERED, IN_SIGHT, NEAR};
use crate::sim::types::{Flow, Meal, Motion, Particle, Physarum, Pose, Shell, Vertex};
use crate::sim::walker::WALK_DONE;
use crate::sim::work::{Call, Counter, StepKernel};
use crate::strict::{logarithm, root, settled, turn_of};

/// Kernels that together advance every particle once: the first lists particles for the others. One shader in five forms, of which times
/// name four: the first kernel has another form where all sensors walk, and it is alone then.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Every particle, or every one that no other form processes.
    All,
    /// Particles whose sensors must walk.
    Walking,
    /// Particles that may be near other objects.
    Nearby,
    /// Particles for which both hold.
    WalkingNearby,
}

/// Their names.
pub const FORMS_OF_ADVANCE: [&str; 4] = ["advance", "walk_sensors", "advance_near", "walk_near"];

/// All sensors walk.
const SENSORS_WALK: u32 = 0;
/// Sensors go straight ahead in the atlas, and particles for which this is not possible are listed.
const SENSORS_STRAIGHT: u32 = 1;
/// Sensors of particles listed for that walk.
const SENSORS_WALK_LISTED: u32 = 2;
/// Sensors of particles that were listed because they are near other objects go straight ahead.
const SENSORS_STRAIGHT_LISTED: u32 = 3;
/// Sensors of particles that were listed for both walk.
const SENSORS_WALK_NEAR: u32 = 4;

/// Groups that every device takes along one axis of a dispatch.
const GROUPS_A_ROW: u32 = 65_535;

/// The optional terms of the model that some object uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Terms {
    /// Sensors read with noise.
    pub sensor_noise: bool,
    /// Some trail value is preferred.
    pub favourite_density: bool,
    /// Heights count.
    pub gravity: bool,
    /// Crowds are avoided.
    pub decrowding: bool,
    /// Distances to other objects count.
    pub distance: bool,
}

impl Plan<'_> {
    /// The terms that the scene's objects use.
    #[must_use]
    pub fn terms(&self) -> Terms {
        let settings = self.settings;
        let objects = settings.objects.iter();
        let kinds: Vec<PhysarumSettings> = objects
            .map(|object| object.physarum.over(&settings.physarum))
            .collect();
        let second = (settings.second_look.look()).filter(|_| self.has_looks());
        let kinds = || kinds.iter().chain(second.map(|look| &look.physarum));
        let any = |uses: fn(&PhysarumSettings) -> bool| kinds().any(uses);
        Terms {
            sensor_noise: any(|p| p.sensor_noise > 0.0),
            favourite_density: any(|p| p.favourite().is_some()),
            gravity: any(|p| p.gravity_weight != 0.0),
            decrowding: any(|p| p.decrowding_weight != 0.0),
            distance: any(|p| p.distance_weight != 0.0) && settings.objects.len() > 1,
        }
    }

    /// Do sensors read straight ahead in the atlas? Gravity needs the triangle at the end, and only a walk finds it. Over a glued edge the
    /// distance to another object jumps, so that no texel can be marked as far from all of them: the form that takes every particle and
    /// sees other objects is the right one.
    fn reads_straight(&self, terms: Terms) -> bool {
        let jumps = self.strategy.sees_across() && !self.setup.surface.glued.is_empty();
        self.settings.physarum.sensing == Sensing::Auto && !terms.gravity && !jumps
    }

    /// The forms after the first, each with the counter of its particles.
    pub fn forms_of_advance(&self, terms: Terms) -> &'static [(Form, Counter)] {
        const FORMS: [(Form, Counter); 3] = [
            (Form::Walking, Counter::Walking),
            (Form::Nearby, Counter::Nearby),
            (Form::WalkingNearby, Counter::WalkingNearby),
        ];
        match (self.reads_straight(terms), self.strategy.sees_across()) {
            (false, _) => &[],
            (true, false) => &FORMS[..1],
            (true, true) => &FORMS,
        }
    }

    /// Rows of groups in the dispatches for listed particles.
    pub fn walker_rows(&self) -> u32 {
        let groups = self.particle_count().div_ceil(Advance::GROUP_SIZE);
        groups.div_ceil(GROUPS_A_ROW).max(1)
    }

    /// `advance`, or a form of it: particles walk, sense, turn, walk, eat and deposit.
    #[must_use]
    pub fn advance(&self, terms: Terms, form: Form) -> Call<Advance> {
        let Self {
            settings,
            setup,
            means,
            lengths,
            ..
        } = self;
        let own = &settings.physarum;
        let width = 1 + 2 * self.rules.reach.unwrap_or(0);
        Call {
            on: form,
            constants: AdvanceConstants {
                random_ties: self.rules.random_ties,
                random_turns: own.random_turn > 0.0,
                cells: self.rules.reach.is_some(),
                reach: self.rules.reach.unwrap_or(0) as i32,
                sensitivity: own.sensitivity > 0.0,
                sensor_noise: terms.sensor_noise,
                favourite_density: terms.favourite_density,
                gravity: terms.gravity,
                decrowding: terms.decrowding,
                distance: terms.distance,
                border_reflects: self.border_reflects(),
                selects: self.strategy != Strategy::None,
                own_physarum: self.own_physarum,
                across: self.strategy.sees_across(),
                sensing: match form {
                    Form::All if self.reads_straight(terms) => SENSORS_STRAIGHT,
                    Form::All => SENSORS_WALK,
                    Form::Walking => SENSORS_WALK_LISTED,
                    Form::Nearby => SENSORS_STRAIGHT_LISTED,
                    Form::WalkingNearby => SENSORS_WALK_NEAR,
                },
                paths: means.paths,
                painted: means.painted,
                food: self.has_food(),
                pulses: !self.shells.is_empty(),
                looks: self.has_looks(),
                mortal: self.is_mortal(),
                hunger: self.is_hungry(),
            },
            params: AdvanceParams {
                particle_count: self.particle_count(),
                seed: seed_word(settings.seed),
                time_step: self.time_step(),
                attempts: settings.physarum.edge_crossing_attempts,
                pitch: setup.atlas.pitch,
                transfer_capacity: means.capacity,
                transfer_threshold: lengths.threshold,
                deepest: lengths.deepest,
                last_texel: (setup.atlas.size - 1) as f32,
                outlook_unit: setup.atlas.outlook_unit(),
                walker_rows: self.walker_rows(),
                fed_steps: settings.feeding.fed_steps,
                fed_deposit: settings.feeding.fed_deposit,
                fed_attraction: settings.feeding.fed_attraction,
                shell_count: self.shells.len() as u32,
                second_look: self.object_count(),
                sensor_share: 1.0 / (width * width) as f32,
                sensitivity: own.sensitivity,
                random_turn: own.random_turn,
                may_turn: u32::from(!self.rules.moves_first || self.step > 0),
            },
        }
    }
}

/// Buffers that the forms for listed particles share. Each form writes the particles and motions of its own list, and the entries of
/// `particle_indices` that an atomic addition gives it. It changes deposits, the flow and meals by atomic additions. It only reads the
/// lists of walkers, which the first form of the shader writes. With one particle a cell it writes the wishes and claims of its own list, and
/// changes bids by atomic minima, and goals, too, unless no two particles are in one cell: then only one writes each.
pub fn shared_by_forms(s: &State) -> Vec<&dyn AnyBuffer> {
    let mut shared: Vec<&dyn AnyBuffer> = vec![
        &s.particles,
        &s.motions,
        &s.deposits.front,
        &s.walkers.slots,
        &s.walkers.near,
        &s.walkers.count,
        &s.transfers.flow,
        &s.transfers.particle_indices,
    ];
    shared.extend(s.food.iter().map(|food| &food.meals as &dyn AnyBuffer));
    if let Some(crowd) = &s.crowd {
        let Crowd {
            goals,
            bids,
            wishes,
            claims,
        } = crowd;
        shared.extend([goals as &dyn AnyBuffer, bids, wishes, claims]);
    }
    shared
}

impl StepKernel for Advance {
    type On = Form;

    fn name(form: Form) -> &'static str {
        FORMS_OF_ADVANCE[form as usize]
    }

    fn args<'s>(call: &Call<Self>, s: &'s State) -> AdvanceArgs<'s> {
        let food = s.food.as_ref();
        AdvanceArgs {
            particles: &s.particles.texels,
            motions: &s.motions.texels,
            strips: &s.surface.strips,
            trail: &s.trail.front,
            previous_deposits: &s.deposits.back,
            deposits: &s.deposits.front,
            corners: &s.surface.corners,
            vertices: &s.surface.vertices,
            poses: &s.objects.poses.texels,
            distances: &s.near.distances.texels,
            physarums: &s.objects.physarums,
            across: &s.across.places.texels,
            across_triangles: &s.across.triangles.texels,
            surroundings: &s.across.surroundings.texels,
            flow: &s.transfers.flow,
            particle_indices: &s.transfers.particle_indices,
            particles_before: &s.particles.texels,
            motions_before: &s.motions.texels,
            walkers: &s.walkers.slots.texels,
            walkers_near: &s.walkers.near.texels,
            walker_count: &s.walkers.count,
            // The forms for listed particles list no others: no dispatch may write its own groups.
            walker_groups: match call.on {
                Form::All => Some(&s.walkers.groups),
                _ => None,
            },
            bias: s.bias.as_ref(),
            scent: food.map(|food| food.sensed()),
            plates: food.map(|food| &food.plates),
            meals: food.map(|food| &food.meals),
            shells: &s.objects.shells,
            looks: s.looks.as_ref(),
            homes: s.homes.as_ref(),
        }
    }

    /// The first form processes every particle, and the others have none.
    fn twin(call: &Call<Self>, a: &mut Arrays) {
        if call.on != Form::All {
            return;
        }
        let outcomes = outcomes(&call.constants, &call.params, a);
        let t = &mut a.transfers;
        let particle_indices = &mut t.particle_indices[..call.params.transfer_capacity as usize];
        for (slot, outcome) in outcomes.into_iter().enumerate() {
            let Some((walked, arrival)) = outcome else {
                continue;
            };
            if let Some(form) = walked.form {
                a.forms[form] += 1;
            }
            a.particles[slot] = walked.particle;
            a.motions[slot] = Motion {
                flags: arrival.flags(),
                ..walked.motion
            };
            let flow = &mut t.flow[0];
            arrival.note(slot, flow, particle_indices, &mut a.meals, &mut a.deposits);
        }
    }
}

/// Bound on the rounding of a distance.
const ROUNDING: f32 = 1e-6;

/// Inputs of `advance`.
pub struct AdvanceInputs<'a> {
    /// Triangles, their neighbours across edges, and their places in the atlas.
    pub strips: &'a [StripTriangle],
    /// Trail with filled gutters.
    pub trail: &'a [f32],
    /// Last step's deposits.
    pub previous_deposits: &'a [u32],
    /// Three vertex indices per triangle.
    pub corners: &'a [u32],
    /// Object-space vertices.
    pub vertices: &'a [Vertex],
    /// World from object.
    pub poses: &'a [Pose],
    /// Parameters of particles on each object.
    pub physarums: &'a [Physarum],
    /// Signed distance to other objects, with filled gutters.
    pub distances: &'a [f32],
    /// Per texel: outlook and hue, and marks for places near other objects and covered by them.
    pub surroundings: &'a [u16],
    /// For covered texels, places on other objects.
    pub across: &'a [u32],
    /// The triangles of these places.
    pub across_triangles: &'a [u32],
    /// Trail units that are added to sensor readings, with filled gutters.
    pub bias: &'a [f32],
    /// Trail units that are added for food and markers, with filled gutters.
    pub scent: &'a [f32],
    /// Per texel: the food that is eaten there, counted from 1, or 0.
    pub plates: &'a [u32],
    /// The shells of live pulses.
    pub shells: &'a [Shell],
    /// Weights of the second look, with filled gutters.
    pub looks: &'a [f32],
    /// Per texel: its cell; empty if no rule asks for it.
    pub homes: &'a [u32],
}

impl<'a> AdvanceInputs<'a> {
    /// The inputs of a step.
    #[must_use]
    pub fn of_arrays(a: &'a Arrays) -> Self {
        let setup = &a.setup;
        Self {
            strips: &setup.strips,
            trail: &a.trail,
            previous_deposits: &a.previous_deposits,
            corners: &setup.corners,
            vertices: &setup.vertices,
            poses: &a.poses,
            physarums: &a.physarums,
            distances: &a.distances,
            surroundings: &a.surroundings,
            across: &a.across,
            across_triangles: &a.across_triangles,
            bias: &a.bias,
            scent: if a.around.is_empty() {
                &a.scent
            } else {
                &a.around
            },
            plates: &setup.food_set.plates,
            shells: &a.shells,
            looks: &a.weights,
            homes: &setup.homes,
        }
    }

    /// The inputs of a bare surface, without trail.
    #[must_use]
    pub fn of_surface(setup: &'a Setup, physarums: &'a [Physarum]) -> Self {
        Self {
            strips: &setup.strips,
            trail: &[],
            previous_deposits: &[],
            corners: &setup.corners,
            vertices: &setup.vertices,
            poses: &setup.poses,
            physarums,
            distances: &[],
            surroundings: &setup.surroundings,
            across: &[],
            across_triangles: &[],
            bias: &[],
            scent: &[],
            plates: &[],
            shells: &[],
            looks: &[],
            homes: &[],
        }
    }
}

impl AdvanceInputs<'_> {
    fn map_of(&self, triangle: u32) -> &AtlasMap {
        &self.strips[triangle as usize].map
    }

    pub(super) fn position_of(&self, triangle: u32, [u, v]: [f32; 2]) -> [f32; 2] {
        atlas_position(self.map_of(triangle), u, v)
    }
}

/// What each particle does in a step; `None` if it is dead. They are independent: changes of what they share follow afterwards, in their
/// order.
fn outcomes(
    constants: &AdvanceConstants,
    params: &AdvanceParams,
    a: &Arrays,
) -> Vec<Option<(Walked, Arrival)>> {
    let inputs = AdvanceInputs::of_arrays(a);
    let arriving = Arriving {
        food: constants.food,
        hunger: constants.hunger,
        fed_steps: params.fed_steps,
        fed_deposit: params.fed_deposit,
        plates: inputs.plates,
        meals: &a.meals,
        distances: inputs.distances,
        threshold: params.transfer_threshold,
        pitch: params.pitch,
    };
    let position_of = |at: &Particle| inputs.position_of(at.triangle, [at.u, at.v]);
    (0..params.particle_count as usize)
        .into_par_iter()
        .map(|slot| {
            let (particle, motion) = (&a.particles[slot], &a.motions[slot]);
            if constants.mortal && motion.is_dead() {
                return None;
            }
            let walked = walked(constants, params, &inputs, (particle, motion));
            let (previous, position) = (position_of(particle), position_of(&walked.particle));
            let may_be_selected = constants.selects && walked.concerned;
            let arrival = arriving.at(previous, position, motion.flags, may_be_selected);
            Some((walked, arrival))
        })
        .collect()
}

/// What a particle does where it has come to.
pub(super) struct Arrival {
    /// The texel where it deposits, and the amount.
    texel: usize,
    deposit: u32,
    /// Its flags: for how many steps it stays fed, or has been hungry.
    fed_flags: u32,
    /// The food that it has eaten of.
    meal: Option<usize>,
    is_selected: bool,
}

impl Arrival {
    /// The particle's new flags.
    pub(super) fn flags(&self) -> u32 {
        self.fed_flags | u32::from(self.is_selected)
    }

    /// Changes what particles share. The lists hold as many as they are long.
    pub(super) fn note(
        self,
        slot: usize,
        flow: &mut Flow,
        particle_indices: &mut [u32],
        meals: &mut [Meal],
        deposits: &mut [u32],
    ) {
        deposits[self.texel] += self.deposit;
        if let Some(meal) = self.meal {
            meals[meal].eaten += 1;
        }
        if self.is_selected {
            if let Some(place) = particle_indices.get_mut(flow.wanted as usize) {
                *place = slot as u32;
            }
            flow.wanted += 1;
        }
    }
}

/// What an arrival depends on.
pub(super) struct Arriving<'a> {
    /// Is there food?
    pub food: bool,
    /// Do particles die of hunger?
    pub hunger: bool,
    /// For how many steps a meal lasts.
    pub fed_steps: u32,
    /// The number of particles that a fed one counts as.
    pub fed_deposit: u32,
    /// Per texel: the food that is eaten there, counted from 1, or 0.
    pub plates: &'a [u32],
    /// Meals that remain.
    pub meals: &'a [Meal],
    /// Signed distance to other objects.
    pub distances: &'a [f32],
    /// The signed distance below which a place is covered.
    pub threshold: f32,
    /// Texels from one row to the next.
    pub pitch: u32,
}

impl Arriving<'_> {
    /// A particle that has come from `previous` to `position`, and had the flags `before`. It may be selected to leave its object.
    pub(super) fn at(
        &self,
        previous: [f32; 2],
        position: [f32; 2],
        before: u32,
        may_be_selected: bool,
    ) -> Arrival {
        let texel = texel_at(position, self.pitch) as usize;
        let (mut fed_flags, mut meal) = (0, None);
        if self.food {
            (fed_flags, meal) = self.fed_flags(texel, before);
        }
        let mut is_selected = false;
        if may_be_selected {
            let now = trail_at(self.distances, position, self.pitch);
            let before = trail_at(self.distances, previous, self.pitch);
            let less = before - ROUNDING * before.abs();
            is_selected = now < self.threshold && now < less;
        }
        Arrival {
            texel,
            deposit: if fed_flags >> Motion::FED_SHIFT == 0 {
                1
            } else {
                self.fed_deposit
            },
            fed_flags,
            meal,
            is_selected,
        }
    }

    /// The flags of a particle that has reached a texel and had the flags `before`: for how many steps it stays fed, or has been hungry;
    /// and the food that it has eaten there.
    pub(super) fn fed_flags(&self, texel: usize, before: u32) -> (u32, Option<usize>) {
        let (fed, meal) = self.fed_at(texel, before >> Motion::FED_SHIFT);
        let mut flags = fed << Motion::FED_SHIFT;
        if self.hunger && fed == 0 && meal.is_none() {
            let hungry = before >> Motion::HUNGRY_SHIFT & Motion::MOST_HUNGRY;
            flags |= (hungry + 1).min(Motion::MOST_HUNGRY) << Motion::HUNGRY_SHIFT;
        }
        (flags, meal)
    }

    /// The remaining fed steps of a particle that has reached a texel and had `fed` remaining steps; and the food that it has eaten there.
    fn fed_at(&self, texel: usize, fed: u32) -> (u32, Option<usize>) {
        let fed = fed - fed.min(1);
        let plate = self.plates[texel];
        if fed == 0 && plate != 0 {
            let meal = plate as usize - 1;
            if self.meals[meal].remaining != 0 {
                return (self.fed_steps, Some(meal));
            }
        }
        (fed, None)
    }
}

/// The walk of what is pending, and the length that still is. Twin of `shaders/include/motor.glsl`, as [`walk_step`].
fn walk_pending(
    constants: &AdvanceConstants,
    params: &AdvanceParams,
    inputs: &AdvanceInputs,
    own: &Physarum,
    (particle, motion): (&Particle, &Motion),
) -> (StripWalk, f32) {
    let mut w = standing(particle, motion);
    let mut pending = 0.0;
    if motion.pending > 0.0 {
        let attempts = own_attempts(constants.own_physarum, own, params.attempts);
        w.walk(inputs.strips, attempts, constants.border_reflects);
        pending = w.pending();
    }
    (w, pending)
}

/// The step from where that walk has ended, and the pending length behind it. The particle turns round at no-go areas.
fn walk_step(
    constants: &AdvanceConstants,
    params: &AdvanceParams,
    inputs: &AdvanceInputs,
    own: &Physarum,
    (particle, motion): (&Particle, &Motion),
    (mut w, mut pending): (StripWalk, f32),
) -> (StripWalk, f32) {
    w.remaining = own.speed;
    if constants.pulses {
        let shells = &inputs.shells[..params.shell_count as usize];
        sweep(shells, inputs, &mut w);
    }
    let attempts = own_attempts(constants.own_physarum, own, params.attempts);
    w.walk(inputs.strips, attempts, constants.border_reflects);
    pending += w.pending();
    if constants.painted {
        let bias_at = |position| inputs.bias[texel_at(position, params.pitch) as usize];
        let previous = inputs.position_of(particle.triangle, [particle.u, particle.v]);
        let position = inputs.position_of(w.triangle, [w.u, w.v]);
        if bias_at(previous) >= NO_GO_BELOW && bias_at(position) < NO_GO_BELOW {
            w = StripWalk {
                triangle: particle.triangle,
                u: particle.u,
                v: particle.v,
                heading: [-motion.heading_p, -motion.heading_h],
                remaining: 0.0,
                status: WALK_DONE,
            };
            pending = 0.0;
        }
    }
    (w.u, w.v) = (settled(w.u), settled(w.v));
    (w, settled(pending.min(own.speed)))
}

/// A walk of what is pending, where it begins.
fn standing(particle: &Particle, motion: &Motion) -> StripWalk {
    StripWalk {
        triangle: particle.triangle,
        u: particle.u,
        v: particle.v,
        heading: [motion.heading_p, motion.heading_h],
        remaining: motion.pending,
        status: WALK_DONE,
    }
}

/// A particle that has walked what was pending, sensed, turned and walked.
pub(super) struct Walked {
    pub particle: Particle,
    /// Its motion. It has the flags of before.
    pub motion: Motion,
    /// The form that processes it, if there are several.
    pub form: Option<usize>,
    /// May it be near other objects?
    concerned: bool,
}

/// Lets a living particle walk what is pending, sense, turn and walk.
pub(super) fn walked(
    constants: &AdvanceConstants,
    params: &AdvanceParams,
    inputs: &AdvanceInputs,
    (particle, motion): (&Particle, &Motion),
) -> Walked {
    let fed = if constants.food { motion.fed() } else { 0 };
    let own = own_parameters(constants, params, inputs, particle);
    let appetite = if fed == 0 { 1.0 } else { params.fed_attraction };
    let both = (particle, motion);
    let (mut w, pending) = walk_pending(constants, params, inputs, &own, both);
    let (heading, form, concerned) = turned(constants, params, inputs, &own, both, w, appetite);
    if params.may_turn != 0 {
        w.heading = heading;
    }
    let (w, pending) = walk_step(constants, params, inputs, &own, both, (w, pending));
    let [heading_p, heading_h] = w.heading.map(settled);
    Walked {
        particle: Particle {
            triangle: w.triangle,
            u: w.u,
            v: w.v,
            id: particle.id,
        },
        motion: Motion {
            heading_p,
            heading_h,
            pending,
            flags: motion.flags,
        },
        form,
        concerned,
    }
}

/// Edge crossings that one walk may make.
fn own_attempts(own_physarum: bool, own: &Physarum, of_all: u32) -> u32 {
    if own_physarum { own.attempts } else { of_all }
}

/// Parameters of a particle: those of its object, mixed with those of the second look, if there is one.
fn own_parameters(
    constants: &AdvanceConstants,
    params: &AdvanceParams,
    inputs: &AdvanceInputs,
    particle: &Particle,
) -> Physarum {
    let row = if constants.own_physarum {
        inputs.strips[particle.triangle as usize].shape.object
    } else {
        0
    };
    let own = inputs.physarums[row as usize];
    if !constants.looks {
        return own;
    }
    let at = inputs.position_of(particle.triangle, [particle.u, particle.v]);
    let weight = inputs.looks[texel_at(at, params.pitch) as usize];
    mixed_look(own, &inputs.physarums[params.second_look as usize], weight)
}

/// The heading after sensing at the end of a walk, the form that processes the particle, and whether it may be near other objects.
fn turned(
    constants: &AdvanceConstants,
    params: &AdvanceParams,
    inputs: &AdvanceInputs,
    own: &Physarum,
    (particle, motion): (&Particle, &Motion),
    w: StripWalk,
    appetite: f32,
) -> ([f32; 2], Option<usize>, bool) {
    let mut heading = w.heading;
    let position = inputs.position_of(w.triangle, [w.u, w.v]);
    let from_open = constants.across
        && inputs.distances[texel_at(position, params.pitch) as usize] >= params.transfer_threshold;
    let towards = around_heading(heading, own);
    let ahead = (constants.sensing == SENSORS_STRAIGHT).then(|| {
        ahead_of(
            params,
            inputs,
            own,
            particle,
            around_heading([motion.heading_p, motion.heading_h], own),
        )
    });
    let straight = ahead
        .filter(|(_, is_clear)| *is_clear && motion.pending <= 0.0)
        .map(|(places, _)| places);
    // Particles far from all other objects need no data of them.
    let concerned = ahead.is_none_or(|(places, _)| {
        let start = inputs.position_of(particle.triangle, [particle.u, particle.v]);
        let mark = if straight.is_some() { NEAR } else { IN_SIGHT };
        is_near(constants, params, inputs, start, places, mark)
    });
    let form = ahead.is_some().then(|| {
        let is_near = constants.across && concerned;
        usize::from(straight.is_none()) + 2 * usize::from(is_near)
    });
    let mut value = match straight {
        Some(places) => places.map(|place| {
            sensed_at(
                constants,
                params,
                inputs,
                own,
                place,
                (NONE, [0.0; 2]),
                (from_open && concerned, appetite),
            )
        }),
        None => towards.map(|towards| {
            let how = (from_open && concerned, appetite);
            sensed_by_walking(constants, params, inputs, own, w, towards, how)
        }),
    };
    if constants.sensor_noise {
        let noise = normals(random(
            params.seed,
            particle.id,
            params.time_step,
            Purpose::SensorNoise,
        ));
        for k in 0..3 {
            value[k] += own.sensor_noise * noise[k];
        }
    }
    let [left, middle, right] = value;
    let turns = if constants.random_ties {
        let is_tie = middle < left && middle < right;
        let keeps_on = (middle > left && middle > right) || left == right;
        let words = random(params.seed, particle.id, params.time_step, Purpose::Tie);
        let goes_left = if is_tie {
            words[0] < 1 << 31
        } else {
            left > right
        };
        (is_tie || !keeps_on).then_some(goes_left)
    } else {
        ((middle < left || middle < right) && left != right).then_some(left > right)
    };
    if let Some(goes_left) = turns {
        let sin = if goes_left {
            own.rotation_sin
        } else {
            -own.rotation_sin
        };
        heading = rotated(heading, own.rotation_cos, sin);
    }

    if constants.random_turns {
        let words = random(params.seed, particle.id, params.time_step, Purpose::Turn);
        if unit(words[0]) < params.random_turn {
            heading = turn_of(words[1]).to_array();
        }
    }
    (heading, form, concerned)
}

/// Lets the shells of pulses turn a walk and lengthen it.
fn sweep(shells: &[Shell], inputs: &AdvanceInputs, w: &mut StripWalk) {
    let shape = &inputs.strips[w.triangle as usize].shape;
    let corners = [0, 1, 2].map(|corner| {
        let vertex = inputs.corners[(3 * w.triangle + corner) as usize];
        inputs.vertices[vertex as usize].position
    });
    let sweep = Sweep {
        heading: w.heading.into(),
        length: w.remaining,
    };
    let pose = &inputs.poses[shape.object as usize];
    let Sweep { heading, length } = swept(shells, (shape, corners), pose, [w.u, w.v], sweep);
    (w.heading, w.remaining) = (heading.to_array(), length);
}

/// Headings of the sensors: left, middle and right.
fn around_heading(heading: [f32; 2], own: &Physarum) -> [[f32; 2]; 3] {
    [
        rotated(heading, own.sensor_cos, own.sensor_sin),
        heading,
        rotated(heading, own.sensor_cos, -own.sensor_sin),
    ]
}

/// Does a particle start at a mark, or does a sensor that goes straight ahead get to where another object covers the surface?
/// If sensors see no other objects, this is true for every particle.
fn is_near(
    constants: &AdvanceConstants,
    params: &AdvanceParams,
    inputs: &AdvanceInputs,
    start: [f32; 2],
    places: [[f32; 2]; 3],
    mark: u16,
) -> bool {
    let around = |place| inputs.surroundings[texel_at(place, params.pitch) as usize];
    let end = |place: [f32; 2]| around(place.map(|x| x.clamp(0.0, params.last_texel)));
    !constants.across
        || around(start) & mark != 0
        || places.iter().any(|&place| end(place) & COVERED != 0)
}

/// Ends of sensors straight ahead in the atlas, in texels, if all paths are clear.
#[must_use]
pub fn straight_places(
    params: &AdvanceParams,
    inputs: &AdvanceInputs,
    own: &Physarum,
    particle: &Particle,
    towards: [[f32; 2]; 3],
) -> Option<[[f32; 2]; 3]> {
    let (places, is_clear) = ahead_of(params, inputs, own, particle, towards);
    is_clear.then_some(places)
}

fn ahead_of(
    params: &AdvanceParams,
    inputs: &AdvanceInputs,
    own: &Physarum,
    particle: &Particle,
    towards: [[f32; 2]; 3],
) -> ([[f32; 2]; 3], bool) {
    let (strips, surroundings) = (inputs.strips, inputs.surroundings);
    straight_ahead(
        params,
        strips,
        surroundings,
        own.sensor_offset,
        particle,
        towards,
    )
}

/// The reading of a sensor at the end of its walk.
fn sensed_by_walking(
    constants: &AdvanceConstants,
    params: &AdvanceParams,
    inputs: &AdvanceInputs,
    own: &Physarum,
    mut w: StripWalk,
    heading: [f32; 2],
    how: (bool, f32),
) -> f32 {
    w.heading = heading;
    w.remaining = own.sensor_offset;
    let attempts = own_attempts(constants.own_physarum, own, params.attempts);
    w.walk(inputs.strips, attempts, constants.border_reflects);
    let position = inputs.position_of(w.triangle, [w.u, w.v]);
    sensed_at(
        constants,
        params,
        inputs,
        own,
        position,
        (w.triangle, [w.u, w.v]),
        how,
    )
}

/// The reading of a sensor at a place; only gravity uses the triangle. Particles at covered places see no other
/// object. The appetite is the particle's factor on attraction by food and markers.
fn sensed_at(
    constants: &AdvanceConstants,
    params: &AdvanceParams,
    inputs: &AdvanceInputs,
    own: &Physarum,
    mut position: [f32; 2],
    (mut triangle, [mut u, mut v]): (u32, [f32; 2]),
    (from_open, appetite): (bool, f32),
) -> f32 {
    if constants.across {
        let texel = texel_at(position, params.pitch) as usize;
        let distance = inputs.distances[texel];
        let is_covered = params.deepest < distance && distance < params.transfer_threshold;
        let beyond = if from_open && is_covered {
            inputs.across[texel]
        } else {
            NONE
        };
        if beyond != NONE {
            position = unpacked_position(beyond, params.pitch);
            if constants.gravity {
                triangle = inputs.across_triangles[texel];
                [u, v] = weights_at(inputs.map_of(triangle), position);
            }
        }
    }
    let mut value = if constants.cells {
        trail_on_cells(constants, params, inputs, position)
    } else {
        trail_at(inputs.trail, position, params.pitch)
    };
    if constants.sensitivity && value < params.sensitivity {
        value = 0.0;
    }
    if constants.favourite_density && own.favourite_density >= 0.0 {
        value = -(value - own.favourite_density).abs();
    }
    if constants.gravity {
        value += own.gravity_weight * height_at(inputs, triangle, u, v);
    }
    if constants.decrowding {
        value -= own.decrowding_weight
            * inputs.previous_deposits[texel_at(position, params.pitch) as usize] as f32;
    }
    if constants.distance {
        value += own.distance_weight * trail_at(inputs.distances, position, params.pitch);
    }
    if constants.painted {
        value += trail_at(inputs.bias, position, params.pitch);
    }
    if constants.food {
        let smelled = trail_at(inputs.scent, position, params.pitch);
        value += if smelled > 0.0 {
            appetite * smelled
        } else {
            smelled
        };
    }
    value
}

/// The mean of the trail on the cells round a place.
fn trail_on_cells(
    constants: &AdvanceConstants,
    params: &AdvanceParams,
    inputs: &AdvanceInputs,
    position: [f32; 2],
) -> f32 {
    let cell = inputs.homes[texel_at(position, params.pitch) as usize] as i32;
    let mut sum = 0.0;
    for row in -constants.reach..=constants.reach {
        for column in -constants.reach..=constants.reach {
            sum += inputs.trail[(cell + row * params.pitch as i32 + column) as usize];
        }
    }
    sum * params.sensor_share
}

/// Height of a point along the scene's up axis, world units.
fn height_at(inputs: &AdvanceInputs, triangle: u32, u: f32, v: f32) -> f32 {
    let row = inputs.poses[inputs.strips[triangle as usize].shape.object as usize].y;
    let height_of = |corner: u32| {
        let vertex = inputs.corners[(3 * triangle + corner) as usize];
        along(row, inputs.vertices[vertex as usize].position)
    };
    let [a, b, c] = [height_of(0), height_of(1), height_of(2)];
    (a + u * (b - a)) + v * (c - a)
}

/// Three independent normal numbers (Box and Muller 1958).
fn normals(words: [u32; 4]) -> [f32; 3] {
    // 1 - x lies in (0, 1], so the logarithm is finite.
    let [radius_1, radius_2] = [0, 2].map(|k| root(-2.0 * logarithm(1.0 - unit(words[k]))));
    let [turn_1, turn_2] = [1, 3].map(|k: usize| turn_of(words[k]));
    [
        radius_1 * turn_1.x,
        radius_1 * turn_1.y,
        radius_2 * turn_2.x,
    ]
}

fn rotated(heading: [f32; 2], c: f32, s: f32) -> [f32; 2] {
    [
        c * heading[0] - s * heading[1],
        s * heading[0] + c * heading[1],
    ]
}
