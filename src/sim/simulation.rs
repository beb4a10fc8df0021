//! A running simulation on the GPU.

mod ahead;
mod alone;
mod copying;
mod feeding;
mod painter;
mod painting;
mod pulsing;

use std::sync::Arc;

use glam::{Affine3A, DAffine3};

use super::arranged::arranged;
use super::buffers::{Counts, Store};
use super::cells::check_rules;
use super::course::Course;
use super::patience::for_distances;
use super::pipelines::Pipelines;
use super::plan::Means;
use super::raster::{self, Raster};
use super::setup::Setup;
use super::snapshot::{Distances, Snapshot};
use super::sorting::{self, Segments};
use super::spread_length::check_lengths;
use super::state::{State, bias_of, looks_of, trail_objects};
use super::texel_paths::TexelPaths;
use super::transfers::{Transfers, capacity};
use super::types::{Motion, Particle, Pose};
use super::work::{Step, Work};
use super::{brute, kept, memory};
use crate::error::{Error, Result};
use crate::gpu::{Context, DeviceInfo, GpuError, Patience, Recorder, Tables};
use crate::mesh::atlas::Control;
use crate::scene::Scene;
use crate::scene::parameters::{out_of_range, restarting};
use crate::scene::problems::Problem;
use crate::scene::settings::Settings;
pub use ahead::KernelOrder;
pub use alone::KernelAlone;
pub use copying::{SnapshotCopy, StateAside, TrailCopy};
pub use feeding::{FoodOrder, PreparedFood};
use painter::Painter;
pub use painting::Areas;

/// A running simulation of a scene.
pub struct Simulation {
    ctx: Arc<Context>,
    /// For distances that are known to take long.
    patience: Patience,
    course: Course,
    pipelines: Pipelines,
    state: State,
    /// None before the first dab.
    painter: Option<Painter>,
    /// Objects that dabs leave as they are.
    spared: Vec<bool>,
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

    /// As [`new`](Self::new). `control` gets the progress of the atlas and of the distances to food, can cancel both, and names the
    /// folder in which the layout of the atlas is kept.
    ///
    /// # Errors
    /// As [`new`](Self::new), and when it was stopped.
    pub fn with_control(ctx: &Arc<Context>, scene: &Scene, control: &Control<'_>) -> Result<Self> {
        Self::from_setup(ctx, scene, Self::set_up(ctx.info(), scene, control)?)
    }

    /// The slow part of a new simulation, which needs only the limits of the device.
    ///
    /// # Errors
    /// As [`with_control`](Self::with_control).
    pub fn set_up(device: &DeviceInfo, scene: &Scene, control: &Control<'_>) -> Result<Setup> {
        memory::check(device, scene)?;
        let setup = Setup::with_control(scene, control).map_err(|error| match error {
            Error::Atlas(error) => memory::atlas_error(device, &scene.settings, error),
            error => error,
        })?;
        memory::check_atlas(device, &setup.atlas, scene.settings.atlas.size)?;
        Ok(setup)
    }

    /// The rest of a new simulation: its buffers and pipelines.
    ///
    /// # Errors
    /// When the device has no memory left.
    pub fn from_setup(ctx: &Arc<Context>, scene: &Scene, setup: Setup) -> Result<Self> {
        let patience = for_distances(&setup.distance, scene.settings.distance.method);
        let state = State::new(ctx, &scene.settings, &setup)?;
        let course = Course::new(Arc::new(setup), scene.settings.clone());
        let means = means(ctx, &course, &state);
        Ok(Self {
            patience: ctx.wait_longer(patience),
            pipelines: pipelines_of(
                ctx,
                &course.setup,
                &course.of_every_kernel(&course.settings, means),
            )?,
            state,
            ctx: ctx.clone(),
            course,
            painter: None,
            spared: Vec::new(),
        })
    }

    fn means(&self) -> Means {
        means(&self.ctx, &self.course, &self.state)
    }

