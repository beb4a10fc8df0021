//! `myxo render`: pictures, sequences and films without a window.

use std::path::PathBuf;

use clap::Args;
use myxo::Result;
use myxo::render::output::Output;

use super::files::{Sink, check_distinct};
use super::options::{CommonOptions, Size};
use super::{Outcome, not_built_in};

/// Run a scene without a window and write pictures
///
/// The name of each --out says what it becomes: x.png is the last picture, x_%05d.png or a folder a sequence of them,
/// x.mp4 and x.gif films. Pictures of a sequence or film are --every steps apart.
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Examples:
  myxo render torus --steps 400 --out torus.png --report torus.json
  myxo render cube --steps 1200 --every 4 --out cube.mp4 --out cube.png
  myxo render fish.glb --steps 600 --out 'frames/fish_%05d.png' --size 1920x1080
  myxo render torus --preset cells --set picture.color_map=viridis --out cells.png")]
pub struct Render {
    /// A built-in name, a .toml file or a model
    scene: PathBuf,
    /// How many steps to run
    #[arg(long, value_name = "N", default_value_t = 400)]
    steps: u32,
    /// What to write: .png, .png with %05d in its name, a folder, .mp4 or .gif. May be repeated
    #[arg(long, value_name = "FILE", required = true)]
    out: Vec<PathBuf>,
    /// Writes the report of the run as JSON; - for the standard output
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Size of the picture, in pixels
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "1280x720")]
    size: Size,
    /// Steps from one picture of a sequence or film to the next
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..))]
    every: u32,
    /// Pictures a second in a film
    #[arg(long, value_name = "N", default_value_t = 30, value_parser = clap::value_parser!(u32).range(1..=240))]
    fps: u32,
    #[command(flatten)]
    common: CommonOptions,
}

impl Render {
    /// Checks everything that can be checked before the work, and does it.
    pub fn run(&self) -> Result<Outcome> {
        check_distinct(self.out.iter().chain(&self.report))?;
        let _scene = self.common.load(&self.scene)?;
        let size = (self.size.width, self.size.height);
        let _outputs = self
            .out
            .iter()
            .map(|out| Output::create(out, size, f64::from(self.fps)));
        let _outputs = _outputs.collect::<Result<Vec<_>, _>>()?;
        let _report = self.report.as_deref().map(Sink::create).transpose()?;
        let _ = (self.steps, self.every);
        Err(not_built_in("the simulation"))
    }
}
