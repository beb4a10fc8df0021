//! `myxo profile`: the GPU time of every kernel.

use std::path::PathBuf;

use clap::Args;
use myxo::scene::suggest::nearest;
use myxo::sim::step::KERNELS;
use myxo::{Error, Result};

use super::files::{Sink, check_distinct};
use super::options::CommonOptions;
use super::session::{Ending, Session};
use super::times::Run;
use super::{Outcome, console, interrupt};

/// Measure the GPU time of every kernel
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Examples:
  myxo profile torus                            a table
  myxo profile torus --steps 500 --json > torus.json
  myxo profile cube --kernel advance            one kernel alone
  myxo profile cube --trace cube.trace.json     for ui.perfetto.dev")]
pub struct Profile {
    /// A built-in name, a .toml file or a model
    scene: PathBuf,
    /// How many steps to measure
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..))]
    steps: u32,
    /// Steps before that, which are not measured: the first ones compile kernels, and trails have yet to form
    #[arg(long, value_name = "N", default_value_t = 50)]
    warmup: u32,
    /// Measures this kernel alone: after the warm-up it runs --steps times on what it finds in the next step, with no
    /// other kernel between. The state hash and --checkpoint are those of the warm-up's end
    #[arg(long, value_name = "NAME")]
    kernel: Option<String>,
    /// Prints the report as JSON instead of the table
    #[arg(long)]
    json: bool,
    /// Writes the report as JSON
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Writes a trace for chrome://tracing or ui.perfetto.dev: what the host and the GPU do when, on one clock
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
    #[command(flatten)]
    common: CommonOptions,
}

impl Profile {
    /// Checks everything that can be checked before the work, and does it.
    pub fn run(&self) -> Result<Outcome> {
        let kernel = self.kernel.as_deref().map(kernel_called).transpose()?;
        let files = self.report.iter().chain(&self.trace);
        check_distinct(files.chain(&self.common.state.checkpoint))?;
        let scene = self.common.load(&self.scene)?;
        let report_sink = self.report.as_deref().map(Sink::create).transpose()?;
        let trace_sink = self.trace.as_deref().map(Sink::create).transpose()?;
        interrupt::install()?;
        let steps = u64::from(self.warmup) + u64::from(self.steps);
        let mut session = Session::open(scene, &self.common, steps)?;
        if self.common.device.validate {
            console::message("the validation layers are on: these times are not worth comparing");
        }

        let has_turns = session.simulation.settings().strategy().has_turns();
        if has_turns && kernel.is_some_and(|kernel| KERNELS[kernel].0 == "advance") {
            return Err(Error::Invalid(
                "`advance` cannot be measured alone where objects have turns, because each particle advances once a step: \
                 add --set transfer.strategy=direct"
                    .to_owned(),
            ));
        }

        let warm = repeat(self.warmup, || session.step())?;
        let measured = |session: &mut Session| {
            session.begin_measuring(self.steps as usize, self.trace.is_some())
        };
        let (ending, completed) = match kernel {
            None => {
                measured(&mut session)?;
                let completed = warm && repeat(self.steps, || session.step())?;
                (session.finish()?, completed)
            }
            Some(kernel) => {
                let ending = session.finish()?;
                // Once before, to compile it and to bring about what it finds.
                session.run_alone(kernel, true)?;
                measured(&mut session)?;
                let mut run = || {
                    session.run_alone(kernel, false)?;
                    session.progress.step();
                    Ok(())
                };
                (ending, warm && repeat(self.steps, &mut run)?)
            }
        };
        self.tell(session, &ending, !completed, report_sink, trace_sink)
    }

    /// Shows and writes what was measured.
    fn tell(
        &self,
        mut session: Session,
        ending: &Ending,
        interrupted: bool,
        report_sink: Option<Sink>,
        trace_sink: Option<Sink>,
    ) -> Result<Outcome> {
        let (trace, agreement) = session.trace()?;
        session.check_messages()?;
        session.progress.finish();
        let mut report = session.report(ending, interrupted);
        if self.kernel.is_some() {
            report.alone.clone_from(&self.kernel);
            report.gpu_ms_per_step = None;
        }
        if self.json {
            console::print(report.to_json())?;
        } else {
            console::message(&format!(
                "{}: {} ({})",
                report.scene, report.device, report.driver
            ));
            let run = self.kernel.as_ref().map_or(Run::Step, |_| Run::Kernel);
            console::print(session.table(run))?;
        }
        if let Some(sink) = report_sink {
            sink.write(report.to_json())?;
        }
        if let (Some(sink), Some(path)) = (trace_sink, &self.trace) {
            sink.write(trace)?;
            console::message(&format!("{}: {agreement}", path.display()));
        }
        Ok(if interrupted {
            Outcome::Interrupted
        } else {
            Outcome::Done
        })
    }
}

/// Does it so many times, unless somebody asks to stop; says whether it was done so often.
fn repeat(times: u32, mut work: impl FnMut() -> Result<()>) -> Result<bool> {
    for _ in 0..times {
        if interrupt::requested() {
            return Ok(false);
        }
        work()?;
    }
    Ok(!interrupt::requested())
}

/// The number of a kernel in a step.
fn kernel_called(name: &str) -> Result<usize> {
    let names = KERNELS.map(|(name, _)| name);
    names
        .iter()
        .position(|known| *known == name)
        .ok_or_else(|| {
            let meant = nearest(name, names.into_iter())
                .map_or(String::new(), |near| format!(", did you mean `{near}`?"));
            Error::Invalid(format!(
                "there is no kernel `{name}`{meant}: those of a step are {}",
                names.join(", ")
            ))
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_kernels_are_answered_with_the_nearest_and_all() {
        assert_eq!(kernel_called("advance").ok(), Some(1));
        let error = kernel_called("difuse").unwrap_err().to_string();
        assert_eq!(
            error,
            "there is no kernel `difuse`, did you mean `diffuse`?: those of a step are distance, advance, diffuse, diffuse_seams, exchange_seams"
        );
    }
}
