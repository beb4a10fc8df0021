//! `myxo selftest`: do results on this machine match the reference hashes?

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use clap::{Args, ValueEnum};
use glam::DAffine3;
use myxo::gpu::{Context, ContextOptions, Frames};
use myxo::mesh::atlas::{AtlasError, Control};
use myxo::plain_text::escaped;
use myxo::scene::builtin::SCENES;
use myxo::scene::settings::Strategy;
use myxo::scene::{Overrides, Scene};
use myxo::sim::arithmetic::{self, Broken};
use myxo::sim::beside::{Difference, first_difference};
use myxo::sim::paint::{Brush, Dab};
use myxo::sim::{Setup, Simulation, memory, twin};
use myxo::{Error, Result};
use serde_json::{Value, json};

use super::files::{Sink, check_distinct, check_unread};
use super::progress::Progress;
use super::{Command, Outcome, interrupt, unless_closed};
use crate::console;

/// Check that results on this machine match the reference hashes
///
/// Every built-in scene runs a few steps, by every strategy, on the device and by the kernels' twins on
/// the processor; some are painted on the way, and some have so few particles and texels that no group
/// of a kernel is full. States are compared as hashes with those built into the program. If one differs, the first step, the first kernel
/// and the first number are named.
///
/// A scene file has no reference hash: it runs as it is, with its own particles and texture, and its states on the device and on the
/// processor are compared with each other.
///
/// Exits 1 if anything differs.
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Examples:
  myxo selftest                          a minute without a graphics card, seconds with one
  myxo selftest --json selftest.json     also the report to send with a bug
  myxo selftest --engine cpu             without Vulkan
  myxo selftest --scene trio             one scene
  myxo selftest --scene own.toml         a scene of your own, on the device and on the processor")]
pub struct SelfTest {
    /// What runs
    #[arg(long, value_enum, default_value = "both")]
    engine: Engine,
    /// Only this built-in scene or scene file; may be repeated
    #[arg(long = "scene", value_name = "NAME|FILE", value_parser = scene_name)]
    scenes: Vec<String>,
    /// Tests this device: its number or a part of its name, as `myxo info` lists them
    #[arg(long, value_name = "N|NAME")]
    device: Option<String>,
    /// Writes the report here
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Writes the table of hashes here, as the processor has them; nothing is compared with the one that the program carries
    #[arg(long, value_name = "FILE")]
    table: Option<PathBuf>,
}

/// What runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Engine {
    /// The device, and the processor beside it
    Both,
    /// The device alone
    Gpu,
    /// The processor alone, without Vulkan
    Cpu,
}

/// The hashes that the program carries: a line a run, its scene, its name and the hash.
const KEPT: &str = include_str!("../../assets/hashes.tsv");

/// Odd numbers, so that no group of a kernel is full by chance.
const COMMON: &[&str] = &["particles.count=2001", "atlas.size=129"];

/// Steps of each run: past the sorts of the first and of the 16th step.
const STEPS: u32 = 20;

/// The transfer buffer of scenes with several objects: so small that some transfers are refused.
const BUFFER: u32 = 40;

/// In painted runs, the dabs are made before this step.
const PAINTED_IN: u32 = STEPS / 2 + 1;

/// These scenes have a painted run as well.
const PAINTED: &[&str] = &["cube", "trio"];

