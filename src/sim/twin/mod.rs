//! CPU twins of the kernels: same names, same arguments, same order of statements; clarity over speed. What the host needs of
//! the same mathematics stands in modules of its own, which twins use as well: nothing but tests uses a twin.
//!
//! [`Simulation`] runs the whole step by them, so the model can be tested where there is no GPU.

mod advance;
pub mod choices;
pub mod depth;
mod diffuse;
mod diffuse_seams;
mod digest;
pub mod distance;
mod distance_brute;
mod distance_merge;
mod distance_raster;
mod distance_tiles;
mod exchange_seams;
mod feeding;
mod paint;
mod painting;
mod respawn;
pub mod ring;
mod scent;
pub mod sort;
mod summon;
pub mod transfer;
pub mod transfer_queries;
mod tree_queries;
mod turns;
pub mod unfold;
mod walk_queries;

pub use advance::{AdvanceInputs, Turn as AdvanceTurn, advance, straight_places};
pub use depth::depth_queries;
pub use diffuse::diffuse;
pub use diffuse_seams::diffuse_seams;
pub use digest::digest;
pub use distance::{DistanceInputs, distance};
pub use distance_brute::distance_brute;
pub use distance_merge::distance_merge;
pub use distance_raster::distance_raster;
pub use distance_tiles::{TileLooks, distance_tiles};
pub use exchange_seams::exchange_seams;
pub use paint::paint;
pub use respawn::respawn;
pub use scent::scent;
pub use summon::summon;
pub use tree_queries::tree_queries;
pub use walk_queries::walk_queries;

use turns::TwinTransfers;
use unfold::{UnfoldInputs, unfold};

use super::distance::{DistancePlanner, DistanceSetup};
use super::ground::Ground;
use super::kernels::DistanceMergeParams;
use super::movement::Movement;
use super::params::{StepConstants, StepParams};
use super::raster::RasterLayout;
use super::setup::Setup;
use super::snapshot::{FoodState, Snapshot};
use super::surroundings::COVERED;
use super::texel_paths::TexelPaths;
use super::transfers::arranged;
use super::turns::Turn;
use super::types::{Meal, Motion, Particle, Pose};
use crate::mesh::surface::NONE;
use crate::scene::settings::{DistanceMethod, Settings, Strategy};

/// The simulation by twins: the same state and the same step as [`super::Simulation`], on the host.
#[derive(Clone, Debug)]
pub struct Simulation {
    setup: Setup,
    /// May be changed between steps; a change of the strategy takes [`Simulation::restore`] to take effect.
    pub settings: Settings,
    particles: Vec<Particle>,
    motions: Vec<Motion>,
    trail: Vec<f32>,
    next_trail: Vec<f32>,
    deposits: Vec<u32>,
    previous_deposits: Vec<u32>,
    /// Empty where nobody has painted any.
    bias: Vec<f32>,
    meals: Vec<Meal>,
    /// Empty where there is neither food nor marker.
    scent: Vec<f32>,
    /// Of the last step.
    fed_deposit: u32,
    movement: Movement,
    poses: Vec<Pose>,
    poses_before: Vec<Pose>,
    across: Vec<u32>,
    surroundings: Vec<u16>,
    across_triangles: Vec<u32>,
    distances: Vec<f32>,
    nearest: Vec<u32>,
    planner: DistancePlanner,
    tile_states: Vec<u32>,
    margins: Vec<f32>,
    transfers: TwinTransfers,
    forms: [usize; 4],
    step: u64,
}

impl Simulation {
    /// Starts at step 0.
    #[must_use]
    pub fn new(setup: Setup, settings: Settings) -> Self {
        let texels = setup.atlas.density.len();
        let start = arranged(
            Snapshot::start(&setup),
            &setup,
            &setup.poses,
            settings.strategy(),
        );
        let poses = setup.poses.clone();
        let tile_states = vec![0; setup.distance.tiles.len()];
        let margins = vec![0.0; setup.distance.margins_len()];
        let mut simulation = Self {
            transfers: TwinTransfers::new(&settings, &setup, &start.transfers),
            particles: start.particles,
            motions: start.motions,
            surroundings: setup.surroundings.clone(),
            bias: start.bias,
            setup,
            movement: Movement::new(&settings),
            poses_before: poses.clone(),
            poses,
            settings,
            trail: vec![0.0; texels],
            next_trail: vec![0.0; texels],
            deposits: vec![0; texels],
            previous_deposits: vec![0; texels],
            meals: Vec::new(),
            scent: Vec::new(),
            fed_deposit: 1,
            distances: vec![0.0; texels],
            nearest: vec![NONE; texels],
            across: vec![NONE; texels],
            across_triangles: vec![NONE; texels],
            planner: DistancePlanner::default(),
            tile_states,
            margins,
            forms: [0; 4],
            step: 0,
        };
        simulation.serve(None);
        simulation
    }

