//! A running simulation on the GPU.

mod alone;
mod copying;
mod feeding;
mod painting;

use std::sync::Arc;

use glam::{Affine3A, DAffine3};

use super::brute;
use super::distance::DistancePlanner;
use super::memory;
use super::movement::Movement;
use super::params::{StepConstants, StepParams, physarums};
use super::patience::for_distances;
use super::pipelines::Kernels;
use super::raster::{self, Raster};
use super::setup::Setup;
use super::snapshot::{Distances, FoodState, Snapshot};
use super::state::{Bias, State};
use super::step::{self, Changes};
use super::texel_paths::TexelPaths;
use super::transfers::{Transfers, arranged};
use super::types::{Physarum, Pose};
use crate::error::{Error, Result};
use crate::gpu::{Context, DeviceInfo, Patience, Recorder};
use crate::mesh::atlas::Control;
use crate::scene::Scene;
use crate::scene::parameters::{out_of_range, restarting};
use crate::scene::problems::Problem;
use crate::scene::settings::Settings;
pub use alone::KernelAlone;
pub use copying::SnapshotCopy;
pub use feeding::{FoodOrder, PreparedFood};
pub use painting::Areas;
use painting::Painter;

/// A scene that grows, step by step.
pub struct Simulation {
    ctx: Arc<Context>,
    /// For distances that are known to take long.
    patience: Patience,
    setup: Arc<Setup>,
    settings: Settings,
    constants: StepConstants,
    kernels: Kernels,
    state: State,
    movement: Movement,
    /// Those that the last step had, which pictures need not have.
    poses_of_step: Vec<Pose>,
    /// What the commands recorded so far leave in `state.poses_before`.
    poses_before: Vec<Pose>,
    /// Likewise in `state.physarums`.
    physarums: Vec<Physarum>,
    planner: DistancePlanner,
    /// None before somebody paints.
    painter: Option<Painter>,
    /// How many particles a fed one counted as in the last step that was recorded.
    fed_deposit: u32,
    step: u64,
}

impl Simulation {
    /// Sets a scene up at step 0.
    ///
    /// # Errors
    /// When the atlas has no room for the triangles, or a buffer is larger than the device allows: then the message
    /// names the setting and the largest value that fits.
    pub fn new(ctx: &Arc<Context>, scene: &Scene) -> Result<Self> {
        Self::with_control(ctx, scene, &Control::default())
    }

    /// The same, telling how far the atlas and the measuring of food are, stopping where it is told to, and keeping the layout
    /// where it is told.
    ///
    /// # Errors
    /// As [`new`](Self::new), and when it was stopped.
    pub fn with_control(ctx: &Arc<Context>, scene: &Scene, control: &Control<'_>) -> Result<Self> {
        Self::from_setup(ctx, scene, Self::set_up(ctx.info(), scene, control)?)
    }

    /// What takes long about a new simulation, and does not need the device but for its limits.
    ///
    /// # Errors
    /// As [`with_control`](Self::with_control).
    pub fn set_up(device: &DeviceInfo, scene: &Scene, control: &Control<'_>) -> Result<Setup> {
        memory::check(device, scene)?;
        let setup = Setup::with_control(scene, control).map_err(|error| match error {
            Error::Atlas(error) => memory::atlas_error(device, &scene.settings, error),
            error => error,
        })?;
        memory::check_atlas(device, &setup.atlas)?;
        Ok(setup)
    }

    /// The rest.
    ///
    /// # Errors
    /// When the device has no memory left.
    pub fn from_setup(ctx: &Arc<Context>, scene: &Scene, setup: Setup) -> Result<Self> {
        let paths = TexelPaths::of(ctx.info(), setup.atlas.texel_count() as u64);
        let bias = Bias::of(ctx, &setup.bias)?;
        let constants = StepConstants::new(&scene.settings, paths).with_bias(bias.is_some());
        let patience = for_distances(&setup.distance, scene.settings.distance.method);
        Ok(Self {
            patience: ctx.wait_longer(patience),
            kernels: Kernels::new(ctx, &constants)?,
            state: State {
                bias,
                ..State::new(ctx, &scene.settings, &setup)?
            },
            ctx: ctx.clone(),
            movement: Movement::new(&scene.settings),
            poses_of_step: setup.poses.clone(),
            poses_before: setup.poses.clone(),
            physarums: Vec::new(),
            setup: Arc::new(setup),
            settings: scene.settings.clone(),
            constants,
            planner: DistancePlanner::default(),
            painter: None,
            fed_deposit: 1,
            step: 0,
        })
    }