/// Runs with features that built-in scenes do not use: a scene, the run's name, and what is set. Most kernels have groups of 64
/// invocations, `advance` of 256: there are particles for less than one, for one, and for one more, in textures as small as they may be. No
/// run is by `raster`, whose distances are as the device draws them; so `distance_merge` is the one kernel of a step that none has.
const EXTRA: &[(&str, &str, &[&str])] = &[
    (
        "torus",
        "terms",
        &[
            "physarum.sensor_noise=0.1",
            "physarum.gravity_weight=0.1",
            "physarum.decrowding_weight=0.1",
            "physarum.favourite_density=2",
            "trail.diffusion=0.9",
        ],
    ),
    (
        "torus",
        "avoiding",
        &[
            "physarum.preference=favourite",
            "physarum.favourite_density=0",
        ],
    ),
    ("cube", "1 in 16", &["particles.count=1", "atlas.size=16"]),
    ("cube", "63 in 18", &["particles.count=63", "atlas.size=18"]),
    (
        "plane",
        "64 in 16",
        &["particles.count=64", "atlas.size=16"],
    ),
    (
        "plane",
        "65 in 17",
        &["particles.count=65", "atlas.size=17"],
    ),
    (
        "cube",
        "255 in 18",
        &["particles.count=255", "atlas.size=18"],
    ),
    (
        "plane",
        "256 in 16",
        &["particles.count=256", "atlas.size=16"],
    ),
    (
        "plane",
        "257 in 17",
        &["particles.count=257", "atlas.size=17"],
    ),
    (
        "trio",
        "own trails",
        &[
            "object.0.trail.decay=0.6",
            "object.1.trail.diffusion=0.9",
            "object.1.physarum.edge_crossing_attempts=1",
            "object.2.physarum.deposit=3",
        ],
    ),
    ("pair", "1 in 67", &["particles.count=1", "atlas.size=67"]),
    (
        "pair",
        "65 in 64",
        &[
            "particles.count=65",
            "atlas.size=64",
            "transfer.threshold=0.2",
        ],
    ),
    (
        "pair",
        "brute",
        &[
            "distance.method=brute",
            "physarum.distance_weight=0.1",
            "physarum.gravity_weight=0.1",
            "transfer.threshold=0.2",
        ],
    ),
    (
        "pair",
        "restarts",
        &[
            "transfer.strategy=respawn",
            "transfer.respawn=start",
            "particles.start=disc",
            "transfer.threshold=0.2",
        ],
    ),
    (
        "cube",
        "jones",
        &[
            "physarum.model=jones",
            "physarum.sensor_width=3",
            "physarum.random_turn=0.05",
            "physarum.sensitivity=0.5",
        ],
    ),
    (
        "sphere",
        "population",
        &[
            "physarum.model=jones",
            "particles.count=301",
            "population.frequency=3",
            "population.capacity=3001",
            "population.division_most=30",
            "population.survival_most=9",
            "population.death_probability=0.7",
        ],
    ),
    (
        "trio",
        "jones",
        &["physarum.model=jones", "physarum.occupancy_rounds=5"],
    ),
    (
        "trio",
        "trail across",
        &["trail.across=on", "trail.diffusion=0.9"],
    ),
    (
        "trio",
        "population",
        &[
            "particles.count=1001",
            "population.frequency=2",
            "population.capacity=3001",
            "population.survival_most=9",
            "population.death_probability=0.5",
            "population.hunger=7",
            "feeding.scattered=5",
            "feeding.size=0.2",
            "feeding.fed_steps=3",
        ],
    ),
    (
        "suzanne",
        "one a cell",
        &["physarum.occupancy_rounds=2", "physarum.sensing=walk"],
    ),
    (
        "trefoil",
        "move first",
        &["physarum.order=move_first", "physarum.gravity_weight=3"],
    ),
    (
        "suzanne",
        "walk",
        &["physarum.sensing=walk", "trail.diffusion_distance=2"],
    ),
];

/// A dab of every brush, on the first object of a scene and on what is near; then some of it is erased.
fn dabs(setup: &Setup) -> Vec<Dab> {
    let surface = &setup.surface;
    let (first, end) = surface.objects[0].vertices;
    let pose = DAffine3::from(&setup.poses[0]);
    let brushes = [
        Brush::Trail { amount: 5.0 },
        Brush::Attract { amount: 20.0 },
        Brush::Attract { amount: -20.0 },
        Brush::NoGo,
        Brush::Particles { share: 0.3 },
        Brush::Erase { share: 0.7 },
    ];
    let places = (0..).map(|k| first + (end - first) * k / brushes.len() as u32);
    let dabs = places.zip(brushes).map(|(vertex, brush)| {
        let place = surface.positions[vertex as usize].as_dvec3();
        Dab {
            brush,
            center: pose.transform_point3(place).as_vec3(),
            radius: 0.4 * setup.radius,
            eye: None,
            ring: None,
            number: vertex,
        }
    });
    dabs.collect()
}

