//! `myxo profile`: the GPU time of every kernel.

mod barriers;
mod compiled;
mod turns;

use std::path::PathBuf;

use clap::Args;
use myxo::mesh::atlas::AtlasError;
use myxo::plain_text::{Shown as _, escaped};
use myxo::scene::Scene;
use myxo::scene::suggest::nearest;
use myxo::{Error, Result};

use super::files::{Sink, check_distinct};
use super::host::Watch;
use super::options::CommonOptions;
use super::report::{Repetition, Report, Times};
use super::session::{Earlier, Ending, Session};
use super::times::Run;
use super::{Command, Outcome, interrupt, ratios, unless_closed};
use crate::console;

/// Measure the GPU time of every kernel
///
/// The report has mean, median, 95th percentile, standard deviation, minimum and maximum over the steps, the interval in
/// which the median lies with 95 % confidence, throughput, and the bytes that a kernel must read and write, which are compared
/// with what copies get through.
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Examples:
  myxo profile torus                            a table
  myxo profile torus --steps 500 --json > torus.json
  myxo profile cube --kernel advance            one kernel alone
  myxo profile trio --kernel transfer_out       any that a step of the scene has
  myxo profile trio --barriers                  what a step records, and why each barrier is there
  myxo profile torus --compiled                 what the driver's compiler says of each kernel
  myxo profile cube --trace cube.trace.json     for ui.perfetto.dev
  myxo profile torus --repeat 3 --report a.json
  myxo profile --compare a.json b.json          was there a change, and is it one?
  myxo profile trio --set transfer.strategy=none --against transfer.strategy=parallel
                                                what a setting costs, steps in turn
  myxo profile torus --against cube             the same for another scene")]
pub struct Profile {
    /// A built-in name, a .toml file, a model, or a built-in mesh such as builtin:torus?tube=0.2; with --resume it may be left out
    #[arg(required_unless_present_any = ["compare", "resume"])]
    scene: Option<PathBuf>,
    /// Prints the ratios of the second report's times to the first one's, each with the interval in which it lies with 95 %
    /// confidence, and says what makes them doubtful. With --repeat the spread from run to run counts, too
    #[arg(
        long,
        num_args = 2,
        value_names = ["A.json", "B.json"],
        exclusive = true
    )]
    compare: Option<Vec<PathBuf>>,
    /// How many steps to measure
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..))]
    steps: u32,
    /// Steps before that, which are not measured: the first ones compile kernels, and trails have yet to form
    #[arg(long, value_name = "N", default_value_t = 50)]
    warmup: u32,
    /// Does the whole measurement so many times, each from the beginning, and puts the steps of all of them together
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000))]
    repeat: u32,
    /// Measures this kernel alone: after the warm-up it runs --steps times on the data of its first dispatch in the next step, with no
    /// other kernel between; the data are restored before each run, which is not measured. Every kernel of the scene's step can be named,
    /// those that take distances among them: they use the distances of the step before, or, if nothing has moved since, compute all
    /// distances as the first step does. The state hash and --checkpoint are those of the warm-up's end
    #[arg(long, value_name = "NAME")]
    kernel: Option<String>,
    /// Lets kernels overlap that do not depend on each other, as they do when nothing is measured, and reports the time of whole
    /// steps only. By default each kernel waits for the one before, so that it has a time of its own
    #[arg(long, conflicts_with_all = ["kernel", "against", "trace"])]
    overlap: bool,
    /// Lists what the step after the warm-up records, in order: kernels, copies, and every barrier with what it is for. Nothing
    /// is measured
    #[arg(long, conflicts_with_all = ["kernel", "against", "trace", "report", "repeat", "steps", "checkpoint", "json", "overlap"])]
    barriers: bool,
    /// Lists what the driver says of each kernel of a step as it has compiled it, such as registers, spilled ones and how many
    /// subgroups run side by side. Drivers without VK_KHR_pipeline_executable_properties say nothing. Nothing is measured
    #[arg(long, conflicts_with_all = ["kernel", "against", "trace", "report", "repeat", "steps", "checkpoint", "overlap", "barriers"])]
    compiled: bool,
    /// Measures this against the scene: another scene, or the same with a key that is set otherwise; may be repeated, once
    /// with a scene. The two take their steps in turn, so that whatever slows the machine slows both, and the ratio of
    /// each pair of steps counts. What else is given holds for both
    #[arg(
        long,
        value_name = "SCENE|KEY=VALUE",
        conflicts_with_all = ["kernel", "trace", "checkpoint", "resume", "hash_every", "measure_every"]
    )]
    against: Vec<String>,
    /// Prints the report as JSON instead of the table
    #[arg(long)]
    json: bool,
    /// Writes the report as JSON
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Writes a trace for chrome://tracing or ui.perfetto.dev: what the host and the GPU do when, on one clock; of the
    /// last repetition
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
    #[command(flatten)]
    common: CommonOptions,
}