    /// Records the next step. It happens when the recording is submitted.
    pub fn record_step(&mut self, rec: &mut Recorder) {
        let step = self.next_step();
        step.on_device(rec, &self.pipelines, &mut self.state);
        self.end_step();
    }

    /// The next step. The caller records it [work](Self::record_work) by work, and [ends](Self::end_step) it.
    pub(super) fn next_step(&mut self) -> Step {
        self.course.next(self.means())
    }

    /// Records one work of that step.
    pub(super) fn record_work(&mut self, rec: &mut Recorder, work: &dyn Work) {
        work.on_device(rec, &self.pipelines, &mut self.state);
    }

    /// Ends that step, whose works have all been recorded.
    pub(super) fn end_step(&mut self) {
        self.state.follow(self.course.poses());
        if self.course.has_distances() {
            self.state.near.reach = self.settings().distance.reach * self.setup().radius;
        }
    }

    /// Records nothing but the poses that the last step had, or those set since from outside: for pictures between
    /// steps.
    pub fn record_poses(&mut self, rec: &mut Recorder) {
        if let Some(poses) = self.course.moved() {
            rec.update_long(&self.state.objects.poses, &poses);
            self.state.follow(&poses);
        }
    }

    /// The poses of a picture that is drawn now: those of the last step, or those set since from outside.
    #[must_use]
    pub fn shown_poses(&self) -> Vec<Pose> {
        self.course.shown_poses()
    }

    /// Records these poses for pictures alone, one an object, which may scale. [`Self::poses`] must be recorded by the same
    /// before the next step.
    ///
    /// # Panics
    /// Where there is another number of poses than of objects.
    pub fn record_shown_poses(&mut self, rec: &mut Recorder, poses: &[Pose]) {
        assert_eq!(poses.len(), self.poses().len(), "one pose an object");
        rec.update_long(&self.state.objects.poses, poses);
        self.state.follow(poses);
    }

    /// Sets the pose of an object from the next step on, in place of the scene's; `None` restores the scene's. The pose takes scaled object
    /// coordinates to world coordinates, both as in files. Does not wait for the device.
    ///
    /// # Errors
    /// When there is no such object, or the pose is not rigid.
    pub fn set_pose(&mut self, object: usize, world_from_object: Option<DAffine3>) -> Result<()> {
        self.course.set_pose(object, world_from_object)
    }

    /// The pose of an object that was set from outside, if any.
    #[must_use]
    pub fn set_pose_of(&self, object: usize) -> Option<DAffine3> {
        self.course.set_pose_of(object)
    }

    /// The pose of each object in the last step and in pictures: maps surface coordinates to world coordinates, both
    /// counted from the scene's `origins`.
    #[must_use]
    pub fn world_from_object(&self) -> Vec<Affine3A> {
        self.course.world_from_object()
    }

    /// The poses in the layout of kernels and pictures; they change only when something has moved.
    #[must_use]
    pub fn poses(&self) -> &[Pose] {
        self.course.poses()
    }