/// The table's entry for a run.
#[derive(Clone, Debug)]
enum Kept {
    /// The table has no entry for the run.
    Asked(Option<String>),
    /// The table is being made.
    BeingMade,
    /// The table has built-in scenes only, and this is a file.
    Absent,
}

impl Default for Kept {
    fn default() -> Self {
        Self::Asked(None)
    }
}

/// A run, and the hashes of its final states.
#[derive(Clone, Debug, Default)]
struct Row {
    scene: String,
    run: String,
    kept: Kept,
    device: Option<String>,
    host: Option<String>,
    /// Why it did not run on the device.
    problem: Option<String>,
    difference: Option<Difference>,
    is_painted: bool,
}

impl Row {
    /// Does every state agree with the table? While the table is being made, there is nothing to compare; without a reference the device
    /// is compared with the processor.
    fn agrees(&self) -> bool {
        let mut states = [&self.device, &self.host].into_iter().flatten();
        let expected = match &self.kept {
            Kept::Asked(kept) => kept.as_ref(),
            Kept::BeingMade | Kept::Absent => self.host.as_ref(),
        };
        self.problem.is_none() && expected.is_some() && states.all(|state| Some(state) == expected)
    }
}

/// Is it the name of a built-in scene? Only these are in the table.
fn is_builtin(name: &str) -> bool {
    SCENES.iter().any(|scene| scene.name == name)
}

/// Checks that there is such a built-in scene, if it is no path. Whether a file can be loaded is seen before anything runs.
fn scene_name(name: &str) -> Result<String, String> {
    let is_path = name.contains(['.', '/', std::path::MAIN_SEPARATOR]) || Path::new(name).is_file();
    if is_builtin(name) || is_path {
        return Ok(name.to_owned());
    }
    let names: Vec<_> = SCENES.iter().map(|scene| scene.name).collect();
    Err(format!(
        "no such built-in scene, and no such file; there are {}",
        names.join(", ")
    ))
}

impl Command for SelfTest {
    /// Runs everything, and prints a line for each run, with its differences.
    fn run(&self) -> Result<Outcome> {
        let outputs = || [&self.json, &self.table].into_iter().flatten();
        outputs().try_for_each(|path| Sink::check(path))?;
        check_distinct(outputs())?;
        if self.table.is_some() && self.engine == Engine::Gpu {
            return Err(Error::Invalid(
                "--table computes the hashes on the processor: omit --engine gpu".to_owned(),
            ));
        }
        self.check_files()?;
        check_unread(outputs(), "")?;
        interrupt::install()?;
        let begun = Instant::now();
        let ctx = match self.engine {
            Engine::Cpu => None,
            Engine::Both | Engine::Gpu => Some(Context::new(&ContextOptions {
                device: self.device.clone(),
                ..ContextOptions::default()
            })?),
        };
        let broken = ctx.as_ref().map(arithmetic::broken).transpose()?;
        // The files are written even if nothing can be printed. The first error of printing is returned at the end.
        let mut printed: Result<()> = Ok(());
        let mut print = |text: String| {
            let result = console::print(text);
            if printed.is_ok() {
                printed = result;
            }
        };
        print(self.head(ctx.as_deref(), broken.as_deref()));
        let (rows, is_whole) = self.rows(ctx.as_ref(), &mut print)?;
        if let Some(path) = self.table.as_ref().filter(|_| is_whole) {
            unless_closed(Sink::create(path)?.write(table(&rows)))?;
        }
        let differing = rows.iter().filter(|row| !row.agrees()).count();
        let has_broken = broken.as_ref().is_some_and(|broken| !broken.is_empty());
        let outcome = match (is_whole, differing) {
            (false, _) => Outcome::Interrupted,
            (true, 0) if !has_broken => Outcome::Done,
            (true, _) => Outcome::Differs,
        };
        let end = match &self.table {
            _ if !is_whole => format!("\nended early, after {} states\n", rows.len()),
            Some(path) if differing == 0 => {
                format!(
                    "\n{} hashes are written to {}.\n",
                    rows.len(),
                    path.display()
                )
            }
            _ => summary(&rows, differing, broken.as_deref()),
        };
        print(end);
        // Again: masks and maps are inputs, too, and have been read by now.
        check_unread(outputs(), "")?;
        if let Some(path) = &self.json {
            let report = self.report(ctx.as_deref(), broken.as_deref(), &rows, begun);
            let report = serde_json::to_string_pretty(&report).expect("facts are plain") + "\n";
            unless_closed(Sink::create(path)?.write(report))?;
        }
        unless_closed(printed)?;
        Ok(outcome)
    }
}

