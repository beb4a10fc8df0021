//! A scene that runs without a window: code that `render`, `export` and `profile` share.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::{Duration, Instant};

use myxo::gpu::{
    Context, ContextOptions, Frames, GpuError, Listed, Recorder, Timings, default_cache_folder,
};
use myxo::plain_text::{Shown as _, escaped};
use myxo::scene::Scene;
use myxo::sim::checkpoint::Checkpoint;
use myxo::sim::network::Network;
use myxo::sim::yardstick::{copy_bandwidth, keep_busy};
use myxo::sim::{FORMS_OF_ADVANCE, KernelAlone, Simulation, Snapshot, arithmetic, memory};
use myxo::{Error, Result};

use super::counters::Counters;
use super::host::Watch;
use super::measures::Measure;
use super::options::{CommonOptions, DeviceOptions};
use super::progress::{Progress, SettingUp, atlas_cache};
use super::report::{
    Bandwidth, FoodLeft, HostTimes, KeptBusy, KernelTime, Report, StateHash, hash_text,
};
use super::tracing::{Tracing, spanned};
use super::{damaged, times};
use crate::{console, room};

/// The warning about a checkpoint whose scene names files by relative paths.
const NOT_FOUND_FROM_ELSEWHERE: &str = "the models lie in a folder whose name is not Unicode, so the checkpoint names them relative to it: \
    keep the checkpoint in the scene's folder, or name the scene when you resume it";

/// Frames that the host may be ahead of the device.
const FRAMES_IN_FLIGHT: usize = 2;
/// Copies that the median is taken of.
const COPIES: usize = 9;
/// Added to the device's time limit for each GiB.
const SECONDS_A_GIB: Duration = Duration::from_secs(30);

/// A device that was opened for scenes.
pub struct Opened {
    pub ctx: Arc<Context>,
    /// Does it calculate by IEEE 754, so that runs end in the same hashes as on every other such device? `None` if that was not
    /// tested.
    pub is_as_everywhere: Option<bool>,
}

/// A device, a scene on it, and the work between steps.
pub struct Session {
    pub ctx: Arc<Context>,
    pub scene: Scene,
    pub simulation: Simulation,
    pub frames: Frames,
    pub progress: Progress,
    /// The hashes of `--hash-every`.
    hashes: Vec<StateHash>,
    /// The measures of `--measure-every`.
    measures: Vec<Measure>,
    options: CommonOptions,
    started: Instant,
    first_step: u64,
    trace: Option<Tracing>,
    /// The kernels of a step, in order, and how often each runs in one that takes all distances.
    kernels: Vec<(String, u32)>,
    /// Does each kernel wait for the one before, so that it has a time of its own?
    pub separates: bool,
    /// As in [`Opened`], but false if the run continues a state of other arithmetic.
    is_as_everywhere: Option<bool>,
    /// Does one of the kernels run alone?
    is_alone: bool,
    /// How fast the device copies, once it was measured.
    bandwidth: Option<Bandwidth>,
    kept_busy: Option<KeptBusy>,
    /// While measuring: the host's times for each frame in milliseconds, to begin, to record and to submit it.
    host_ms: Option<Vec<[f64; 3]>>,
    /// Watches the host's load while times are taken.
    watch: Watch,
}

/// How a session ended.
pub struct Ending {
    /// The state after the last step.
    pub snapshot: Snapshot,
    /// From the first step to the last, including the compilation of kernels and files written on the way.
    pub wall: Duration,
    /// Steps that this session did; with earlier repetitions, those of all.
    pub steps: u64,
    /// Did writing the checkpoint fail? The error has been printed.
    pub lacks_checkpoint: bool,
}

/// Times of earlier repetitions of a measurement.
#[derive(Default)]
pub struct Earlier {
    timings: Timings,
    host_ms: Vec<[f64; 3]>,
    wall: Duration,
    steps: u64,
}

impl Session {
    /// Opens the device, sets the scene up, and continues from `--resume` if there is one. Progress is shown for `steps` steps.
    pub fn open(scene: Scene, options: &CommonOptions, steps: u64) -> Result<Self> {
        let opened = device(&options.device, std::slice::from_ref(&scene))?;
        Self::on(&opened, scene, options, steps)
    }

