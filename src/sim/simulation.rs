//! A running simulation on the GPU.

use std::sync::Arc;

use super::distance::DistancePlanner;
use super::memory;
use super::params::{StepConstants, StepParams};
use super::setup::Setup;
use super::snapshot::Snapshot;
use super::state::{Kernels, State};
use super::step;
use super::transfers::{Transfers, arranged};
use super::types::Pose;
use crate::error::{Error, Result};
use crate::gpu::{Context, DeviceInfo, Recorder};
use crate::mesh::atlas::Control;
use crate::scene::Scene;
use crate::scene::parameters::restarting;
use crate::scene::settings::{ObjectSettings, Settings};

/// A scene that grows, step by step.
pub struct Simulation {
    ctx: Arc<Context>,
    setup: Setup,
    settings: Settings,
    constants: StepConstants,
    kernels: Kernels,
    state: State,
    planner: DistancePlanner,
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

    /// The same, telling how far the atlas is, stopping where it is told to, and keeping the layout where it is told.
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
            Error::Atlas(error) => memory::atlas_error(device, error),
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
        let constants = StepConstants::new(&scene.settings);
        Ok(Self {
            kernels: Kernels::new(ctx, &constants)?,
            state: State::new(ctx, &scene.settings, &setup)?,
            ctx: ctx.clone(),
            setup,
            settings: scene.settings.clone(),
            constants,
            planner: DistancePlanner::default(),
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
        params.update_distances(&mut self.planner, &self.settings, &self.setup, self.step);
        step::record(rec, &self.kernels, &mut self.state, &params);
        self.step += 1;
    }

    /// Records number `kernel` of [`step::KERNELS`] and nothing else of the next step, to measure it. The state is
    /// none that steps lead to afterwards; [`Simulation::restore`] leads back.
    ///
    /// # Panics
    /// When there is no such kernel.
    pub fn record_alone(&self, rec: &mut Recorder, kernel: usize) {
        let mut params = self.params();
        // All distances, whatever has changed: that is what can be measured alone.
        params.update_distances(
            &mut DistancePlanner::default(),
            &self.settings,
            &self.setup,
            self.step,
        );
        let (_, record) = step::KERNELS[kernel];
        record(rec, &self.kernels, &self.state, &params);
    }

    /// Takes over changed settings, poses of objects among them, from the next step on.
    ///
    /// # Errors
    /// When a changed setting needs a restart (the message names it): make a new simulation then.
    pub fn apply(&mut self, settings: &Settings) -> Result<()> {
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
        let poses = settings
            .objects
            .iter()
            .map(ObjectSettings::world_from_object);
        let poses: Vec<Pose> = poses.map(Pose::from).collect();
        if poses != self.setup.poses {
            self.ctx.upload(&self.state.poses, &poses)?;
            self.setup.poses = poses;
        }
        let rearranges = settings.strategy() != self.settings.strategy()
            || settings.transfer.buffer_size != self.settings.transfer.buffer_size;
        if rearranges && settings.objects.len() > 1 {
            let snapshot = self.snapshot()?;
            self.upload_particles(&snapshot, settings)?;
        }
        let constants = StepConstants::new(settings);
        if constants != self.constants {
            self.kernels = Kernels::new(&self.ctx, &constants)?;
            self.constants = constants;
        }
        self.settings = settings.clone();
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

    /// The surface, the atlas and the start.
    #[must_use]
    pub fn setup(&self) -> &Setup {
        &self.setup
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
        })
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
        self.upload_particles(snapshot, &self.settings.clone())?;
        self.ctx.upload(&self.state.trail.front, &snapshot.trail)?;
        self.ctx
            .upload(&self.state.deposits.back, &snapshot.deposits)?;
        self.ctx.fill(&self.state.deposits.front, 0)?;
        self.planner.forget();
        self.step = snapshot.step;
        Ok(())
    }
}

impl Simulation {
    /// Uploads particles, and what is in flight, in the order that the settings' strategy needs.
    fn upload_particles(&mut self, snapshot: &Snapshot, settings: &Settings) -> Result<()> {
        let state = arranged(snapshot, &self.setup, settings.strategy());
        self.ctx.upload(&self.state.particles, &state.particles)?;
        self.ctx.upload(&self.state.motions, &state.motions)?;
        self.state.transfers = Transfers::new(&self.ctx, settings, &self.setup, &state.transfers)?;
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
        } else {
            (old.texel_weight != new.texel_weight).then(|| format!("object.{i}.texel_weight"))
        }
    })
}
