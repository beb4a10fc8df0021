//! `myxo render`: pictures, sequences and films without a window.

use std::path::{Path, PathBuf};

use clap::Args;
use myxo::{Error, Result};

use super::options::{CommonOptions, Size, check_distinct};
use super::{Outcome, files, not_built_in};

/// Run a scene without a window and write pictures
///
/// The name of each --out says what it becomes: `x.png` is the last picture, `x_%05d.png` a sequence of them, `x.mp4`
/// and `x.gif` films. Pictures of a sequence or film are --every steps apart.
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
    /// What to write: .png, a sequence with %05d in its name, .mp4 or .gif. May be repeated
    #[arg(long, value_name = "FILE", required = true)]
    out: Vec<PathBuf>,
    /// Writes the report of the run as JSON
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
        for out in &self.out {
            check_kind(out)?;
        }
        check_distinct(self.out.iter().chain(&self.report).map(PathBuf::as_path))?;
        let _scene = self.common.load(&self.scene)?;
        for path in self.out.iter().chain(&self.report) {
            files::check_writable(path)?;
        }
        let _ = (self.steps, self.size, self.every, self.fps);
        Err(not_built_in("the simulation"))
    }
}

/// Refuses names that say no kind of picture.
fn check_kind(out: &Path) -> Result<()> {
    let ending = out.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    match ending.as_str() {
        "png" | "mp4" | "gif" => Ok(()),
        _ => Err(Error::Invalid(format!(
            "cannot tell from its name what {} is to be: end it with .png, .mp4 or .gif, or put %05d before .png for a sequence",
            out.display()
        ))),
    }
}