    /// Seconds of the objects' motion in the last step.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.course.time()
    }

    /// Takes over changed settings, poses of objects among them, from the next step on.
    ///
    /// # Errors
    /// When a changed setting is out of range, or needs a restart (the message names it): make a new simulation then. When a food is too
    /// far from its object, or the diffusion length is more than four texels.
    pub fn apply(&mut self, settings: &Settings) -> Result<()> {
        self.apply_prepared(settings, None)
    }

    /// As [`apply`](Self::apply), with the distances to food already measured by [`order_food`](Self::order_food).
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
        let before = out_of_range(self.settings());
        let mut problems = out_of_range(settings).into_iter();
        if let Some(problem) = problems.find(|problem| !before.contains(problem)) {
            return Err(Error::Invalid(Problem::from(problem).to_string()));
        }
        check_rules(settings)?;
        check_lengths(settings, self.setup().radius, &self.setup().atlas)?;
        let restarting = restarting(self.settings(), settings);
        if !restarting.is_empty() {
            let keys: Vec<&str> = restarting.iter().map(|parameter| parameter.key).collect();
            return Err(Error::Invalid(format!(
                "{} cannot change while the simulation runs: restart it",
                keys.join(", ")
            )));
        }
        if let Some(key) = remeshing(self.settings(), settings) {
            return Err(Error::Invalid(format!(
                "{key} cannot change while the simulation runs: restart it"
            )));
        }
        let rearranges = settings.strategy() != self.settings().strategy()
            || settings.transfer.buffer_size != self.settings().transfer.buffer_size;
        // Everything that may fail comes first, so that a failure changes nothing.
        let means = Means {
            capacity: capacity(settings, self.setup()),
            ..self.means()
        };
        let every = self.course.of_every_kernel(settings, means);
        let pipelines = (!every.is_prepared(&self.pipelines))
            .then(|| pipelines_of(&self.ctx, self.setup(), &every))
            .transpose()?;
        let surface = &self.setup().surface;
        raster::check(surface, settings).map_err(Error::Invalid)?;
        brute::check(self.ctx.info(), surface, settings).map_err(Error::Invalid)?;
        memory::check_method(self.ctx.info(), self.setup(), settings)?;
        let served = self.served(settings, food.as_mut())?;
        let raster = (settings.uses_raster() && self.state.raster.is_none())
            .then(|| Raster::new(&self.ctx, &Counts::of(self.setup(), settings), self.setup()))
            .transpose()?;
        // They stay if objects agree later: a row that is dragged may do so on its way.
        let objects = match &self.state.trail_objects {
            Some(_) => None,
            None => trail_objects(&self.ctx, settings, self.setup())?,
        };
        if rearranges && settings.objects.len() > 1 {
            self.upload_state(self.snapshot()?, settings)?;
        }
        if let Some(pipelines) = pipelines {
            self.pipelines = pipelines;
        }
        if let Some(served) = served {
            self.serve(served);
        }
        if objects.is_some() {
            self.state.trail_objects = objects;
        }
        if raster.is_some() || !settings.uses_raster() {
            self.state.raster = raster;
        }
        let patience = for_distances(&self.setup().distance, settings.distance.method);
        self.patience = self.ctx.wait_longer(patience);
        self.course.settings = settings.clone();
        self.course.follow_settings();
        self.upload_poses()
    }

    /// Gives the objects other names, which nothing that it does depends on.
    ///
    /// # Panics
    /// If there are not as many names as objects.
    pub fn rename_objects(&mut self, names: &[String]) {
        self.course.settings.rename_objects(names);
    }

    /// Dabs leave these objects as they are from now on: one for each object; those beyond the end are painted.
    pub fn spare(&mut self, objects: &[bool]) {
        self.spared = objects.to_vec();
    }

    /// Uploads the objects' poses at the time of the last step.
    fn upload_poses(&mut self) -> Result<()> {
        if let Some(poses) = self.course.moved() {
            self.ctx.upload(&self.state.objects.poses, &poses)?;
            self.state.follow(&poses);
        }
        Ok(())
    }

    /// Steps recorded so far.
    #[must_use]
    pub fn step(&self) -> u64 {
        self.course.step()
    }

    /// The settings that the next step will use.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.course.settings
    }

    /// The device that it runs on.
    #[must_use]
    pub fn ctx(&self) -> &Arc<Context> {
        &self.ctx
    }

    /// The surface, the atlas and the start.
    #[must_use]
    pub fn setup(&self) -> &Setup {
        &self.course.setup
    }

    /// The setup, shared with other threads.
    #[must_use]
    pub fn shared_setup(&self) -> Arc<Setup> {
        Arc::clone(&self.course.setup)
    }

    /// How particles are divided into segments, of which a step sorts one.
    #[must_use]
    pub fn segments(&self) -> Segments {
        self.state.sorting.segments
    }

    /// log2 of how many parts the bins of particles have along each side.
    #[must_use]
    pub fn part_bits(&self) -> u32 {
        self.state.sorting.part_bits
    }

    /// Sorts in another way, from the next step on; results do not depend on it. Particles are divided into `segments`, a power of two, up
    /// to 16: without this call one, or more with many particles. Bins are divided into `1 << part_bits` parts along each side, up to 4:
    /// without this call one on a CPU, and 4 on other devices.
    ///
    /// # Panics
    /// If one is another number, or there is no room for so long a segment or for so many parts.
    pub fn sort_in(&mut self, segments: u32, part_bits: u32) {
        let particles = self.setup().particles.len() as u32;
        let segments = Segments::new(particles, segments);
        let room = Segments::room(particles);
        assert!(segments.longest() <= room, "room for {room} particles");
        let most = sorting::part_bits(self.setup().bins.count, false);
        assert!(part_bits <= most, "room for {most} bits of parts");
        self.state.sorting.segments = segments;
        self.state.sorting.part_bits = part_bits;
    }

    /// How many particles are alive. All recorded steps must have been submitted; waits for them if the number changes.
    ///
    /// # Errors
    /// When the device is lost.
    pub fn living_count(&self) -> Result<usize> {
        match &self.state.growth {
            Some(growth) => Ok(self.ctx.download(&growth.population)?[0].living as usize),
            None => Ok(self.setup().particles.len()),
        }
    }

    /// All buffers, in their state after the last recorded step.
    #[must_use]
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Everything, copied to the host. All recorded steps must have been submitted; waits for them.
    ///
    /// # Errors
    /// When the device is lost or its memory is full.
    pub fn snapshot(&self) -> Result<Snapshot> {
        let mut snapshot = self.course.snapshot();
        kept::download(&self.ctx, &self.state, &mut snapshot)?;
        Ok(snapshot)
    }

    /// The signed distances to other objects, copied to the host like [`snapshot`](Self::snapshot). None if there is one object, and none
    /// before the first step and before the first one after [`restore`](Self::restore).
    ///
    /// # Errors
    /// When the device is lost or its memory is full.
    pub fn distances(&self) -> Result<Option<Distances>> {
        if !self.course.has_distances() {
            return Ok(None);
        }
        Ok(Some(Distances {
            signed: self.ctx.download(&self.state.near.distances)?,
            nearest: self.ctx.download(&self.state.near.nearest)?,
        }))
    }

    /// Continues from a snapshot of the same scene, after [checking](Snapshot::check) it.
    ///
    /// # Errors
    /// When the check fails, such as for another number of particles or texels; when the device has no memory left, or cannot run a kernel.
    /// Then nothing has changed. When the device is lost; then the simulation is, too.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<()> {
        let here = (
            self.setup().particles.len(),
            self.setup().atlas.density.len(),
        );
        let there = (snapshot.particles.len(), snapshot.trail.len());
        if here != there {
            return Err(Error::Invalid(format!(
                "the checkpoint has {} particles and {} texels, the scene {} and {}: \
                 resume with the scene and the settings that it was written with",
                there.0, there.1, here.0, here.1
            )));
        }
        if self.setup().population.is_some() == snapshot.population.is_empty() {
            return Err(Error::Invalid(
                "the number of particles changes in the checkpoint or in the scene, and is constant in the other: \
                 resume with the scene and the settings that it was written with"
                    .to_owned(),
            ));
        }
        // Kernels read and write where it says.
        snapshot.check(self.setup()).map_err(|problem| {
            Error::Invalid(format!("no run can continue from this state: {problem}"))
        })?;
        let mut snapshot = snapshot.counted_from(self.setup().origin()).into_owned();
        snapshot.settle();
        // Everything that may fail while there is a device comes first, so that a failure changes nothing.
        let mut course = self.course.clone();
        let are_distances_known = course.restore(&snapshot).map_err(Error::Invalid)?;
        course.look_for_shared_cells((&snapshot.particles, &snapshot.motions));
        let poses = course.moved();
        let food = self.restored_food(&snapshot.food)?;
        let bias = bias_of(&self.ctx, &snapshot.bias)?;
        let looks = looks_of(&self.ctx, &snapshot.looks)?;
        let reads_others = bias.is_some() != self.state.bias.is_some()
            || looks.is_some() != self.state.looks.is_some();
        let means = Means {
            painted: bias.is_some(),
            looks: looks.is_some(),
            ..means(&self.ctx, &course, &self.state)
        };
        let every = course.of_every_kernel(self.settings(), means);
        let pipelines = if reads_others {
            Some(pipelines_of(&self.ctx, self.setup(), &every)?)
        } else {
            every.prepare(&mut self.pipelines)?;
            None
        };
        let arranged = self.arranged(snapshot, self.settings(), course.poses())?;
        if let Some(pipelines) = pipelines {
            self.pipelines = pipelines;
        }
        self.state.food = food;
        self.state.bias = bias;
        self.state.looks = looks;
        if !are_distances_known {
            self.state.near.reach = 0.0;
        }
        self.course = course;
        // Parts of a step may have left counts behind.
        self.ctx.fill(&self.state.deposits.front, 0)?;
        self.ctx.fill(&self.state.sorting.bins, 0)?;
        if let Some(poses) = poses {
            self.ctx.upload(&self.state.objects.poses, &poses)?;
            self.state.follow(&poses);
        }
        self.upload_arranged(arranged)
    }
}