    /// The same on an open device.
    pub fn on(opened: &Opened, scene: Scene, options: &CommonOptions, steps: u64) -> Result<Self> {
        let ctx = &opened.ctx;
        let mut is_as_everywhere = opened.is_as_everywhere;
        let mut watch = Watch::new();
        let oddities: BTreeSet<String> = scene
            .meshes
            .iter()
            .filter(|mesh| !mesh.report.oddities().is_empty())
            .map(|mesh| format!("{}: {}", mesh.name, mesh.report))
            .collect();
        let coarse = scene.coarse_objects();
        let messages = oddities.iter().chain(&coarse);
        messages.for_each(|text| console::message(text));
        let resume = options.state.resume.as_deref();
        let checkpoint = resume.map(Checkpoint::read).transpose()?;
        memory::check(ctx.info(), &scene)?;
        let painted = checkpoint.as_ref().map(|c| &c.snapshot.bias);
        let painted = match painted {
            Some(bias) if !bias.is_empty() && scene.settings.areas.map.is_empty() => {
                memory::needed_for_painted(&scene)
            }
            _ => 0,
        };
        let looked = checkpoint.as_ref().map(|c| &c.snapshot.looks);
        let looked = match looked {
            Some(looks) if !looks.is_empty() && scene.settings.second_look.map.is_empty() => {
                memory::needed_for_painted(&scene)
            }
            _ => 0,
        };
        let on_device = memory::needed(&scene) + painted + looked;
        room::prepare(ctx, &escaped(&scene.name), &[&scene], on_device)?;
        let mut simulation = SettingUp::new(&scene.name, atlas_cache())
            .run(|control| Simulation::with_control(ctx, &scene, control))?;
        if let Some(warning) = simulation.setup().atlas.warning() {
            console::message(&format!("{}: {warning}", escaped(&scene.name)));
        }
        for warning in simulation.setup().diffusion_warnings(&scene.settings) {
            console::message(&format!("{}: {warning}", escaped(&scene.name)));
        }
        if let (Some(path), Some(checkpoint)) = (resume, checkpoint) {
            let changes = checkpoint
                .check(&scene, simulation.setup())
                .map_err(|problem| {
                    Error::Invalid(format!("cannot resume from {}: {problem}", path.shown()))
                })?;
            simulation.restore(&checkpoint.snapshot)?;
            if checkpoint.arithmetic != arithmetic::VERSION {
                is_as_everywhere = Some(false);
            }
            console::message(&format!(
                "continues from step {}{}",
                simulation.step(),
                changes
                    .iter()
                    .map(|change| format!("; {change}"))
                    .collect::<String>()
            ));
        }
        let mut frames = Frames::new(ctx, FRAMES_IN_FLIGHT)?;
        let kernels = counted(simulation.kernels(&mut frames.begin()?));
        watch.begin();
        Ok(Self {
            frames,
            kernels,
            separates: false,
            is_as_everywhere,
            is_alone: false,
            bandwidth: None,
            kept_busy: None,
            progress: Progress::new(steps, &scene.name),
            first_step: simulation.step(),
            ctx: ctx.clone(),
            scene,
            simulation,
            hashes: Vec::new(),
            measures: Vec::new(),
            options: options.clone(),
            started: Instant::now(),
            trace: None,
            host_ms: None,
            watch,
        })
    }

    /// Submits one step. Waits for it only if a hash or a check is due.
    pub fn step(&mut self) -> Result<()> {
        self.submit(|simulation, rec| {
            rec.scope("step", |rec| simulation.record_step(rec));
        })?;
        self.progress.step();
        let step = self.simulation.step();
        let state = &self.options.state;
        let is_due = |every: Option<u32>| every.is_some_and(|n| step.is_multiple_of(u64::from(n)));
        let [hash_due, measure_due] = [state.hash_every, state.measure_every].map(is_due);
        let check_due = self.options.device.validate;
        if !hash_due && !measure_due && !check_due {
            return Ok(());
        }
        self.frames.wait_idle()?;
        let snapshot = self.simulation.snapshot()?;
        if hash_due {
            let hash = hash_text(snapshot.hash());
            self.progress
                .say(&format!("step {step}: state hash {hash}"));
            self.hashes.push(StateHash { step, hash });
        }
        if measure_due {
            self.measure(&snapshot);
        }
        if check_due {
            self.check(&snapshot)?;
        }
        Ok(())
    }

    /// Submits one step, and returns the list of what it recorded.
    pub fn list_step(&mut self) -> Result<Vec<Listed>> {
        let mut listed = Vec::new();
        self.submit(|simulation, rec| {
            rec.list();
            simulation.record_step(rec);
            listed = rec.listed();
        })?;
        self.frames.wait_idle()?;
        Ok(listed)
    }