    /// One step; what [`super::step::record`] records. Returns the sensor gaps of [`advance`].
    pub fn step(&mut self) -> Vec<f32> {
        let constants = StepConstants::new(&self.settings, TexelPaths::default())
            .with_bias(!self.bias.is_empty());
        let capacity = self.transfers.capacity();
        let mut params = StepParams::new(&self.settings, &self.setup, self.step, capacity);
        self.movement
            .set_dt(self.settings.time.dt, self.step.saturating_sub(1));
        let objects = &self.settings.objects;
        let (tracks, origins) = (&self.setup.tracks, &self.setup.origins);
        let poses = self.movement.poses(objects, tracks, origins, self.step);
        self.poses_before = std::mem::replace(&mut self.poses, poses);
        params.update_distances(
            &mut self.planner,
            &self.settings,
            &self.setup,
            self.step,
            &self.poses,
        );
        self.distance(&constants, &params);
        self.forms = [0; 4];
        let gaps = self.walk_and_change_objects(&constants, &params.turn);
        self.feed(&constants);
        if let Some(first_half) = params.first_half() {
            self.diffuse(&constants, &first_half);
            std::mem::swap(&mut self.trail, &mut self.next_trail);
        }
        self.diffuse(&constants, &params);
        exchange_seams(&self.setup.atlas.seams, &mut self.next_trail);
        std::mem::swap(&mut self.trail, &mut self.next_trail);
        std::mem::swap(&mut self.deposits, &mut self.previous_deposits);
        self.step += 1;
        gaps
    }

    fn walk_and_change_objects(&mut self, constants: &StepConstants, all: &Turn) -> Vec<f32> {
        match all.strategy {
            Strategy::None => self.advance(constants, all),
            Strategy::Respawn => {
                let gaps = self.advance(constants, all);
                self.move_border(constants, all);
                self.respawn(all);
                gaps
            }
            Strategy::Direct => {
                let gaps = self.advance(constants, all);
                self.move_border(constants, all);
                self.transfer_out(constants, all);
                self.transfers.swap();
                self.transfer_in(all);
                gaps
            }
            Strategy::Scattered | Strategy::Sequential | Strategy::Parallel => {
                let mut gaps = Vec::new();
                for turn in (0..all.count).map(|object| all.of(object)) {
                    self.transfer_in(&turn);
                    gaps.extend(self.advance(constants, &turn));
                    self.move_border(constants, &turn);
                    self.transfer_out(constants, &turn);
                    match turn.strategy {
                        Strategy::Sequential => self.defragment_sequential(&turn),
                        Strategy::Parallel => self.defragment(&turn),
                        _ => {}
                    }
                    self.transfers.swap();
                }
                gaps
            }
        }
    }

    fn distance(&mut self, constants: &StepConstants, params: &StepParams) {
        if params.distance_update.jobs.is_empty() {
            return;
        }
        let DistanceSetup {
            samples,
            tiles,
            trees,
            ..
        } = &self.setup.distance;
        let inputs = DistanceInputs {
            jobs: &params.distance_update.jobs,
            pairs: &params.distance_update.pairs,
            samples,
            tiles,
            faces: &trees.faces,
            pseudonormals: &trees.pseudonormals,
            corners: &self.setup.corners,
            nodes: &trees.nodes,
            dipoles: &trees.dipoles,
        };
        let (distances, nearest) = (&mut self.distances, &mut self.nearest);
        let mut looks = TileLooks::default();
        match self.settings.distance.method {
            DistanceMethod::Bvh => {
                looks = distance_tiles(
                    &constants.distance_tiles,
                    &params.distance_tiles,
                    &inputs,
                    &params.distance_update.moves,
                    &mut self.tile_states,
                    &mut self.margins,
                );
                distance(
                    &constants.distance,
                    &params.distance,
                    &inputs,
                    &looks,
                    distances,
                    nearest,
                );
            }
            DistanceMethod::Brute => distance_brute(
                &constants.distance_brute,
                &params.distance_brute,
                &inputs,
                distances,
                nearest,
            ),
            DistanceMethod::Raster => {
                let layout = RasterLayout::new(&self.setup);
                for round in 0..params.distance_update.rounds() {
                    let winners = distance_raster(constants, params, round, &layout, &inputs);
                    let merge = DistanceMergeParams {
                        round,
                        ..params.distance_merge
                    };
                    distance_merge(
                        &constants.distance_merge,
                        &merge,
                        &inputs,
                        &winners,
                        distances,
                        nearest,
                    );
                }
            }
        }
        exchange_seams(&self.setup.atlas.seams, &mut self.distances);
        if params.sees_across {
            let inputs = UnfoldInputs {
                jobs: &params.distance_update.jobs,
                pairs: &params.distance_update.pairs,
                samples: &self.setup.distance.samples,
                owners: &self.setup.distance.owners,
                distances: &self.distances,
                nearest: &self.nearest,
                halfedges: &self.setup.surface.halfedges,
                ground: Ground::of(&self.setup, &self.poses),
                atlas_maps: &self.setup.atlas.maps,
                listed: &looks.listed,
            };
            unfold(
                &constants.unfold,
                &params.unfold,
                &inputs,
                &mut self.across,
                &mut self.across_triangles,
                &mut self.surroundings,
            );
        }
    }

