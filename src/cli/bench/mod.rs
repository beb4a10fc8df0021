//! `myxo bench`: how times grow with particles, texture, edges, objects, motion, triangles.

mod measure;
mod meshes;
mod plot;
mod suite;
mod suites;

use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};
use myxo::mesh::atlas::AtlasError;
use myxo::scene::file::Reader;
use myxo::scene::parameters::grouped;
use myxo::sim::sorting::SORT_INTERVAL;
use myxo::{Error, Result};

use super::files::{Sink, check_writable};
use super::host::{self, HostLoad, Watch};
use super::options::DeviceOptions;
use super::progress::Progress;
use super::{Command, Outcome, interrupt};
use crate::console;
use measure::{Budget, Measured, Rig};
use plot::Plot;
use suite::{Case, Extent, Point, Results, Skipped, Suite, Work};
use suites::SUITES;

/// Runs of each case by default.
const RUNS: u32 = 3;
const RUNS_WHEN_QUICK: u32 = 2;
/// A former suite that is an example now.
const MOVED: &str = "choices";

/// Measure how times grow: with particles, texture, edge crossings, objects, strategies, distances, meshes
///
/// Each suite prints a table, and leaves that as SUITE.txt, SUITE.json and plots (SVG and PNG) in the folder. Cases that do not fit, or
/// would take too long, are left out with a line that says why. Ctrl-C ends early, and keeps what was measured.
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Examples:
  myxo bench --quick                            all suites in a few minutes
  myxo bench particles                          one of them, as far as memory goes
  myxo bench texture edges --out results
  myxo bench particles --up-to 1e6 --set atlas.size=512
  myxo bench --list                             the suites")]
pub struct Bench {
    /// What to measure; all suites where none is named
    #[arg(value_name = "SUITE", value_parser = names())]
    suites: Vec<String>,
    /// Lists the suites, and measures nothing
    #[arg(long)]
    list: bool,
    /// Measures fewer and smaller cases: a few minutes for all suites on two cores
    #[arg(long)]
    quick: bool,
    /// The folder for tables and plots
    #[arg(long, value_name = "DIR", default_value = "bench-results")]
    out: PathBuf,
    /// Measures each case so many times, each from the beginning: 3, with --quick 2
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    runs: Option<u32>,
    /// Leaves out cases with more than X on the suite's axis
    #[arg(long, value_name = "X", value_parser = positive)]
    up_to: Option<f64>,
    /// Sets a key of all scenes, but for what a suite sets itself; `myxo scenes --keys` lists them. May be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    #[command(flatten)]
    device: DeviceOptions,
}

/// Names of the suites, and of the former one, for which the error names the example.
fn names() -> PossibleValuesParser {
    let names = SUITES.iter().map(|suite| PossibleValue::new(suite.name));
    names
        .chain([PossibleValue::new(MOVED).hide(true)])
        .collect::<Vec<_>>()
        .into()
}

fn positive(text: &str) -> Result<f64, String> {
    let value: Result<f64, _> = text.replace('_', "").parse();
    value
        .ok()
        .filter(|value| *value > 0.0)
        .ok_or_else(|| "a positive number is expected, such as 1e6".to_owned())
}

impl Command for Bench {
    /// Checks everything that can be checked beforehand, then measures.
    fn run(&self) -> Result<Outcome> {
        if self.suites.iter().any(|name| name == MOVED) {
            let names = SUITES.each_ref().map(|suite| suite.name).join(", ");
            return Err(Error::Invalid(format!(
                "there is no suite `{MOVED}` among {names}: it is an example now, `cargo run --release --example {MOVED}`"
            )));
        }
        let is_asked = |suite: &&Suite| {
            self.suites.is_empty() || self.suites.iter().any(|name| name == suite.name)
        };
        let mut suites: Vec<&Suite> = SUITES.iter().filter(is_asked).collect();
        if self.list {
            console::print(list(&suites))?;
            return Ok(Outcome::Done);
        }
        let extent = Extent {
            is_quick: self.quick,
            up_to: self.up_to.unwrap_or(f64::INFINITY),
            set: self.set.clone(),
        };
        for suite in std::mem::take(&mut suites) {
            match self.check(suite, &extent)? {
                None => {
                    check_writable(&self.file(suite.name, "json"))?;
                    suites.push(suite);
                }
                // If no suite is named, all that can be measured are.
                Some(why) if self.suites.is_empty() => {
                    console::message(&format!("{why}: it is left out"));
                }
                Some(why) => return Err(Error::Invalid(why)),
            }
        }
        if suites.is_empty() {
            return Err(Error::Invalid(format!(
                "no suite has a case within --up-to {}: raise it",
                extent.up_to
            )));
        }
        interrupt::install()?;
        let needs_device = suites.iter().any(|s| !matches!(s.work, Work::Meshes));
        let rig = needs_device.then(|| Rig::open(&self.device)).transpose()?;
        if self.device.validate {
            console::message("the validation layers are on: these times are not worth comparing");
        }
        for (number, suite) in suites.into_iter().enumerate() {
            if interrupt::requested() {
                break;
            }
            if number > 0 {
                console::print("\n")?;
            }
            self.run_suite(suite, &extent, rig.as_ref())?;
        }
        if let Some(rig) = &rig {
            let messages = rig.ctx.messages();
            if !messages.is_empty() {
                return Err(Error::Invalid(format!(
                    "Vulkan's validation layers object:\n{}",
                    messages.join("\n")
                )));
            }
        }
        Ok(if interrupt::requested() {
            Outcome::Interrupted
        } else {
            Outcome::Done
        })
    }
}

