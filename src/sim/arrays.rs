//! Everything that a step changes, on the host: plain arrays, one for each buffer of [`State`](super::state::State) that
//! kernels write.

use std::sync::Arc;

use bytemuck::Zeroable;
use glam::{UVec2, UVec4};

use super::behaviour::physarums;
use super::buffers::{Counts, LIMIT_BINS_COUNT};
use super::food::scent_of;
use super::restarts::Restarts;
use super::roles::Pair;
use super::setup::Setup;
use super::snapshot::Snapshot;
use super::sorting::{most_parts, stretches};
use super::spread::trail_rates;
use super::transfers::{TransferState, area_shares, capacity, object_triangles};
use super::types::{
    Border, DistanceJob, Flow, ListedTile, Meal, Motion, ObjectPair, Particle, Physarum,
    Population, Pose, Shell, TrailRates, Transfer, Window,
};
use crate::gpu::DispatchGroups;
use crate::mesh::surface::NONE;
use crate::scene::settings::Settings;

/// Results for tiles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TileLooks {
    /// One per tile and pair.
    pub hints: Vec<u32>,
    /// One per tile and candidate: a face.
    pub candidates: Vec<u32>,
    /// The tiles whose texels are searched.
    pub listed: Vec<ListedTile>,
}

/// Particles that change objects, and the windows that objects have of the particles.
#[derive(Clone, Debug)]
pub struct TransferArrays {
    /// One per object, if there are windows.
    pub windows: Vec<Window>,
    /// One: lengths of the lists, and counters.
    pub flow: Vec<Flow>,
    /// Changes of each window.
    pub borders: Vec<Border>,
    /// Groups of the kernels that work on transfers, as [`Counter`](super::work::Counter) has them.
    pub groups: [DispatchGroups; 5],
    /// Slots of selected particles.
    pub particle_indices: Vec<u32>,
    /// Their transfers.
    pub transfers: Vec<Transfer>,
    /// Selected particles by half of their keys.
    pub limit_bins: Vec<u32>,
    /// Slots that hold another object's particle than their window's.
    pub holes: Vec<u32>,
    /// Particles that left each object (rows) for each, so far.
    pub flux: Vec<u32>,
    /// One per triangle, see [`area_shares`].
    pub area_shares: Vec<u32>,
    /// One per object, see [`object_triangles`].
    pub object_triangles: Vec<UVec2>,
    /// Places that particles restart at.
    pub restarts: Restarts,
}

impl TransferArrays {
    /// The arrays of a state, arranged for the settings' strategy.
    #[must_use]
    pub fn new(settings: &Settings, setup: &Setup, state: &TransferState) -> Self {
        let lists = capacity(settings, setup) as usize;
        Self {
            windows: state.windows.clone(),
            borders: vec![Border::default(); state.windows.len()],
            flow: vec![state.flow],
            groups: [DispatchGroups::of(0, 1); 5],
            particle_indices: vec![0; lists],
            transfers: vec![Transfer::default(); lists],
            limit_bins: vec![0; LIMIT_BINS_COUNT as usize],
            holes: vec![0; setup.particles.len()],
            flux: state.flux.clone(),
            area_shares: area_shares(&setup.surface),
            object_triangles: object_triangles(&setup.surface),
            restarts: Restarts::of_state(&state.restarts, setup, settings),
        }
    }

    /// The capacity of the lists.
    #[must_use]
    pub fn capacity(&self) -> u32 {
        self.particle_indices.len() as u32
    }

    /// The part of it that snapshots hold.
    #[must_use]
    pub fn state(&self) -> TransferState {
        TransferState {
            windows: self.windows.clone(),
            in_flight: Vec::new(),
            flow: self.flow[0].between_steps(),
            flux: self.flux.clone(),
            restarts: self.restarts.kept(),
        }
    }
}