    /// Records and submits a frame; how long the host takes for that is kept, and a trace shows it.
    fn submit(&mut self, record: impl FnOnce(&mut Simulation, &mut Recorder)) -> Result<()> {
        let trace = &mut self.trace;
        let begun = Instant::now();
        let mut rec = spanned(trace, "wait", || self.frames.begin())?;
        let beginning = begun.elapsed().saturating_sub(self.frames.waited());
        let begun = Instant::now();
        if self.separates {
            rec.separate_works();
        }
        spanned(trace, "record", || record(&mut self.simulation, &mut rec));
        let recording = begun.elapsed();
        if let Some(tracing) = trace {
            tracing.submits();
        }
        let begun = Instant::now();
        spanned(trace, "submit", || self.frames.submit(rec))?;
        let took = [beginning, recording, begun.elapsed()].map(|time| time.as_secs_f64() * 1e3);
        if let Some(host_ms) = &mut self.host_ms {
            host_ms.push(took);
        }
        self.print_debug_entries();
        Ok(())
    }

    /// Prints the values that kernels passed to `debug_value`, in finished frames.
    fn print_debug_entries(&self) {
        let debug = self.ctx.debug_entries();
        if !debug.entries.is_empty() || debug.overflow > 0 {
            self.progress.say(debug.to_string().trim_end());
        }
    }

    /// Forgets what was measured so far, as after a warm-up, and keeps the times of the next `steps` steps, with a
    /// trace if there is to be one.
    pub fn begin_measuring(&mut self, steps: usize, traced: bool) -> Result<()> {
        self.forget_times()?;
        self.host_ms = Some(Vec::with_capacity(steps));
        self.frames.timings_mut().set_capacity(steps);
        if traced {
            self.trace = Some(Tracing::begin(&self.ctx)?);
        }
        self.started = Instant::now();
        self.first_step = self.simulation.step();
        Ok(())
    }

    /// Measures how fast the device copies. If there is no memory for that, the report has no bandwidth.
    pub fn measure_bandwidth(&mut self) -> Result<()> {
        self.frames.wait_idle()?;
        self.bandwidth = match copy_bandwidth(&self.ctx, COPIES) {
            Ok(measured) => measured.as_ref().map(Bandwidth::from),
            Err(error @ GpuError::OutOfMemory { .. }) => {
                let error = Error::Gpu(error);
                let text = format!("how fast the device copies is not measured: {error}");
                self.progress.say(&text);
                None
            }
            Err(error) => return Err(error.into()),
        };
        Ok(())
    }

    /// Keeps a graphics card busy until its clock is steady, before times are taken.
    pub fn keep_busy(&mut self) -> Result<()> {
        self.frames.wait_idle()?;
        self.kept_busy = keep_busy(&self.ctx)?.map(Into::into);
        Ok(())
    }

    /// The state after the steps so far.
    pub fn snapshot(&mut self) -> Result<Snapshot> {
        spanned(&mut self.trace, "wait", || self.frames.wait_idle())?;
        self.simulation.snapshot()
    }

    /// Forgets the GPU times so far.
    pub fn forget_times(&mut self) -> Result<()> {
        self.frames.wait_idle()?;
        self.frames.timings_mut().clear();
        self.watch.begin();
        Ok(())
    }

    /// Forgets the first of several steps: it compiles kernels, which does not belong to the time of a step.
    pub fn forget_first(&mut self, of_steps: u32) -> Result<()> {
        if self.simulation.step() - self.first_step == 1 && of_steps > 1 {
            self.forget_times()?;
        }
        Ok(())
    }

    /// The kernels of a step, each once, in order.
    pub fn kernels(&self) -> &[(String, u32)] {
        &self.kernels
    }

    /// Does the part of the next step before a kernel. After that no more steps are possible.
    pub fn run_before(&mut self, kernel: &str) -> Result<KernelAlone> {
        let mut alone = None;
        self.is_alone = true;
        self.submit(|simulation, rec| alone = Some(simulation.record_before(rec, kernel)))?;
        alone.expect("it was recorded")
    }

    /// Runs that kernel once, on the data that it would have in the next step.
    pub fn run_alone(&mut self, alone: &KernelAlone) -> Result<()> {
        self.submit(|simulation, rec| simulation.record_alone(rec, alone, "step"))
    }

