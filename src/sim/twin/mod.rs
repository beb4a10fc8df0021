//! The simulation on the host: the same steps as on the device, executed by the twins of the kernels, so that the model is tested without a
//! GPU. A twin has its kernel's name and arguments and the same order of statements; clarity comes before speed. The twins of a step are in
//! the files of [`step`](super::step), beside the parameters of their kernels; here are those of the other kernels. Mathematics that the
//! host also needs is in separate modules, which twins use: only tests and `myxo selftest` use a twin.

mod copy_words;
mod paint;
mod painting;
mod teleport;
pub mod transfer_queries;
mod tree_queries;
mod walk_queries;

pub use super::arrays::TileLooks;
pub use super::depth;
pub use super::depth::depth_queries;
pub use super::step::advance::{AdvanceInputs, straight_places};
pub use super::step::diffuse::diffuse;
pub use super::step::diffuse_seams::diffuse_seams;
pub use super::step::digest::digest;
pub use super::step::distance::{self, DistanceInputs};
pub use super::step::distance_brute::distance_brute;
pub use super::step::distance_merge::distance_merge;
pub use super::step::distance_raster::distance_raster;
pub use super::step::distance_tiles::distance_tiles;
pub use super::step::exchange_seams::exchange_seams;
pub use super::step::project::project;
pub use super::step::respawn::respawn;
pub use super::step::scent::scent;
pub use super::step::scent_across::scent_across;
pub use super::step::trail_across::trail_across;
pub use super::step::{limit, occupancy, population, sort, transfer, unfold, windows};
pub use copy_words::copy_words;
pub use paint::paint;
pub use teleport::teleport;
pub use tree_queries::tree_queries;
pub use walk_queries::walk_queries;

use std::sync::Arc;

use super::arranged::arranged;
use super::arrays::{Arrays, TransferArrays};
use super::course::Course;
use super::food::{FoodSet, places};
use super::plan::Means;
use super::pulse::Pulse;
use super::setup::Setup;
use super::snapshot::{FoodState, Snapshot};
use super::sorting::Segments;
use super::surroundings::COVERED;
use super::work::{Step, Work};
use crate::error::Result;
use crate::mesh::atlas::Control;
use crate::mesh::surface::NONE;
use crate::scene::settings::Settings;

/// The simulation on the host: the same state and the same steps as [`super::Simulation`].
#[derive(Clone, Debug)]
pub struct Simulation {
    course: Course,
    arrays: Arrays,
}

impl Simulation {
    /// Starts at step 0.
    #[must_use]
    pub fn new(setup: Setup, settings: Settings) -> Self {
        let (poses, strategy) = (setup.poses.clone(), settings.strategy());
        let start = arranged(Snapshot::start(&setup), &setup, &poses, strategy);
        let setup = Arc::new(setup);
        Self {
            arrays: Arrays::new(&setup, &settings, start),
            course: Course::new(setup, settings),
        }
    }

    /// One step.
    pub fn step(&mut self) {
        let step = self.next_step();
        step.on_host(&mut self.arrays);
    }

    /// The next step. The caller executes it [work](Self::run_work) by work.
    pub fn next_step(&mut self) -> Step {
        let capacity = self.arrays.transfers.capacity();
        let means = Means {
            segments: Segments::of(self.arrays.particles.len() as u32, true),
            part_bits: 0,
            looks: !self.arrays.weights.is_empty(),
            ..Means::of_host(!self.arrays.bias.is_empty(), capacity)
        };
        self.arrays.forms = [0; 4];
        self.course.next(means)
    }

    /// Executes one work of that step.
    pub fn run_work(&mut self, work: &dyn Work) {
        work.on_host(&mut self.arrays);
    }

    /// All arrays that steps change.
    #[must_use]
    pub fn arrays(&self) -> &Arrays {
        &self.arrays
    }

    /// The setup of the scene.
    #[must_use]
    pub fn setup(&self) -> &Setup {
        &self.course.setup
    }