    fn params(&self) -> StepParams {
        let capacity = self.state.transfers.capacity();
        StepParams::new(&self.settings, &self.setup, self.step, capacity)
    }

    /// Records the next step. It happens when the recording is submitted.
    pub fn record_step(&mut self, rec: &mut Recorder) {
        let mut params = self.params();
        let changes = self.changes();
        params.update_distances(
            &mut self.planner,
            &self.settings,
            &self.setup,
            self.step,
            &self.state.poses_recorded,
        );
        step::record(rec, &self.kernels, &mut self.state, &params, &changes);
        self.step += 1;
        self.fed_deposit = self.settings.feeding.fed_deposit;
        if self.planner.has_taken() {
            self.state.reach = self.settings.distance.reach * self.setup.radius;
        }
    }

    /// What the next step, which is recorded now, finds to be others than the one before.
    fn changes(&mut self) -> Changes {
        let before = std::mem::take(&mut self.poses_of_step);
        let changes = Changes {
            poses: self.moved_at(self.step),
            poses_before: (before != self.poses_before).then(|| before.clone()),
            physarums: self.changed_physarums(),
        };
        self.poses_before = before;
        self.poses_of_step.clone_from(&self.state.poses_recorded);
        changes
    }

    /// Records nothing but the poses that the last step had, or those set since from outside: for pictures between
    /// steps.
    pub fn record_poses(&mut self, rec: &mut Recorder) {
        let changes = Changes {
            poses: self.moved_at(self.last_step()),
            ..Changes::default()
        };
        step::pose(rec, &self.state, &changes);
    }

    /// What particles do on each object, if some have values of their own and they are others than those recorded last.
    fn changed_physarums(&mut self) -> Option<Vec<Physarum>> {
        if !self.constants.advance.own_physarum {
            return None;
        }
        let physarums = physarums(&self.settings, &self.setup);
        if physarums == self.physarums {
            return None;
        }
        self.physarums.clone_from(&physarums);
        Some(physarums)
    }

    /// The poses at a step, if they are others than those recorded last.
    fn moved_at(&mut self, step: u64) -> Option<Vec<Pose>> {
        let objects = &self.settings.objects;
        let (tracks, origins) = (&self.setup.tracks, &self.setup.origins);
        let poses = self.movement.poses(objects, tracks, origins, step);
        if poses == self.state.poses_recorded {
            return None;
        }
        self.state.poses_recorded.clone_from(&poses);
        Some(poses)
    }

    /// The step whose poses are shown: the last that was recorded, or the first.
    fn last_step(&self) -> u64 {
        self.step.saturating_sub(1)
    }

    /// Sets where an object is from the next step on, whatever the scene says about it; `None` gives it back to the
    /// scene. The pose takes scaled object coordinates to world coordinates, as files have them. Does not wait for the
    /// device.
    ///
    /// # Errors
    /// When there is no such object, or the pose is not rigid.
    pub fn set_pose(&mut self, object: usize, world_from_object: Option<DAffine3>) -> Result<()> {
        self.movement.set_pose(object, world_from_object)
    }

    /// The pose that an object was given from outside, if it was.
    #[must_use]
    pub fn set_pose_of(&self, object: usize) -> Option<DAffine3> {
        self.movement.set_pose_of(object)
    }

    /// Where each object was in the last step, and is in pictures: takes the surface's coordinates to the world's, both
    /// counted from the scene's `origins`.
    #[must_use]
    pub fn world_from_object(&self) -> Vec<Affine3A> {
        let objects = &self.settings.objects;
        let (tracks, origins) = (&self.setup.tracks, &self.setup.origins);
        self.movement
            .world_from_object(objects, tracks, origins, self.last_step())
    }

    /// The same, as pictures take it; changes only when something has moved.
    #[must_use]
    pub fn poses(&self) -> &[Pose] {
        &self.state.poses_recorded
    }