impl Bench {
    /// Refuses suites that would measure nothing, and settings that no scene of the suite accepts. Returns why, if no case is small enough.
    fn check(&self, suite: &Suite, extent: &Extent) -> Result<Option<String>> {
        let places: Vec<f64> = match suite.work {
            Work::Scenes(cases) => {
                let cases = cases(extent)?;
                self.check_set(suite, &cases)?;
                cases.iter().map(|case| case.x).collect()
            }
            Work::Meshes if !extent.set.is_empty() && self.suites.len() == 1 => {
                return Err(Error::Invalid(format!(
                    "the suite `{}` measures no scenes, so `--set {}` would change nothing: omit it, or name another \
                     suite",
                    suite.name, extent.set[0]
                )));
            }
            Work::Meshes if self.device.device.is_some() && self.suites.len() == 1 => {
                return Err(Error::Invalid(format!(
                    "the suite `{}` measures the host, so `--device` would change nothing: omit it, or name another \
                     suite",
                    suite.name
                )));
            }
            Work::Meshes => meshes::sizes(extent).map(meshes::triangles).collect(),
        };
        let first = places.iter().copied().fold(f64::INFINITY, f64::min);
        Ok((first > extent.up_to).then(|| {
            format!(
                "no case of the suite `{}` is within --up-to {}: they begin at {} {}",
                suite.name,
                extent.up_to,
                grouped(first),
                suite.axis
            )
        }))
    }

    /// Refuses a `--set` that the suite overrides; with several suites, which may use it, this is only a warning.
    fn check_set(&self, suite: &Suite, cases: &[Case]) -> Result<()> {
        let Some(assignment) = without_effect(&self.set, cases) else {
            return Ok(());
        };
        let key = key_of(assignment);
        let why = format!("the suite `{}` sets {key} itself", suite.name);
        if self.suites.len() == 1 {
            return Err(Error::Invalid(format!(
                "{why}, so `--set {assignment}` would change nothing: omit it, or name another suite"
            )));
        }
        console::message(&format!(
            "{why}: `--set {assignment}` changes nothing in it"
        ));
        Ok(())
    }

    /// Measures a suite, prints its table and writes its files, even if it ended early or the device was lost.
    fn run_suite(&self, suite: &Suite, extent: &Extent, rig: Option<&Rig>) -> Result<()> {
        let runs = self.runs.unwrap_or(extent.of(RUNS_WHEN_QUICK, RUNS));
        let mut watch = Watch::new();
        let budget = Budget::of(self.quick, suite.warmup);
        let (points, skipped, ended) = match (&suite.work, rig) {
            (Work::Scenes(cases), Some(rig)) => {
                let cases = cases(extent)?.into_iter();
                let cases = cases.filter(|case| case.x <= extent.up_to);
                let mut cases: Vec<Measured> = cases.map(Measured::new).collect();
                let count = cases.len() as u64 * u64::from(runs);
                let mut progress = Progress::counting(count, suite.name, "cases");
                let rounds =
                    (0..runs).map(|_| rig.round(&mut cases, &budget, &mut watch, &mut progress));
                let ended = rounds.collect::<Result<Vec<()>>>().map(drop);
                progress.finish();
                let skipped = cases.iter().filter_map(skipped).collect();
                let points = cases.into_iter().filter_map(|case| case.point);
                (points.collect(), skipped, ended)
            }
            _ => {
                let (points, ended) = meshes(extent, runs, &mut watch)?;
                (points, Vec::new(), ended)
            }
        };
        let is_timed_on_device = !matches!(suite.work, Work::Meshes);
        let rig = rig.filter(|_| is_timed_on_device);
        let mut results = results(suite, rig, points, skipped, watch.load());
        results.quick = self.quick;
        results.runs = runs;
        results.warmup = suite.warmup;
        results.method = method(&suite.work, runs, &budget);
        self.finish(suite, results)?;
        ended
    }

    fn finish(&self, suite: &Suite, mut results: Results) -> Result<()> {
        let plots = (suite.plots)(&results.points);
        for plot in &plots {
            self.draw(plot, &mut results)?;
        }
        Sink::create(&self.file(suite.name, "json"))?.write(results.to_json())?;
        let text = results.text(suite.parts);
        Sink::create(&self.file(suite.name, "txt"))?.write(text.clone())?;
        console::print(text)?;
        let warning = results.host_load.warning();
        if let Some(warning) = warning.filter(|_| !results.points.is_empty()) {
            console::message(&format!("{}: {warning}", suite.name));
        }
        Ok(())
    }