impl SelfTest {
    /// The scenes that are files.
    fn files(&self) -> impl Iterator<Item = &str> {
        let scenes = self.scenes.iter().map(String::as_str);
        scenes.filter(|name| !is_builtin(name))
    }

    /// Refuses scene files that cannot be loaded or compared.
    fn check_files(&self) -> Result<()> {
        for file in self.files() {
            let name = escaped(file);
            if self.engine != Engine::Both {
                return Err(Error::Invalid(format!(
                    "{name} has no reference hash: it is compared between the device and the processor, so omit --engine"
                )));
            }
            if self.table.is_some() {
                return Err(Error::Invalid(format!(
                    "--table is for built-in scenes only: omit --scene {name}"
                )));
            }
            let scene = Scene::load(Path::new(file), &Overrides::default())?;
            if scene.settings.uses_raster() {
                return Err(Error::Invalid(format!(
                    "{name} has `distance.method = \"raster\"`, whose distances are as each device draws them: choose bvh or brute"
                )));
            }
        }
        Ok(())
    }

    /// The head of the report: what is tested, and its arithmetic.
    fn head(&self, ctx: Option<&Context>, broken: Option<&[Broken]>) -> String {
        let commit = myxo::commit().map_or(String::new(), |commit| format!(" (commit {commit})"));
        let mut text = format!("myxo {}{commit}\n", env!("CARGO_PKG_VERSION"));
        if let Some(ctx) = ctx {
            let _ = writeln!(text, "device {}", ctx.info().line());
        }
        match broken {
            None => {}
            Some([]) => text += "its arithmetic is the processor's, bit by bit\n",
            Some(broken) => {
                text += "its arithmetic is not the processor's, so its states are its own:\n";
                for Broken {
                    rule,
                    times,
                    words,
                    found,
                    expected,
                } in broken
                {
                    let words = words.map(|word| format!("{:e}", f32::from_bits(word)));
                    let _ = writeln!(
                        text,
                        "  {rule}: wrong for {times} inputs; for {} got {found:e} ({:08x}), expected {expected:e} ({:08x})",
                        words.join(", "),
                        found.to_bits(),
                        expected.to_bits()
                    );
                }
            }
        }
        let columns = match self.engine {
            Engine::Both => "device            processor",
            Engine::Gpu => "device",
            Engine::Cpu => "processor",
        };
        let _ = writeln!(text, "\n{:<9} {:<11} {columns}", "scene", "run");
        text
    }

    /// Runs everything, and prints as it goes. Returns whether it was completed.
    fn rows(
        &self,
        ctx: Option<&Arc<Context>>,
        print: &mut dyn FnMut(String),
    ) -> Result<(Vec<Row>, bool)> {
        let scenes = SCENES.iter().map(|scene| scene.name);
        let scenes: Vec<&str> = scenes
            .filter(|name| self.scenes.is_empty() || self.scenes.iter().any(|own| own == name))
            .chain(self.files())
            .collect();
        let mut progress = Progress::counting(scenes.len() as u64, "selftest", "scenes");
        let mut rows = Vec::new();
        for name in scenes {
            progress.doing(name);
            // The first runs of a scene lay its mesh out, and those that follow read it. Another scene begins without: its layout is
            // tested.
            let layouts = tempfile::tempdir().ok();
            let layouts = layouts.as_ref().map(tempfile::TempDir::path);
            for runs in runs_of(name) {
                if interrupt::requested() {
                    progress.finish();
                    return Ok((rows, false));
                }
                let own = match self.run_all(ctx, name, &runs, layouts) {
                    // Ctrl-C while setting up, or in the steps of the processor.
                    Err(Error::Atlas(AtlasError::Cancelled)) => {
                        progress.finish();
                        return Ok((rows, false));
                    }
                    own => own?,
                };
                let lines = own.iter().map(|row| line(row, self.engine) + "\n");
                print(lines.collect());
                rows.extend(own);
            }
            progress.step();
        }
        progress.finish();
        Ok((rows, true))
    }