/// All arrays that a step of the twins changes.
#[derive(Clone, Debug)]
pub struct Arrays {
    /// The constant data.
    pub setup: Arc<Setup>,
    /// One per particle: place and id.
    pub particles: Vec<Particle>,
    /// One per particle: heading, pending length and flags.
    pub motions: Vec<Motion>,
    /// Particles that are being reordered.
    pub segment_particles: Vec<Particle>,
    /// Their motions.
    pub segment_motions: Vec<Motion>,
    /// Number of the segment's particles in each part of a bin; zeros between steps.
    pub bins: Vec<u32>,
    /// The sum of each stretch of these.
    pub bin_sums: Vec<u32>,
    /// The place behind the last particle that was put into each part.
    pub bin_places: Vec<u32>,
    /// One per texel, gutters filled.
    pub trail: Vec<f32>,
    /// The trail of the next step.
    pub next_trail: Vec<f32>,
    /// One per texel: counted in this step.
    pub deposits: Vec<u32>,
    /// Deposits of the last step.
    pub previous_deposits: Vec<u32>,
    /// One per texel: the painted bias; empty if nothing was painted.
    pub bias: Vec<f32>,
    /// One per texel: the weight of the second look; empty if nothing was painted.
    pub weights: Vec<f32>,
    /// With one particle a cell, one per texel: the cell that the particle in it would come to, as `goal_word` has it; otherwise empty, as those that follow.
    pub goals: Vec<u32>,
    /// One per texel: the lowest claim to the cell.
    pub bids: Vec<u32>,
    /// One per particle: itself where it would come to.
    pub wishes: Vec<Particle>,
    /// One per particle: the cell that it would come to; the cell that it is in; the texel that it would come to; whether it is alive.
    pub claims: Vec<UVec4>,
    /// With a population that grows and shrinks, one per texel: the particles in the cell; otherwise empty, as those that follow.
    pub occupants: Vec<u32>,
    /// One per texel: the lowest rank of particles that claim the cell to divide into.
    pub nursery: Vec<u32>,
    /// One per particle: the cell that it claims to divide into.
    pub births: Vec<u32>,
    /// One per particle that is born: the slot of the one that divides.
    pub parents: Vec<u32>,
    /// A bit for the id of each particle that divides; then one for that of each dead particle.
    pub id_marks: Vec<u32>,
    /// One per word of these: the marked ids before it.
    pub ids_before: Vec<u32>,
    /// One: how many particles are alive, and counters.
    pub population: Vec<Population>,
    /// One per food or marker.
    pub meals: Vec<Meal>,
    /// One per texel; empty without food and markers.
    pub scent: Vec<f32>,
    /// That scent and what crosses from other objects; empty if no scents do.
    pub around: Vec<f32>,
    /// Has the scent of any food changed in this step?
    pub scent_is_due: bool,
    /// World from object.
    pub poses: Vec<Pose>,
    /// World from object in the step before.
    pub poses_before: Vec<Pose>,
    /// One per object: parameters of its particles; then those of the second look.
    pub physarums: Vec<Physarum>,
    /// What passes do to the trail, in each kind of pass a row per object, as of the last change while objects differed.
    pub rates: Vec<TrailRates>,
    /// The shells of live pulses.
    pub shells: Vec<Shell>,
    /// One per texel: signed distance to other objects.
    pub distances: Vec<f32>,
    /// One per texel: the nearest triangle of another object.
    pub nearest: Vec<u32>,
    /// One per texel: the place on another object where walks continue.
    pub across: Vec<u32>,
    /// One per texel: the triangle of that place.
    pub across_triangles: Vec<u32>,
    /// One per texel: outlook and hue, and marks for places near other objects and covered by them.
    pub surroundings: Vec<u16>,
    /// Objects whose distances are updated.
    pub jobs: Vec<DistanceJob>,
    /// The other objects within their reach.
    pub pairs: Vec<ObjectPair>,
    /// How far each pair has moved since the last update.
    pub moves: Vec<f32>,
    /// One per tile: the state of all its texels, if it is uniform.
    pub tile_states: Vec<u32>,
    /// How far each tile is from being within reach of each other object.
    pub margins: Vec<f32>,
    /// Results for the tiles of the jobs.
    pub looks: TileLooks,
    /// One per texel: the slot of the face that was drawn there, plus 1.
    pub winners: Vec<u32>,
    /// Transfers.
    pub transfers: TransferArrays,
    /// Particles that each form of `advance` processes in this step; zeros if all sensors walk.
    pub forms: [usize; 4],
}