    /// Writes a plot, unless it is empty.
    fn draw(&self, plot: &Plot, results: &mut Results) -> Result<()> {
        if plot.is_empty() {
            return Ok(());
        }
        for (ending, content) in [("svg", plot.svg()?.into_bytes()), ("png", plot.png()?)] {
            Sink::create(&self.file(&plot.name, ending))?.write(content)?;
        }
        results.plots.push(format!("{}.svg", plot.name));
        Ok(())
    }

    fn file(&self, name: &str, ending: &str) -> PathBuf {
        Path::new(&self.out).join(format!("{name}.{ending}"))
    }
}

/// The first assignment that does not hold in all scenes.
fn without_effect<'a>(set: &'a [String], cases: &[Case]) -> Option<&'a str> {
    let is_kept = |assignment: &str, case: &Case| {
        let mut reader = Reader::new(case.settings.clone());
        reader.assignment(assignment);
        reader
            .finish()
            .is_ok_and(|settings| settings == case.settings)
    };
    let mut numbered = set.iter().enumerate();
    let lost = numbered.find(|(number, assignment)| {
        let mut later = set[number + 1..].iter();
        // A later assignment of the same key overrides it.
        later.all(|later| key_of(later) != key_of(assignment))
            && cases.iter().any(|case| !is_kept(assignment, case))
    });
    lost.map(|(_, assignment)| assignment.as_str())
}

/// The key of a `KEY=VALUE`.
fn key_of(assignment: &str) -> &str {
    assignment.split('=').next().unwrap_or_default().trim()
}

fn skipped(measured: &Measured) -> Option<Skipped> {
    let why = measured.skipped.clone()?;
    Some(Skipped {
        case: measured.case.name(),
        why: match measured.runs() {
            0 => why,
            runs => format!("measured in {runs} of its runs, and then: {why}"),
        },
    })
}

/// A suite's results, without the method of measuring.
fn results(
    suite: &Suite,
    rig: Option<&Rig>,
    points: Vec<Point>,
    skipped: Vec<Skipped>,
    host_load: HostLoad,
) -> Results {
    let info = rig.map(|rig| rig.ctx.info());
    Results {
        suite: suite.name,
        about: suite.about,
        axis: suite.axis,
        whole: suite.whole,
        command: host::command(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        commit: myxo::commit(),
        device: info.map(|info| info.name.clone()),
        driver: info.map(|info| format!("{} {}", info.driver, info.driver_version)),
        processor: host::processor(),
        load_average: host::load_average(),
        host_load,
        copy_bandwidth: rig.and_then(|rig| rig.bandwidth),
        quick: false,
        runs: 0,
        warmup: 0,
        interrupted: interrupt::requested(),
        method: String::new(),
        points,
        skipped,
        plots: Vec::new(),
    }
}

fn method(work: &Work, runs: u32, budget: &Budget) -> String {
    let runs = match runs {
        1 => "one run of each case".to_owned(),
        _ => format!("{runs} runs of each case, in turn with the others"),
    };
    if matches!(work, Work::Meshes) {
        return format!("{runs}, by the host's clock; intervals are from the least to the most");
    }
    format!(
        "{runs}, each from the beginning: {} steps to warm up (fewer after {:.0} s; a graphics card is kept busy until its times \
         are steady), then {} by the device's timestamps (fewer \
         after {:.1} s, but {SORT_INTERVAL} up to {:.1} s, at all places between two sorts, and {} at least)\n\
         medians of all runs' steps; intervals hold the true median with 95 % where there are 6 steps or more, and at least the \
         median of every run\n\
         other: kernels without a column; between: what lies between kernels, of the mean step",
        budget.warmup,
        budget.warmup_time.as_secs_f64(),
        budget.steps,
        budget.time.as_secs_f64(),
        (measure::PATIENCE_FOR_SORTS * budget.time).as_secs_f64(),
        measure::FEWEST_STEPS,
    )
}

/// Measures the suite on the host. Results from before Ctrl-C are kept.
fn meshes(extent: &Extent, runs: u32, watch: &mut Watch) -> Result<(Vec<Point>, Result<()>)> {
    let folder =
        tempfile::tempdir().map_err(Error::io("create a folder in", std::env::temp_dir()))?;
    let mut models = meshes::models(extent)?;
    let count = models.len() as u64 * u64::from(runs);
    let mut progress = Progress::counting(count, "mesh", "cases");
    let mut ended = Ok(());
    'all: for _ in 0..runs {
        for model in &mut models {
            if interrupt::requested() {
                break 'all;
            }
            progress.doing(&format!("{} triangles", model.len()));
            watch.begin();
            let run = model.run(folder.path());
            watch.end();
            match run {
                Ok(()) => progress.step(),
                Err(Error::Atlas(AtlasError::Cancelled)) => break 'all,
                Err(error) => {
                    ended = Err(error);
                    break 'all;
                }
            }
        }
    }
    progress.finish();
    let points = models.iter().filter_map(meshes::Model::point).collect();
    Ok((points, ended))
}

fn list(suites: &[&Suite]) -> String {
    let line = |suite: &&Suite| format!("{:<10} {}\n", suite.name, suite.about);
    suites.iter().map(line).collect()
}