    /// Seconds of the objects' motion in the last step.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.movement.time_at(self.last_step())
    }

    /// Takes over changed settings, poses of objects among them, from the next step on.
    ///
    /// # Errors
    /// When a changed setting is out of range, or needs a restart (the message names it): make a new simulation then. When a
    /// food lies off its object.
    pub fn apply(&mut self, settings: &Settings) -> Result<()> {
        self.apply_prepared(settings, None)
    }

    /// The same, with the food of these settings measured before, as [`order_food`](Self::order_food) has it done.
    ///
    /// # Errors
    /// As [`apply`](Self::apply).
    pub fn apply_with_food(&mut self, settings: &Settings, food: PreparedFood) -> Result<()> {
        self.apply_prepared(settings, Some(food))
    }

    fn apply_prepared(
        &mut self,
        settings: &Settings,
        mut food: Option<PreparedFood>,
    ) -> Result<()> {
        let before = out_of_range(&self.settings);
        let mut problems = out_of_range(settings).into_iter();
        if let Some(problem) = problems.find(|problem| !before.contains(problem)) {
            return Err(Error::Invalid(Problem::from(problem).to_string()));
        }
        let restarting = restarting(&self.settings, settings);
        if !restarting.is_empty() {
            let keys: Vec<&str> = restarting.iter().map(|parameter| parameter.key).collect();
            return Err(Error::Invalid(format!(
                "{} cannot change while the simulation runs: restart it",
                keys.join(", ")
            )));
        }
        if let Some(key) = remeshing(&self.settings, settings) {
            return Err(Error::Invalid(format!(
                "{key} cannot change while the simulation runs: restart it"
            )));
        }
        let rearranges = settings.strategy() != self.settings.strategy()
            || settings.transfer.buffer_size != self.settings.transfer.buffer_size;
        // Whatever may fail comes first, so that a failure leaves all as it was.
        let paths = TexelPaths::of(self.ctx.info(), self.setup.atlas.texel_count() as u64);
        let constants = StepConstants::new(settings, paths).with_bias(self.state.bias.is_some());
        let made = food.as_mut().and_then(|f| f.take_kernels(&constants));
        let kernels = match made {
            None if constants != self.constants => Some(Kernels::new(&self.ctx, &constants)?),
            made => made,
        };
        let surface = &self.setup.surface;
        raster::check(surface, settings).map_err(Error::Invalid)?;
        brute::check(self.ctx.info(), surface, settings).map_err(Error::Invalid)?;
        memory::check_method(self.ctx.info(), &self.setup, settings)?;
        let served = self.served(settings, food.as_mut())?;
        let raster = (settings.uses_raster() && self.state.raster.is_none())
            .then(|| Raster::new(&self.ctx, &self.setup))
            .transpose()?;
        if rearranges && settings.objects.len() > 1 {
            let snapshot = self.snapshot()?;
            self.upload_particles(&snapshot, settings)?;
        }
        if let Some(kernels) = kernels {
            self.kernels = kernels;
            self.constants = constants;
        }
        if let Some(served) = served {
            self.serve(served);
        }
        if raster.is_some() || !settings.uses_raster() {
            self.state.raster = raster;
        }
        let patience = for_distances(&self.setup.distance, settings.distance.method);
        self.patience = self.ctx.wait_longer(patience);
        self.settings = settings.clone();
        // The last step's pose stays where it was; the next step comes by the new rate.
        self.movement.set_dt(settings.time.dt, self.last_step());
        self.upload_poses()
    }

    /// Brings the objects to where the last step's time has them, at once.
    fn upload_poses(&mut self) -> Result<()> {
        if let Some(poses) = self.moved_at(self.last_step()) {
            self.ctx.upload(&self.state.poses, &poses)?;
        }
        Ok(())
    }

    /// Steps recorded so far.
    #[must_use]
    pub fn step(&self) -> u64 {
        self.step
    }

    /// The settings that the next step will use.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The device that it runs on.
    #[must_use]
    pub fn ctx(&self) -> &Arc<Context> {
        &self.ctx
    }

    /// The surface, the atlas and the start.
    #[must_use]
    pub fn setup(&self) -> &Setup {
        &self.setup
    }

    /// The same, for another thread.
    #[must_use]
    pub fn shared_setup(&self) -> Arc<Setup> {
        Arc::clone(&self.setup)
    }

    /// Every buffer, as the last step recorded leaves it.
    #[must_use]
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Everything, copied to the host. All recorded steps must have been submitted; waits for them.
    ///
    /// # Errors
    /// When the device is lost or its memory is full.
    pub fn snapshot(&self) -> Result<Snapshot> {
        Ok(Snapshot {
            step: self.step,
            movement: self.movement.save(),
            last_poses: self.poses_of_step.clone(),
            origin: self.setup.origin(),
            distance_poses: self.planner.poses().to_vec(),
            kept_pairs: self.planner.kept(),
            particles: self.ctx.download(&self.state.particles)?,
            motions: self.ctx.download(&self.state.motions)?,
            trail: self.ctx.download(&self.state.trail.front)?,
            // The counts of the last step are at the back, for decrowding.
            deposits: self.ctx.download(&self.state.deposits.back)?,
            transfers: self.state.transfers.download(
                &self.ctx,
                self.settings.strategy(),
                self.setup.poses.len(),
            )?,
            bias: self.areas()?,
            food: FoodState {
                remaining: self.remaining()?,
                fed_deposit: self.fed_deposit,
            },
        })
    }

    /// The signed distances to other objects, copied to the host like [`snapshot`](Self::snapshot). None where there is
    /// one object, and none before the first step, also the first one after [`restore`](Self::restore).
    ///
    /// # Errors
    /// When the device is lost or its memory is full.
    pub fn distances(&self) -> Result<Option<Distances>> {
        if !self.planner.has_taken() {
            return Ok(None);
        }
        Ok(Some(Distances {
            signed: self.ctx.download(&self.state.distances)?,
            nearest: self.ctx.download(&self.state.nearest)?,
        }))
    }

    /// Goes on from a snapshot of the same scene.
    ///
    /// # Errors
    /// When it has another number of particles or texels.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<()> {
        let here = (self.setup.particles.len(), self.setup.atlas.density.len());
        let there = (snapshot.particles.len(), snapshot.trail.len());
        if here != there {
            return Err(Error::Invalid(format!(
                "the checkpoint has {} particles and {} texels, the scene {} and {}: \
                 resume with the scene and the settings that it was written with",
                there.0, there.1, here.0, here.1
            )));
        }
        let snapshot = &*snapshot.counted_from(self.setup.origin());
        let movement = snapshot.movement_of(self.settings.objects.len());
        let movement = movement.map_err(Error::Invalid)?;
        let foods = self.setup.pantry.places.len();
        snapshot.check_food(foods).map_err(Error::Invalid)?;
        let food = self.restored_food(&snapshot.food)?;
        self.take_bias(Bias::of(&self.ctx, &snapshot.bias)?)?;
        self.state.food = food;
        self.fed_deposit = snapshot.food.fed_deposit;
        self.ctx.upload(&self.state.trail.front, &snapshot.trail)?;
        self.ctx
            .upload(&self.state.deposits.back, &snapshot.deposits)?;
        self.ctx.fill(&self.state.deposits.front, 0)?;
        self.planner = DistancePlanner::resumed(&snapshot.distance_poses, &snapshot.kept_pairs);
        self.state.reach = 0.0;
        self.step = snapshot.step;
        self.movement = movement;
        self.movement
            .set_dt(self.settings.time.dt, self.last_step());
        self.upload_poses()?;
        self.poses_of_step.clone_from(&snapshot.last_poses);
        self.upload_particles(snapshot, &self.settings.clone())
    }
}