    /// The settings of the next step.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.course.settings
    }

    /// The number of particles that each of [`super::FORMS_OF_ADVANCE`] processed in the last step; zeros if all sensors walk.
    #[must_use]
    pub fn forms(&self) -> [usize; 4] {
        self.arrays.forms
    }

    /// One per texel, as the last step read them: signed distance, and the nearest triangle or
    /// [`NONE`]. For scenes with two or more objects.
    #[must_use]
    pub fn distances(&self) -> (&[f32], &[u32]) {
        (&self.arrays.distances, &self.arrays.nearest)
    }

    /// State of the tiles of samples: the uniform state of each tile's texels, and how far the tile is from being within reach of each
    /// other object.
    #[must_use]
    pub fn tiles(&self) -> (&[u32], &[f32]) {
        (&self.arrays.tile_states, &self.arrays.margins)
    }

    /// One per texel: the place on another object where walks continue, [`NONE`] if no object covers it.
    #[must_use]
    pub fn across(&self) -> Vec<u32> {
        let texels = self.arrays.across.iter().zip(&self.arrays.surroundings);
        texels
            .map(|(&place, around)| if around & COVERED == 0 { NONE } else { place })
            .collect()
    }

    /// Sets the pose of an object from the next step on; as [`super::Simulation::set_pose`].
    ///
    /// # Errors
    /// When there is no such object, or the pose is not rigid.
    pub fn set_pose(
        &mut self,
        object: usize,
        world_from_object: Option<glam::DAffine3>,
    ) -> Result<()> {
        self.course.set_pose(object, world_from_object)
    }

    /// Begins a pulse with the next step; as [`super::Simulation::pulse`].
    ///
    /// # Errors
    /// When a number of it is out of its range.
    pub fn pulse(&mut self, pulse: &Pulse) -> Result<()> {
        self.course.pulse(pulse)
    }

    /// Takes over settings with other food; as [`super::Simulation::apply`].
    ///
    /// # Errors
    /// When a food is too far from its object, or foods reach too many texels.
    pub fn put_food(&mut self, settings: &Settings) -> Result<()> {
        let setup = &self.course.setup;
        let places = places(settings, &setup.surface, &setup.origins, setup.radius)?;
        let food_set = FoodSet::new(
            &setup.surface,
            &setup.atlas,
            places,
            Some(&setup.food_set),
            &Control::default(),
        )?
        .crossing(settings.scent_crosses());
        let left: Vec<u32> = self
            .arrays
            .meals
            .iter()
            .map(|meal| meal.remaining)
            .collect();
        let left = food_set.kept(&setup.food_set, &left);
        self.course.serve(food_set);
        self.arrays.setup = Arc::clone(&self.course.setup);
        self.course.settings = settings.clone();
        self.arrays.serve(Some(&left));
        Ok(())
    }

    /// The state after the last step.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        let host = self.course.snapshot();
        let Arrays {
            particles,
            motions,
            trail,
            previous_deposits,
            bias,
            weights,
            meals,
            transfers,
            population,
            ..
        } = &self.arrays;
        Snapshot {
            particles: particles.clone(),
            motions: motions.clone(),
            trail: trail.clone(),
            deposits: previous_deposits.clone(),
            transfers: transfers.state(),
            bias: bias.clone(),
            looks: weights.clone(),
            population: population.clone(),
            food: FoodState {
                remaining: meals.iter().map(|meal| meal.remaining).collect(),
                ..host.food
            },
            ..host
        }
    }

    /// Continues from a snapshot of the same scene.
    ///
    /// # Panics
    /// When its poses are damaged.
    pub fn restore(&mut self, snapshot: &Snapshot) {
        let Self { course, arrays } = self;
        let mut snapshot = snapshot.counted_from(course.setup.origin()).into_owned();
        snapshot.settle();
        course.restore(&snapshot).expect("the poses are sound");
        if let Some(poses) = course.moved() {
            arrays.poses = poses;
        }
        let strategy = course.settings.strategy();
        let state = arranged(snapshot.clone(), &course.setup, &arrays.poses, strategy);
        arrays.transfers = TransferArrays::new(&course.settings, &course.setup, &state.transfers);
        arrays.make_room(&course.settings);
        arrays.particles = state.particles;
        arrays.motions = state.motions;
        arrays.trail.clone_from(&snapshot.trail);
        arrays.previous_deposits.clone_from(&snapshot.deposits);
        arrays.deposits.fill(0);
        arrays.bins.fill(0);
        arrays.bias.clone_from(&snapshot.bias);
        arrays.weights.clone_from(&snapshot.looks);
        arrays.population.clone_from(&snapshot.population);
        arrays.serve(Some(&snapshot.food.remaining));
    }
}
