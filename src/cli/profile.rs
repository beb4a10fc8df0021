//! `myxo profile`: the GPU time of every kernel.

use std::path::PathBuf;

use clap::Args;
use myxo::scene::suggest::nearest;
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
  myxo profile trio --kernel transfer_out       any that a step of the scene has
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
    /// Measures this kernel alone: after the warm-up it runs --steps times on what it finds when it comes for the first
    /// time in the next step (with turns: in the first object's), with no other kernel between; what it changes is
    /// brought back before each run, which is not measured. Every kernel of the scene's step can be named, those that
    /// take distances among them. The state hash and --checkpoint are those of the warm-up's end
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

        if let Some(kernel) = &self.kernel {
            check_kernel(kernel, session.kernels())?;
        }

        let warm = repeat(self.warmup, || session.step())?;
        let measured = |session: &mut Session| {
            session.begin_measuring(self.steps as usize, self.trace.is_some())
        };
        let (ending, completed) = match &self.kernel {
            None => {
                measured(&mut session)?;
                let completed = warm && repeat(self.steps, || session.step())?;
                (session.finish()?, completed)
            }
            Some(kernel) => {
                let ending = session.finish()?;
                let alone = session.run_before(kernel)?;
                // Once before, to compile it.
                session.run_alone(&alone)?;
                measured(&mut session)?;
                let mut run = || {
                    session.run_alone(&alone)?;
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