/// The device's means for steps.
fn means(ctx: &Context, course: &Course, state: &State) -> Means {
    Means {
        paths: TexelPaths::of(ctx.info(), course.setup.atlas.texel_count() as u64),
        painted: state.bias.is_some(),
        looks: state.looks.is_some(),
        apart: course.is_apart(),
        capacity: state.transfers.capacity(),
        segments: state.sorting.segments,
        part_bits: state.sorting.part_bits,
    }
}

/// How the tables of a scene's particles are stored.
fn tables_of(ctx: &Context, setup: &Setup) -> Tables {
    memory::tables(ctx.info(), setup.particles.len() as u64)
}

/// The pipelines of a step.
fn pipelines_of(ctx: &Arc<Context>, setup: &Setup, step: &Step) -> Result<Pipelines, GpuError> {
    let mut pipelines = Pipelines::new(ctx, tables_of(ctx, setup));
    step.prepare(&mut pipelines)?;
    Ok(pipelines)
}

/// A state in the order that a strategy needs, with the memory that depends on this order.
struct Arranged {
    state: Snapshot,
    transfers: Transfers,
    /// None if what there is has the right size.
    room: Option<(Store<Particle>, Store<Motion>)>,
}

impl Simulation {
    /// Uploads a state in the order that the settings' strategy needs.
    fn upload_state(&mut self, snapshot: Snapshot, settings: &Settings) -> Result<()> {
        let arranged = self.arranged(snapshot, settings, self.course.poses())?;
        self.upload_arranged(arranged)
    }