    /// Waits for the last step, checks and keeps the state. If the checkpoint cannot be written, the error is printed and the rest
    /// continues.
    pub fn finish(&mut self) -> Result<Ending> {
        spanned(&mut self.trace, "wait", || self.frames.wait_idle())?;
        let wall = self.started.elapsed();
        self.watch.end();
        self.print_debug_entries();
        let mut snapshot = self.simulation.snapshot()?;
        self.check(&snapshot)?;
        let is_measured = self
            .measures
            .last()
            .is_some_and(|m| m.step == snapshot.step);
        if self.options.state.measure_every.is_some() && !is_measured {
            self.measure(&snapshot);
        }
        let settings = self.simulation.settings();
        let counters = Counters::of(&snapshot, self.simulation.setup(), &settings.objects);
        if let Some(warning) = counters.overflow(settings.transfer.buffer_size) {
            self.progress.say(&format!("warning: {warning}"));
        }
        if let Some(warning) = counters.full(settings.slots()) {
            self.progress.say(&format!("warning: {warning}"));
        }
        if let Some(mismatch) = snapshot.transfers.flow.mismatch() {
            self.progress.say(&format!("warning: {mismatch}"));
        }
        let mut lacks_checkpoint = false;
        if let Some(path) = &self.options.state.checkpoint {
            let checkpoint = Checkpoint::new(&self.scene, self.simulation.setup(), snapshot);
            let text = match checkpoint.write(path) {
                Ok(()) => {
                    let step = checkpoint.snapshot.step;
                    let message = format!("checkpoint at step {step}: {}", path.shown());
                    if self.scene.is_found_from_everywhere() {
                        message
                    } else {
                        format!("{message}\n{NOT_FOUND_FROM_ELSEWHERE}")
                    }
                }
                Err(error) => {
                    lacks_checkpoint = true;
                    format!("myxo: {error}")
                }
            };
            self.progress.say(&text);
            snapshot = checkpoint.snapshot;
        }
        Ok(Ending {
            steps: self.simulation.step() - self.first_step,
            snapshot,
            wall,
            lacks_checkpoint,
        })
    }

    /// Puts the times of earlier repetitions before those of this one; all count alike, and are the earlier ones of the next.
    pub fn add_earlier(&mut self, earlier: &mut Earlier, ending: &mut Ending) {
        self.frames.timings_mut().prepend(&earlier.timings);
        if let Some(host_ms) = &mut self.host_ms {
            host_ms.splice(0..0, earlier.host_ms.iter().copied());
        }
        ending.wall += earlier.wall;
        ending.steps += earlier.steps;
        *earlier = Earlier {
            timings: self.frames.timings().clone(),
            host_ms: self.host_ms.clone().unwrap_or_default(),
            wall: ending.wall,
            steps: ending.steps,
        };
    }

    /// Measures the network, and prints a line about it.
    fn measure(&mut self, snapshot: &Snapshot) {
        let network = Network::of(snapshot, self.simulation.setup());
        let measure = Measure::new(snapshot.step, network, &self.scene.settings.objects);
        self.progress.say(&measure.line());
        self.measures.push(measure);
    }

    fn check(&self, snapshot: &Snapshot) -> Result<()> {
        self.check_state(snapshot)?;
        self.check_messages()
    }

    fn check_state(&self, snapshot: &Snapshot) -> Result<()> {
        let checkpoint = self.options.state.checkpoint.as_deref();
        damaged::check(&self.scene, self.simulation.setup(), snapshot, checkpoint)
    }

    /// Fails if the validation layers have reported anything.
    pub fn check_messages(&self) -> Result<()> {
        let messages = self.ctx.messages();
        if messages.is_empty() {
            return Ok(());
        }
        Err(Error::Invalid(format!(
            "Vulkan's validation layers object:\n{}",
            messages.join("\n")
        )))
    }

    /// The report of a run that has ended.
    pub fn report(&self, ending: &Ending, interrupted: bool) -> Report {
        let setup = self.simulation.setup();
        let info = self.ctx.info();
        let times = self.frames.timings().report("step");
        Report {
            steps: ending.steps,
            state_hash: hash_text(ending.snapshot.hash()),
            // Rasterized distances are rounded differently on each device.
            hash_is_portable: (self.is_as_everywhere)
                .map(|is| is && !self.simulation.settings().uses_raster()),
            hashes: self.hashes.clone(),
            measures: self.measures.clone(),
            copy_bandwidth: self.bandwidth,
            kept_busy: self.kept_busy,
            host_step: self.host_ms.as_deref().and_then(HostTimes::of),
            wall_ms_per_step: (ending.steps > 0)
                .then(|| ending.wall.as_secs_f64() * 1e3 / ending.steps as f64),
            kernels: self.kernel_times(),
            counters: Some(Counters::of(
                &ending.snapshot,
                setup,
                &self.scene.settings.objects,
            )),
            foods: FoodLeft::all(
                &ending.snapshot,
                setup,
                &self.scene.settings.objects,
                &self.simulation.world_from_object(),
            ),
            validation: self.options.device.validate,
            interrupted,
            host_load: Some(self.watch.load()),
            ..Report::of(info, &self.scene, &self.scene.settings, setup, &times).on_this_host()
        }
    }