    /// The layout of a scene, and its runs. Layouts are kept in the folder, if there is one.
    fn run_all(
        &self,
        ctx: Option<&Arc<Context>>,
        name: &str,
        runs: &Runs,
        layouts: Option<&Path>,
    ) -> Result<Vec<Row>> {
        let is_file = !is_builtin(name);
        // Files run as they are.
        let common: &[&str] = if is_file { &[] } else { COMMON };
        let set = common.iter().chain(runs.set);
        let set = set.map(|&set| set.to_owned()).collect();
        let overrides = Overrides {
            set,
            ..Overrides::default()
        };
        let scene = Scene::load(Path::new(name), &overrides)?;
        let control = Control {
            cancelled: Some(interrupt::flag()),
            cache: layouts,
            ..Control::default()
        };
        let setup = Setup::with_control(&scene, &control)?;
        let row = |run: &str, host: Option<String>| Row {
            scene: name.to_owned(),
            run: run.to_owned(),
            kept: match self.table {
                Some(_) => Kept::BeingMade,
                None if is_file => Kept::Absent,
                None => Kept::Asked(kept(name, run)),
            },
            host,
            ..Row::default()
        };
        let mut rows = Vec::new();
        if runs.has_layout {
            rows.push(row("layout", Some(layout(&setup))));
        }
        for run in &runs.runs {
            let dabs = if run.is_painted {
                dabs(&setup)
            } else {
                Vec::new()
            };
            let mut scene = scene.clone();
            if let Some(strategy) = run.strategy {
                scene.settings.transfer.strategy = strategy;
            }
            if !is_file && scene.settings.objects.len() > 1 {
                scene.settings.transfer.buffer_size = BUFFER;
            }
            let host = (self.engine != Engine::Gpu).then(|| on_host(&scene, &setup, &dabs));
            let host = host.transpose()?;
            let mut row = row(&run.name, host);
            row.is_painted = run.is_painted;
            if let Some(ctx) = ctx {
                let ran = memory::check(ctx.info(), &scene);
                match ran.and_then(|()| on_device(ctx, &scene, &setup, &dabs)) {
                    Err(error) => row.problem = Some(error.to_string()),
                    Ok(state) => row.device = Some(state),
                }
                let is_own = row.device.is_some() && row.device != row.host;
                if is_own && !row.agrees() {
                    match first_difference(ctx, &scene, &setup, STEPS, PAINTED_IN, &dabs) {
                        Err(error) => row.problem = Some(error.to_string()),
                        Ok(difference) => row.difference = difference,
                    }
                }
            }
            rows.push(row);
        }
        Ok(rows)
    }