impl Command for Profile {
    /// Checks everything that can be checked beforehand, then measures.
    fn run(&self) -> Result<Outcome> {
        if let Some(files) = &self.compare {
            let [a, b] = [&files[0], &files[1]].map(|file| Report::read(file));
            console::print(comparison(&a?, &b?)?)?;
            return Ok(Outcome::Done);
        }
        let files = self.report.iter().chain(&self.trace);
        check_distinct(files.chain(&self.common.state.checkpoint))?;
        let scene = self.common.load(self.scene.as_deref())?;
        let other = (!self.against.is_empty())
            .then(|| turns::other(self, self.scene.as_deref().unwrap_or("".as_ref())))
            .transpose()?;
        interrupt::install()?;
        let report_sink = self.report.as_deref().map(Sink::create).transpose()?;
        let trace_sink = self.trace.as_deref().map(Sink::create).transpose()?;
        if self.barriers {
            return self.list(scene);
        }
        if self.compiled {
            return self.list_compiled(scene);
        }
        if let Some(other) = other {
            return turns::run(self, &[scene, other], report_sink);
        }
        let mut measured = Measured::new();
        let mut results: Option<Results> = None;
        let mut interrupted = false;
        for _ in 0..self.repeat {
            match self.measure(&scene, &mut measured) {
                Ok((session, ending, completed)) => {
                    results = Some(self.results(session, ending, &mut measured)?);
                    interrupted = !completed;
                }
                // Ctrl-C while setting up: there are the results of the repetitions before.
                Err(Error::Atlas(AtlasError::Cancelled)) if results.is_some() => interrupted = true,
                Err(error) => return Err(error),
            }
            if interrupted {
                break;
            }
        }
        let results = results.expect("there is at least one repetition");
        let sinks = [report_sink, trace_sink];
        self.output(results, &measured.watch, interrupted, sinks)
    }
}

impl Profile {
    /// Lists what a step records.
    fn list(&self, scene: Scene) -> Result<Outcome> {
        let mut session = Session::open(scene, &self.common, u64::from(self.warmup) + 1)?;
        if !repeat(self.warmup, || session.step())? {
            return Ok(Outcome::Interrupted);
        }
        let listed = session.list_step()?;
        session.check_messages()?;
        session.progress.finish();
        let step = session.simulation.step();
        console::print(barriers::text(&escaped(&session.scene.name), step, &listed))?;
        Ok(Outcome::Done)
    }

    /// Lists what the driver says of the kernels of the first steps.
    fn list_compiled(&self, scene: Scene) -> Result<Outcome> {
        let mut common = self.common.clone();
        common.device.compiler_reports = true;
        let mut session = Session::open(scene, &common, u64::from(self.warmup))?;
        if !repeat(self.warmup, || session.step())? {
            return Ok(Outcome::Interrupted);
        }
        session.check_messages()?;
        session.progress.finish();
        let kernels = session.kernels();
        let driver = compiled::driver(session.ctx.info());
        let Some(mut all) = session.ctx.compiled() else {
            return Err(Error::Invalid(compiled::no_statistics(&driver)));
        };
        all.retain(|one| kernels.iter().any(|(kernel, _)| kernel == one.kernel));
        console::print(if self.json {
            compiled::json(&driver, &all)
        } else {
            compiled::text(&escaped(&session.scene.name), &driver, &all)
        })?;
        Ok(Outcome::Done)
    }

