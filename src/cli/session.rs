//! A scene that runs without a window: what `render`, `profile` and `export` have in common.

use std::sync::Arc;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use myxo::gpu::{Context, ContextOptions, Frames};
use myxo::scene::Scene;
use myxo::sim::checkpoint::Checkpoint;
use myxo::sim::{Simulation, Snapshot};
use myxo::{Error, Result};

use super::console;
use super::options::CommonOptions;
use super::report::{Counters, Report, StateHash, hash_text};
use super::times;

/// Frames that the host may be ahead of the device.
const FRAMES_IN_FLIGHT: usize = 2;

/// A device, a scene on it, and what is done between steps.
pub struct Session {
    pub ctx: Arc<Context>,
    pub scene: Scene,
    pub simulation: Simulation,
    pub frames: Frames,
    /// What `--hash-every` has listed.
    pub hashes: Vec<StateHash>,
    options: CommonOptions,
    started: Instant,
    resumed_at: u64,
}

/// How a session ended.
pub struct Ending {
    /// The state after the last step.
    pub snapshot: Snapshot,
    /// From the first step to the last, compiling of kernels included.
    pub wall: Duration,
    /// Steps that this session did.
    pub steps: u64,
}

impl Session {
    /// Opens the device, sets the scene up, and goes on from `--resume` if there is one.
    pub fn open(scene: Scene, options: &CommonOptions) -> Result<Self> {
        let ctx = Context::new(&ContextOptions {
            device: options.device.device.clone(),
            validation: options.device.validate,
            ..ContextOptions::default()
        })?;
        for mesh in &scene.meshes {
            if !mesh.report.oddities().is_empty() {
                console::message(&format!("{}: {}", mesh.name, mesh.report));
            }
        }
        let checkpoint = options
            .state
            .resume
            .as_deref()
            .map(Checkpoint::read)
            .transpose()?;
        let mut simulation = Simulation::new(&ctx, &scene)?;
        if let Some(checkpoint) = checkpoint {
            simulation.restore(&checkpoint.snapshot)?;
        }
        Ok(Self {
            frames: Frames::new(&ctx, FRAMES_IN_FLIGHT)?,
            resumed_at: simulation.step(),
            ctx,
            scene,
            simulation,
            hashes: Vec::new(),
            options: options.clone(),
            started: Instant::now(),
        })
    }

    /// One step, one submit. Does not wait for it, except where a hash or a check is due.
    pub fn step(&mut self) -> Result<()> {
        let mut rec = self.frames.begin()?;
        rec.scope("step", |rec| self.simulation.record_step(rec));
        self.frames.submit(rec)?;
        let step = self.simulation.step();
        let hash_due = self
            .options
            .state
            .hash_every
            .is_some_and(|every| step.is_multiple_of(u64::from(every)));
        if !hash_due && !self.options.device.validate {
            return Ok(());
        }
        self.frames.wait_idle()?;
        let snapshot = self.simulation.snapshot()?;
        if hash_due {
            let hash = StateHash {
                step,
                hash: hash_text(snapshot.hash()),
            };
            console::message(&format!("step {step}: state hash {}", hash.hash));
            self.hashes.push(hash);
        }
        if self.options.device.validate {
            self.check(&snapshot)?;
        }
        Ok(())
    }

    /// Forgets what was measured so far, as after a warm-up, and keeps the times of the next `steps` steps.
    pub fn begin_measuring(&mut self, steps: usize) -> Result<()> {
        self.frames.wait_idle()?;
        self.frames.timings_mut().clear();
        self.frames.timings_mut().set_window(steps);
        self.started = Instant::now();
        self.resumed_at = self.simulation.step();
        Ok(())
    }

    /// Waits for the last step, checks and keeps the state.
    pub fn finish(&mut self) -> Result<Ending> {
        self.frames.wait_idle()?;
        let wall = self.started.elapsed();
        let snapshot = self.simulation.snapshot()?;
        self.check(&snapshot)?;
        if let Some(path) = &self.options.state.checkpoint {
            let checkpoint = Checkpoint {
                scene: self.scene.to_toml(),
                snapshot,
            };
            checkpoint.write(path)?;
            console::message(&format!(
                "checkpoint at step {}: {}",
                checkpoint.snapshot.step,
                path.display()
            ));
            return Ok(Ending {
                steps: self.simulation.step() - self.resumed_at,
                snapshot: checkpoint.snapshot,
                wall,
            });
        }
        Ok(Ending {
            steps: self.simulation.step() - self.resumed_at,
            snapshot,
            wall,
        })
    }

    fn check(&self, snapshot: &Snapshot) -> Result<()> {
        snapshot
            .validate(self.simulation.setup())
            .map_err(|problem| {
                Error::Invalid(format!(
                    "after step {}: {problem}; this is a bug in myxo",
                    snapshot.step
                ))
            })?;
        let messages = self.ctx.messages();
        if messages.is_empty() {
            return Ok(());
        }
        Err(Error::Invalid(format!(
            "Vulkan's validation layers object:\n{}",
            messages.join("\n")
        )))
    }
}

/// A bar that shows steps, steps a second and the time left; nothing where the standard error is no terminal.
pub fn progress(steps: u64, what: &str) -> ProgressBar {
    let style =
        ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} steps, {per_sec}, {eta} left")
            .expect("the template is well formed");
    ProgressBar::new(steps)
        .with_style(style)
        .with_message(what.to_owned())
}

impl Session {
    /// The report of a run that has ended.
    pub fn report(&self, ending: &Ending, interrupted: bool) -> Report {
        let times = self.frames.timings().report("step");
        let setup = self.simulation.setup();
        let census = ending.snapshot.census();
        let info = self.ctx.info();
        Report {
            device: info.name.clone(),
            driver: info.driver.clone(),
            scene: self.scene.name.clone(),
            seed: self.scene.settings.seed,
            steps: ending.steps,
            particles: setup.particles.len() as u64,
            atlas_size: setup.atlas.size,
            triangles: setup.surface.triangles.len() as u64,
            state_hash: hash_text(ending.snapshot.hash()),
            hashes: self.hashes.clone(),
            gpu_ms_per_step: (!times.is_empty()).then_some(times.step.mean_ms),
            wall_ms_per_step: ending.wall.as_secs_f64() * 1e3 / ending.steps.max(1) as f64,
            kernels: times::rows(&times),
            counters: Counters {
                lost: census.lost,
                doubled: census.doubled,
                trail_mass: ending.snapshot.trail_mass(setup),
            },
            validation: self.options.device.validate,
            interrupted,
            ..Report::of_this_host()
        }
    }

    /// The kernel-time table of the steps so far.
    pub fn table(&self) -> String {
        times::table(
            &self.frames.timings().report("step"),
            self.simulation.setup(),
        )
    }
}