impl Simulation {
    /// Uploads particles, and what is in flight, in the order that the settings' strategy needs.
    fn upload_particles(&mut self, snapshot: &Snapshot, settings: &Settings) -> Result<()> {
        let state = arranged(
            snapshot.clone(),
            &self.setup,
            &self.state.poses_recorded,
            settings.strategy(),
        );
        // Who is under way is known by the slots of this order: there is no memory for it, or all of it changes.
        let transfers = Transfers::new(&self.ctx, settings, &self.setup, &state.transfers)?;
        self.ctx.upload(&self.state.particles, &state.particles)?;
        self.ctx.upload(&self.state.motions, &state.motions)?;
        self.state.transfers = transfers;
        Ok(())
    }
}

/// What of the objects is built into the surface, and differs.
fn remeshing(old: &Settings, new: &Settings) -> Option<String> {
    if old.objects.len() != new.objects.len() {
        return Some("the number of objects".to_owned());
    }
    let mut pairs = old.objects.iter().zip(&new.objects).enumerate();
    pairs.find_map(|(i, (old, new))| {
        if old.mesh != new.mesh {
            Some(format!("object.{i}.mesh"))
        } else if old.scale != new.scale {
            Some(format!("object.{i}.scale"))
        } else if old.distance_to != new.distance_to {
            Some(format!("object.{i}.distance_to"))
        } else if old.motion.model != new.motion.model {
            Some(format!("object.{i}.motion.model"))
        } else {
            (old.texel_weight != new.texel_weight).then(|| format!("object.{i}.texel_weight"))
        }
    })
}