    fn report(
        &self,
        ctx: Option<&Context>,
        broken: Option<&[Broken]>,
        rows: &[Row],
        begun: Instant,
    ) -> Value {
        let device = ctx.map(|ctx| {
            let info = ctx.info();
            json!({
                "name": info.name,
                "kind": info.kind.as_str(),
                "driver": info.driver,
                "driver_version": info.driver_version,
                "api_version": info.api_version,
                "subgroup_size": info.subgroup_size,
                "max_storage_buffer_range": info.max_storage_buffer_range,
                "max_texel_buffer_elements": info.max_texel_buffer_elements,
                "reads_blocks": info.reads_blocks,
                "has_pages": info.has_pages,
            })
        });
        let broken = broken.map(|broken| {
            let rules = broken.iter().map(|broken| {
                json!({
                    "rule": broken.rule,
                    "times": broken.times,
                    "words": broken.words,
                    "found": broken.found.to_bits(),
                    "expected": broken.expected.to_bits(),
                })
            });
            rules.collect::<Vec<_>>()
        });
        let rows = rows.iter().map(|row| {
            json!({
                "scene": row.scene,
                "run": row.run,
                "painted": row.is_painted,
                "agrees": row.agrees(),
                "expected": match &row.kept {
                    Kept::Asked(kept) => kept.as_deref(),
                    Kept::BeingMade | Kept::Absent => None,
                },
                "device": row.device,
                "processor": row.host,
                "problem": row.problem,
                "difference": row.difference.as_ref().map(|difference| json!({
                    "step": difference.step,
                    "kernel": difference.kernel,
                    "field": difference.field,
                    "element": difference.element,
                    "number": difference.column,
                    "device": difference.device,
                    "processor": difference.host,
                    "elements": difference.count,
                })),
            })
        });
        json!({
            "version": env!("CARGO_PKG_VERSION"),
            "commit": myxo::commit(),
            "steps": STEPS,
            "device": device,
            "processor": super::host::processor(),
            "broken_rules": broken,
            "runs": rows.collect::<Vec<_>>(),
            "seconds": begun.elapsed().as_secs_f64(),
        })
    }
}

/// Runs that share a layout.
struct Runs {
    set: &'static [&'static str],
    has_layout: bool,
    runs: Vec<Run>,
}

/// One of them.
struct Run {
    name: String,
    /// None takes that of the settings.
    strategy: Option<Strategy>,
    is_painted: bool,
}

impl Run {
    fn new(name: &str, strategy: Option<Strategy>) -> Self {
        Self {
            name: name.to_owned(),
            strategy,
            is_painted: false,
        }
    }
}

fn runs_of(name: &str) -> Vec<Runs> {
    let Some(scene) = SCENES.iter().find(|scene| scene.name == name) else {
        return vec![Runs {
            set: &[],
            has_layout: false,
            runs: vec![Run::new("steps", None)],
        }];
    };
    let objects = scene.text.matches("[[object]]").count();
    let mut runs: Vec<Run> = if objects > 1 {
        let all = Strategy::ALL.iter();
        all.map(|&strategy| Run::new(strategy.word(), Some(strategy)))
            .collect()
    } else {
        vec![Run::new("steps", None)]
    };
    if PAINTED.contains(&name) {
        runs.push(Run {
            is_painted: true,
            ..Run::new("painted", None)
        });
    }
    let own = Runs {
        // Its objects hardly touch.
        set: if name == "pair" {
            &["transfer.threshold=0.2"]
        } else {
            &[]
        },
        has_layout: true,
        runs,
    };
    let extra = EXTRA.iter().filter(|(scene, ..)| *scene == name);
    let extra = extra.map(|(_, run, set)| Runs {
        set,
        has_layout: false,
        runs: vec![Run::new(run, None)],
    });
    std::iter::once(own).chain(extra).collect()
}

/// A hash of the places of triangles in the texture, and of particles at their start.
fn layout(setup: &Setup) -> String {
    let mut crc = crc32fast::Hasher::new();
    crc.update(bytemuck::cast_slice(&setup.atlas.maps));
    crc.update(bytemuck::cast_slice(&setup.particles));
    crc.update(bytemuck::cast_slice(&setup.motions));
    crc.update(bytemuck::cast_slice(&setup.distance.samples));
    format!("{:08x}", crc.finalize())
}

fn on_host(scene: &Scene, setup: &Setup, dabs: &[Dab]) -> Result<String> {
    let mut simulation = twin::Simulation::new(setup.clone(), scene.settings.clone());
    for step in 1..=STEPS {
        // A file may have many particles.
        if interrupt::requested() {
            return Err(AtlasError::Cancelled.into());
        }
        for dab in dabs.iter().filter(|_| step == PAINTED_IN) {
            simulation.paint(dab)?;
        }
        simulation.step();
    }
    Ok(hash(simulation.snapshot().hash()))
}