    fn diffuse(&mut self, constants: &StepConstants, params: &StepParams) {
        let atlas = &self.setup.atlas;
        diffuse(
            &constants.diffuse,
            &params.diffuse,
            &atlas.blocks,
            &self.trail,
            &self.deposits,
            &atlas.density,
            &mut self.next_trail,
            &mut self.previous_deposits,
        );
        diffuse_seams(
            &params.diffuse_seams,
            &atlas.exchange.rows,
            &atlas.exchange.entries,
            &self.trail,
            &self.deposits,
            &atlas.density,
            &mut self.next_trail,
        );
    }

    /// What it runs on.
    #[must_use]
    pub fn setup(&self) -> &Setup {
        &self.setup
    }

    /// How many particles have come in each of [`super::FORMS_OF_ADVANCE`] in the last step; zeros where all sensors walk.
    #[must_use]
    pub fn forms(&self) -> [usize; 4] {
        self.forms
    }

    /// One a texel, as the last step read them: signed distance, and the nearest triangle or
    /// [`NONE`]. Of two or more objects.
    #[must_use]
    pub fn distances(&self) -> (&[f32], &[u32]) {
        (&self.distances, &self.nearest)
    }

    /// What tiles of samples remember: what all texels of each are, and how far it is from being within reach of each other
    /// object.
    #[must_use]
    pub fn tiles(&self) -> (&[u32], &[f32]) {
        (&self.tile_states, &self.margins)
    }

    /// One a texel: where on another object walks go on, [`NONE`] where none covers it.
    #[must_use]
    pub fn across(&self) -> Vec<u32> {
        let texels = self.across.iter().zip(&self.surroundings);
        texels
            .map(|(&place, around)| if around & COVERED == 0 { NONE } else { place })
            .collect()
    }

    /// Sets where an object is from the next step on; as [`super::Simulation::set_pose`].
    ///
    /// # Errors
    /// When there is no such object, or the pose is not rigid.
    pub fn set_pose(
        &mut self,
        object: usize,
        world_from_object: Option<glam::DAffine3>,
    ) -> crate::Result<()> {
        self.movement.set_pose(object, world_from_object)
    }

    /// The state after the last step.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        Snapshot {
            step: self.step,
            movement: self.movement.save(),
            last_poses: self.poses.clone(),
            origin: self.setup.origin(),
            distance_poses: self.planner.poses().to_vec(),
            kept_pairs: self.planner.kept(),
            particles: self.particles.clone(),
            motions: self.motions.clone(),
            trail: self.trail.clone(),
            deposits: self.previous_deposits.clone(),
            transfers: self.transfers.state(self.settings.strategy()),
            bias: self.bias.clone(),
            food: FoodState {
                remaining: self.meals.iter().map(|meal| meal.remaining).collect(),
                fed_deposit: self.fed_deposit,
            },
        }
    }

    /// Goes on from a snapshot of the same scene.
    ///
    /// # Panics
    /// When its poses are damaged.
    pub fn restore(&mut self, snapshot: &Snapshot) {
        let snapshot = &*snapshot.counted_from(self.setup.origin());
        let movement = snapshot.movement_of(self.settings.objects.len());
        self.movement = movement.expect("the poses are sound");
        let objects = &self.settings.objects;
        let last = snapshot.step.saturating_sub(1);
        let (tracks, origins) = (&self.setup.tracks, &self.setup.origins);
        let poses = self.movement.poses(objects, tracks, origins, last);
        let strategy = self.settings.strategy();
        let state = arranged(snapshot.clone(), &self.setup, &poses, strategy);
        self.poses.clone_from(&snapshot.last_poses);
        self.transfers = TwinTransfers::new(&self.settings, &self.setup, &state.transfers);
        self.particles = state.particles;
        self.motions = state.motions;
        self.trail.clone_from(&snapshot.trail);
        self.previous_deposits.clone_from(&snapshot.deposits);
        self.bias.clone_from(&snapshot.bias);
        self.fed_deposit = snapshot.food.fed_deposit;
        self.serve(Some(&snapshot.food.remaining));
        self.deposits.fill(0);
        self.planner = DistancePlanner::resumed(&snapshot.distance_poses, &snapshot.kept_pairs);
        self.step = snapshot.step;
    }
}