    /// Does the whole measurement once; returns whether it was completed.
    fn measure(&self, scene: &Scene, measured: &mut Measured) -> Result<(Session, Ending, bool)> {
        let steps = u64::from(self.warmup) + u64::from(self.steps);
        let mut session = Session::open(scene.clone(), &self.common, steps)?;
        session.separates = !self.overlap;
        self.common
            .check_outputs(self.report.iter().chain(&self.trace))?;
        let is_first = measured.rounds.is_empty();
        if self.common.device.validate && is_first {
            console::message("the validation layers are on: these times are not worth comparing");
        }
        if let Some(kernel) = &self.kernel {
            check_kernel(kernel, session.kernels())?;
        }

        let warm = repeat(self.warmup, || session.step())?;
        if warm {
            session.measure_bandwidth()?;
        }
        let begin = |session: &mut Session, measured: &mut Measured| {
            session.keep_busy()?;
            measured.watch.begin();
            session.begin_measuring(self.steps as usize, self.trace.is_some())
        };
        let (ending, completed) = match &self.kernel {
            None => {
                begin(&mut session, measured)?;
                let completed = warm && repeat(self.steps, || session.step())?;
                (session.finish()?, completed)
            }
            Some(kernel) => {
                let ending = session.finish()?;
                let alone = session.run_before(kernel)?;
                // A run before the measured ones compiles the kernel.
                session.run_alone(&alone)?;
                begin(&mut session, measured)?;
                let mut run = || {
                    session.run_alone(&alone)?;
                    session.progress.step();
                    Ok(())
                };
                let completed = warm && repeat(self.steps, &mut run)?;
                session.frames.wait_idle()?;
                (ending, completed)
            }
        };
        measured.watch.end();
        let times = session.frames.timings().report("step");
        if !times.is_empty() || is_first {
            measured.rounds.push(Repetition::from(&times));
        }
        Ok((session, ending, completed))
    }

    /// The results of a repetition together with all before. Its session ends here, as the device may have no room for another one beside
    /// it.
    fn results(
        &self,
        mut session: Session,
        mut ending: Ending,
        measured: &mut Measured,
    ) -> Result<Results> {
        let (trace, agreement) = session.trace()?;
        session.check_messages()?;
        session.progress.finish();
        let steps_before = ending.steps;
        session.add_earlier(&mut measured.earlier, &mut ending);
        let mut report = session.report(&ending, false);
        report.warmup = Some(self.warmup.into());
        if measured.rounds.len() > 1 {
            report.add_repetitions(measured.rounds.clone());
        }
        if self.kernel.is_some() {
            report.alone.clone_from(&self.kernel);
            report.gpu_ms_per_step = None;
            report.gpu_step = Times::default();
            report.gpu_ms_between_kernels = None;
            report.host_step = None;
            report.wall_ms_per_step = None;
            report.steps = steps_before;
        }
        if self.overlap {
            report.kernels.clear();
            report.gpu_ms_between_kernels = None;
        }
        let run = match &self.kernel {
            Some(_) => Run::Kernel,
            None if self.overlap => Run::Overlapping,
            None => Run::Step,
        };
        Ok(Results {
            report,
            table: session.table(run),
            trace,
            agreement,
            lacks_checkpoint: ending.lacks_checkpoint,
        })
    }

    /// Prints and writes the results.
    fn output(
        &self,
        results: Results,
        watch: &Watch,
        interrupted: bool,
        [report_sink, trace_sink]: [Option<Sink>; 2],
    ) -> Result<Outcome> {
        let mut report = results.report;
        let load = watch.load();
        report.host_load = Some(load);
        report.interrupted = interrupted;
        if let Some(warning) = load.warning() {
            console::message(&warning);
        }
        let printed = if self.json {
            console::print(report.to_json())
        } else {
            console::message(&format!(
                "{}: {} ({})",
                escaped(&report.scene),
                report.device,
                report.driver
            ));
            console::print(results.table + &host_time(&report) + &repetitions(&report))
        };
        // If one of the three fails, the others are still written.
        let reported = report_sink.map(|sink| sink.write(report.to_json()));
        if let (Some(sink), Some(path)) = (trace_sink, &self.trace) {
            unless_closed(sink.write(results.trace))?;
            console::message(&format!("{}: {}", path.shown(), results.agreement));
        }
        unless_closed(reported.unwrap_or(Ok(())))?;
        unless_closed(printed)?;
        Ok(if results.lacks_checkpoint {
            Outcome::Failed
        } else if interrupted {
            Outcome::Interrupted
        } else {
            Outcome::Done
        })
    }
}