impl Arrays {
    /// The arrays of a state, arranged for the settings' strategy; the objects are at their first poses.
    #[must_use]
    pub fn new(setup: &Arc<Setup>, settings: &Settings, start: Snapshot) -> Self {
        let texels = setup.atlas.density.len();
        let counts = Counts::of(setup, settings);
        let mut arrays = Self {
            transfers: TransferArrays::new(settings, setup, &start.transfers),
            segment_particles: Vec::new(),
            segment_motions: Vec::new(),
            particles: start.particles,
            motions: start.motions,
            bins: vec![0; most_parts(setup.bins.count) as usize],
            bin_sums: vec![0; stretches(most_parts(setup.bins.count)) as usize],
            bin_places: vec![0; most_parts(setup.bins.count) as usize],
            trail: vec![0.0; texels],
            next_trail: vec![0.0; texels],
            deposits: vec![0; texels],
            previous_deposits: vec![0; texels],
            bias: start.bias,
            weights: start.looks,
            goals: vec![0; counts.crowd.1 as usize],
            bids: vec![0; counts.crowd.1 as usize],
            wishes: vec![Particle::zeroed(); counts.crowd.0 as usize],
            claims: vec![UVec4::ZERO; counts.crowd.0 as usize],
            occupants: vec![0; counts.population.1 as usize],
            nursery: vec![0; counts.population.1 as usize],
            births: vec![NONE; counts.population.0 as usize],
            parents: vec![0; counts.population.0 as usize],
            id_marks: vec![0; counts.id_words() as usize],
            ids_before: vec![0; counts.id_words() as usize],
            population: start.population,
            meals: Vec::new(),
            scent: Vec::new(),
            around: Vec::new(),
            scent_is_due: false,
            poses: setup.poses.clone(),
            poses_before: setup.poses.clone(),
            physarums: physarums(settings, setup),
            rates: trail_rates(settings, setup),
            shells: Vec::new(),
            distances: vec![0.0; texels],
            nearest: vec![NONE; texels],
            across: vec![NONE; texels],
            across_triangles: vec![NONE; texels],
            surroundings: setup.surroundings.clone(),
            jobs: Vec::new(),
            pairs: Vec::new(),
            moves: Vec::new(),
            tile_states: vec![0; setup.distance.tiles.len()],
            margins: vec![0.0; setup.distance.margins_len()],
            looks: TileLooks::default(),
            winners: Vec::new(),
            forms: [0; 4],
            setup: Arc::clone(setup),
        };
        arrays.serve(None);
        arrays.make_room(settings);
        arrays
    }

    /// Resizes the scratch memory of reordering for the settings' strategy.
    pub fn make_room(&mut self, settings: &Settings) {
        let room = Counts::of(&self.setup, settings).segment as usize;
        self.segment_particles.resize(room, Particle::zeroed());
        self.segment_motions.resize(room, Motion::zeroed());
    }

    /// Sets the meals left of each food, or all of them.
    pub fn serve(&mut self, remaining: Option<&[u32]>) {
        self.meals = self.setup.food_set.meals(remaining);
        self.scent = scent_of(&self.setup.food_set, &self.meals);
        let crosses = self.setup.food_set.crosses;
        self.around = vec![0.0; if crosses { self.scent.len() } else { 0 }];
    }

    /// Lets two arrays change roles.
    pub fn swap(&mut self, pair: Pair) {
        match pair {
            Pair::Trail => std::mem::swap(&mut self.trail, &mut self.next_trail),
            Pair::Deposits => std::mem::swap(&mut self.deposits, &mut self.previous_deposits),
        }
    }
}