    /// The rows of the report; without times where the device has no timestamps.
    pub fn kernel_times(&self) -> Vec<KernelTime> {
        let times = self.frames.timings().report("step");
        if self.ctx.info().has_timestamps() {
            return times::rows(&times, self.rows_of());
        }
        let untimed = |(name, count): &(String, u32)| KernelTime {
            name: name.clone(),
            dispatches_per_step: f64::from(*count),
            ..KernelTime::default()
        };
        self.kernels.iter().map(untimed).collect()
    }

    fn rows_of(&self) -> times::Of<'_> {
        times::Of {
            setup: self.simulation.setup(),
            segments: self.simulation.segments(),
            advancing: self.advancing(),
            bandwidth: self.bandwidth,
            kept_busy: self.kept_busy,
        }
    }

    /// How many particles advance in the measured part. If kernels of other forms take their particles from a list, or the population grows
    /// and shrinks, only the device has the number.
    fn advancing(&self) -> Option<u64> {
        let is_form = |(name, _): &(String, u32)| FORMS_OF_ADVANCE[1..].contains(&name.as_str());
        let is_part = self.kernels.iter().any(is_form);
        let all = times::all_advancing(self.simulation.setup());
        all.filter(|_| !self.is_alone || !is_part)
    }

    /// The table of kernel times, or why there is none.
    pub fn table(&self, run: times::Run) -> String {
        let times = self.frames.timings().report("step");
        match times::unavailable(&times, self.ctx.info().has_timestamps()) {
            Some(why) => format!("Kernel times are unavailable: {why}.\n"),
            None => times::table(&times, self.rows_of(), run),
        }
    }

    /// The trace as JSON, and how well its tracks agree.
    pub fn trace(&mut self) -> Result<(Vec<u8>, String)> {
        spanned(&mut self.trace, "wait", || self.frames.wait_idle())?;
        match &self.trace {
            Some(tracing) => tracing.json(&self.ctx, self.frames.timings()),
            None => Ok((Vec::new(), "nothing was measured".to_owned())),
        }
    }
}

/// Each name once, in the order of first occurrence, with its count.
fn counted(names: Vec<String>) -> Vec<(String, u32)> {
    let mut counted: Vec<(String, u32)> = Vec::new();
    for name in names {
        match counted.iter_mut().find(|(known, _)| *known == name) {
            Some((_, count)) => *count += 1,
            None => counted.push((name, 1)),
        }
    }
    counted
}

/// Opens the device for scenes that are on it at the same time, and checks that it has room for all.
pub fn device(options: &DeviceOptions, scenes: &[Scene]) -> Result<Opened> {
    let needed: u64 = scenes.iter().map(memory::needed).sum();
    let ctx = Context::new(&ContextOptions {
        device: options.device.clone(),
        validation: options.validate,
        cache_folder: default_cache_folder(),
        compiler_reports: options.compiler_reports,
        // The time limit grows with the scene: a step of a large one takes long.
        timeout: ContextOptions::default().timeout + (needed >> 30) as u32 * SECONDS_A_GIB,
        ..ContextOptions::default()
    })?;
    for scene in scenes {
        memory::check(ctx.info(), scene)?;
    }
    // `--compiled` lists only the scene's kernels.
    let is_as_everywhere = if options.compiler_reports {
        None
    } else {
        Some(arithmetic::is_everywhere(&ctx)?)
    };
    if is_as_everywhere == Some(false) {
        console::message(
            "this device does not calculate by IEEE 754, so that its state hashes differ from those of other devices: `myxo selftest` says what differs",
        );
    }
    if scenes.len() > 1 {
        room::prepare(
            &ctx,
            "all together",
            &scenes.iter().collect::<Vec<_>>(),
            needed,
        )?;
    }
    Ok(Opened {
        ctx,
        is_as_everywhere,
    })
}