fn on_device(ctx: &Arc<Context>, scene: &Scene, setup: &Setup, dabs: &[Dab]) -> Result<String> {
    let mut simulation = Simulation::from_setup(ctx, scene, setup.clone())?;
    let mut frames = Frames::new(ctx, 2)?;
    for step in 1..=STEPS {
        let mut rec = frames.begin()?;
        for dab in dabs.iter().filter(|_| step == PAINTED_IN) {
            simulation.paint(&mut rec, dab)?;
        }
        simulation.record_step(&mut rec);
        frames.submit(rec)?;
    }
    frames.wait_idle()?;
    Ok(hash(simulation.snapshot()?.hash()))
}

fn hash(hash: u64) -> String {
    format!("{hash:016x}")
}

/// The hash that the program carries.
fn kept(scene: &str, run: &str) -> Option<String> {
    let lines = KEPT.lines().filter(|line| !line.starts_with('#'));
    let mut found = lines.filter_map(|line| {
        let mut columns = line.split('\t');
        (columns.next() == Some(scene) && columns.next() == Some(run))
            .then(|| columns.next().unwrap_or_default().to_owned())
    });
    found.next()
}

/// The table of these runs.
fn table(rows: &[Row]) -> String {
    let mut text = format!(
        "# States of built-in scenes after {STEPS} steps ({}), and where they begin.\n\
         # Made by `make hashes`. A change that alters any of them says why in CHANGELOG.md.\n\
         # scene\trun\thash\n",
        COMMON.join(", ")
    );
    for row in rows {
        let state = row.host.as_deref().unwrap_or_default();
        let _ = writeln!(text, "{}\t{}\t{state}", row.scene, row.run);
    }
    text
}

fn line(row: &Row, engine: Engine) -> String {
    let mut text = format!("{:<9} {:<11}", escaped(&row.scene), row.run);
    let columns = match engine {
        Engine::Both => &[&row.device, &row.host][..],
        Engine::Gpu => &[&row.device],
        Engine::Cpu => &[&row.host],
    };
    for state in columns {
        let _ = write!(text, " {:<17}", state.as_deref().unwrap_or("-"));
    }
    let _ = match (&row.kept, row.agrees()) {
        (Kept::BeingMade, true) => Ok(()),
        (Kept::BeingMade, false) => write!(text, " DIFFERS"),
        (Kept::Absent, true) => write!(text, " equal, no reference"),
        (Kept::Absent, false) => write!(text, " DIFFERS, no reference"),
        (_, true) => write!(text, " as expected"),
        (Kept::Asked(Some(kept)), false) => write!(text, " DIFFERS, expected {kept}"),
        (Kept::Asked(None), false) => write!(text, " is not in the table"),
    };
    if let Some(problem) = &row.problem {
        let _ = write!(text, "\n    {problem}");
    }
    if let Some(difference) = &row.difference {
        let _ = write!(text, "\n    {difference}");
    }
    text
}

fn summary(rows: &[Row], differing: usize, broken: Option<&[Broken]>) -> String {
    let all = rows.len();
    let has_reference = rows.iter().any(|row| !matches!(row.kept, Kept::Absent));
    let found = if has_reference {
        "as expected"
    } else {
        "equal on the device and on the processor"
    };
    let what = if broken.is_some() {
        "device"
    } else {
        "processor"
    };
    let has_broken = broken.is_some_and(|broken| !broken.is_empty());
    match (differing, has_broken) {
        (0, false) => format!(
            "\n{all} of {all} states are {found}: results of this {what} can be compared with those of any other by their hashes.\n"
        ),
        (0, true) => format!(
            "\n{all} of {all} states are {found}, but the arithmetic of this {what} is not: other runs may differ.\n"
        ),
        _ => format!(
            "\n{differing} of {all} states differ: compare hashes of this {what} with its own only.\n"
        ),
    }
}