/// What is printed and written.
struct Results {
    report: Report,
    table: String,
    /// The trace as JSON, and how well its tracks agree.
    trace: Vec<u8>,
    agreement: String,
    lacks_checkpoint: bool,
}

/// The results of the repetitions so far.
struct Measured {
    watch: Watch,
    rounds: Vec<Repetition>,
    /// The times of all repetitions that have ended.
    earlier: Earlier,
}

impl Measured {
    fn new() -> Self {
        Self {
            watch: Watch::new(),
            rounds: Vec::new(),
            earlier: Earlier::default(),
        }
    }
}

/// A line with the host's time for a step.
fn host_time(report: &Report) -> String {
    let host = report.host_step.unwrap_or_default();
    let [Some(all), Some(recording), Some(submitting), Some(most)] = [
        host.all.median_ms,
        host.recording.median_ms,
        host.submitting.median_ms,
        host.all.max_ms,
    ] else {
        return String::new();
    };
    format!(
        "The host takes {all:.3} ms, {recording:.3} of it to record and {submitting:.3} to submit (medians), {most:.3} ms at the \
         most.\n"
    )
}

/// A line with the median of each repetition, if there are several.
fn repetitions(report: &Report) -> String {
    if report.repetitions.is_empty() {
        return String::new();
    }
    let of = |repetition: &Repetition| match &report.alone {
        None => repetition.step_ms,
        Some(kernel) => repetition.kernels_ms.get(kernel).copied().unwrap_or(0.0),
    };
    let medians = report.repetitions.iter().map(of);
    let medians: Vec<String> = medians.map(|ms| format!("{ms:.3}")).collect();
    format!(
        "{} repetitions, each from the beginning: medians {} ms.\n",
        medians.len(),
        medians.join(", ")
    )
}

/// The ratios of times, and what makes them doubtful.
fn comparison(a: &Report, b: &Report) -> Result<String> {
    let of = |report: &Report| {
        let alone = report.alone.as_ref();
        alone.map_or("whole steps".to_owned(), |kernel| {
            format!("`{kernel}` alone")
        })
    };
    if a.alone != b.alone {
        return Err(Error::Invalid(format!(
            "the first report is of {}, the second of {}: measure both in the same way",
            of(a),
            of(b)
        )));
    }
    for (which, report) in [("first", a), ("second", b)] {
        if !report.has_kernel_times() {
            return Err(Error::Invalid(format!(
                "the {which} report has no times of kernels, which are what is compared: measure it on a device \
                 with timestamps, for at least a step"
            )));
        }
    }
    let mut text = ratios::differences_text(a, b) + &ratios::doubts_text(a, b);
    if !text.is_empty() {
        text.push('\n');
    }
    Ok(text + &ratios::table(a, b))
}

/// Repeats `work`, unless Ctrl-C asks to stop; returns whether it was done so often.
fn repeat(times: u32, mut work: impl FnMut() -> Result<()>) -> Result<bool> {
    for _ in 0..times {
        if interrupt::requested() {
            return Ok(false);
        }
        work()?;
    }
    Ok(!interrupt::requested())
}

/// Makes sure that a kernel is one of the scene's step.
fn check_kernel(name: &str, kernels: &[(String, u32)]) -> Result<()> {
    let names: Vec<&str> = kernels.iter().map(|(name, _)| name.as_str()).collect();
    if names.contains(&name) {
        return Ok(());
    }
    let meant = nearest(name, names.iter().copied())
        .map_or(String::new(), |near| format!(", did you mean `{near}`?"));
    Err(Error::Invalid(format!(
        "a step of this scene has no kernel `{name}`{meant}: it has {}",
        names.join(", ")
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_kernels_are_answered_with_the_nearest_and_all() {
        let kernels = ["advance", "diffuse", "exchange_seams"].map(|name| (name.to_owned(), 1));
        assert!(check_kernel("advance", &kernels).is_ok());
        let error = check_kernel("difuse", &kernels).unwrap_err().to_string();
        assert_eq!(
            error,
            "a step of this scene has no kernel `difuse`, did you mean `diffuse`?: it has advance, diffuse, exchange_seams"
        );
    }
}