    /// Puts a state in the order that the settings' strategy needs, with objects at these poses, and takes the memory for it.
    fn arranged(
        &self,
        snapshot: Snapshot,
        settings: &Settings,
        poses: &[Pose],
    ) -> Result<Arranged> {
        let setup = self.setup();
        let state = arranged(snapshot, setup, poses, settings.strategy());
        let counts = Counts::of(setup, settings);
        Ok(Arranged {
            transfers: Transfers::new(&self.ctx, &counts, settings, setup, &state.transfers)?,
            room: self.state.sorting.other_room(&self.ctx, &counts)?,
            state,
        })
    }

    fn upload_arranged(&mut self, arranged: Arranged) -> Result<()> {
        let Arranged {
            state,
            transfers,
            room,
        } = arranged;
        // Windows are those of this order.
        self.state.transfers = transfers;
        if let Some((particles, motions)) = room {
            self.state.sorting.particles = particles;
            self.state.sorting.motions = motions;
        }
        Ok(kept::upload(&self.ctx, &self.state, &state)?)
    }
}

/// The first differing setting of objects that is built into the surface.
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
        } else if old.glue != new.glue {
            Some(format!("object.{i}.glue"))
        } else if old.motion.model != new.motion.model {
            Some(format!("object.{i}.motion.model"))
        } else {
            (old.texel_weight != new.texel_weight).then(|| format!("object.{i}.texel_weight"))
        }
    })
}
