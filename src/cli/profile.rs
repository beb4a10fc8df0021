//! `myxo profile`: the GPU time of every kernel.

use std::path::PathBuf;

use clap::Args;
use myxo::Result;

use super::files::{Sink, check_distinct};
use super::options::CommonOptions;
use super::session::{Session, progress};
use super::{Outcome, console, interrupt};

/// Measure the GPU time of every kernel
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Examples:
  myxo profile torus                            a table
  myxo profile torus --steps 500 --json > torus.json
  myxo profile cube --kernel advance
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
    /// Only this kernel
    #[arg(long, value_name = "NAME")]
    kernel: Option<String>,
    /// Prints the report as JSON instead of the table
    #[arg(long)]
    json: bool,
    /// Writes the report as JSON
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Writes a Chrome/Perfetto trace with host and GPU on one clock
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
    #[command(flatten)]
    common: CommonOptions,
}

impl Profile {
    /// Checks everything that can be checked before the work, and does it.
    pub fn run(&self) -> Result<Outcome> {
        check_distinct(self.report.iter().chain(&self.trace))?;
        let scene = self.common.load(&self.scene)?;
        let report_sink = self.report.as_deref().map(Sink::create).transpose()?;
        interrupt::install()?;
        let mut session = Session::open(scene, &self.common)?;
        if self.common.device.validate {
            console::message("the validation layers are on: these times are not worth comparing");
        }
        let bar = progress(
            u64::from(self.warmup) + u64::from(self.steps),
            &session.scene.name,
        );
        let mut interrupted = false;
        for (steps, measured) in [(self.warmup, false), (self.steps, true)] {
            for _ in 0..steps {
                if interrupt::requested() {
                    interrupted = true;
                    break;
                }
                session.step()?;
                bar.inc(1);
            }
            if !measured {
                session.begin_measuring(self.steps as usize)?;
            }
        }
        bar.finish_and_clear();
        let ending = session.finish()?;
        let report = session.report(&ending, interrupted);
        if self.json {
            console::print(&report.to_json())?;
        } else {
            console::message(&format!(
                "{}: {} ({})",
                report.scene, report.device, report.driver
            ));
            console::print(&session.table())?;
        }
        if let Some(sink) = report_sink {
            sink.write(&report.to_json())?;
        }
        Ok(if interrupted {
            Outcome::Interrupted
        } else {
            Outcome::Done
        })
    }
}
