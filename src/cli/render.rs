//! `myxo render`: pictures, sequences and films without a window.

use std::path::PathBuf;

use clap::Args;
use image::RgbaImage;
use myxo::Result;
use myxo::render::offscreen::{self, Offscreen};
use myxo::render::output::Output;
use myxo::render::renderer::Renderer;
use myxo::render::view::View;

use super::files::{Sink, check_distinct};
use super::options::{CommonOptions, Size};
use super::session::{Session, progress};
use super::{Outcome, console, interrupt};

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
        check_distinct(
            self.out
                .iter()
                .chain(&self.report)
                .chain(&self.common.state.checkpoint),
        )?;
        let scene = self.common.load(&self.scene)?;
        let report_sink = self.report.as_deref().map(Sink::create).transpose()?;
        let size = [self.size.width, self.size.height];
        let mut outputs = self
            .out
            .iter()
            .map(|path| Output::create(path, size.into(), f64::from(self.fps)))
            .collect::<Result<Vec<_>, _>>()?;
        interrupt::install()?;

        let mut session = Session::open(scene, &self.common)?;
        let mut camera = Photographer::new(&session, size)?;
        let bar = progress(u64::from(self.steps), &session.scene.name);
        let mut interrupted = false;
        for step in 1..=self.steps {
            session.step()?;
            bar.inc(1);
            interrupted = interrupt::requested();
            if interrupted {
                break;
            }
            if step.is_multiple_of(self.every) && outputs.iter().any(Output::wants_every_frame) {
                let picture = camera.take(&mut session)?;
                for output in outputs
                    .iter_mut()
                    .filter(|output| output.wants_every_frame())
                {
                    output.frame(&picture)?;
                }
            }
        }
        let picture = camera.take(&mut session)?;
        bar.finish_and_clear();
        let shown_already = |output: &Output| {
            output.wants_every_frame()
                && !interrupted
                && self.steps.is_multiple_of(self.every)
                && output.frames() > 0
        };
        for output in &mut outputs {
            if !shown_already(output) {
                output.frame(&picture)?;
            }
        }
        let written = outputs
            .into_iter()
            .map(Output::finish)
            .collect::<Result<Vec<_>, _>>()?;
        let ending = session.finish()?;

        console::message(session.table().trim_end());
        let report = session.report(&ending, interrupted);
        console::message(&format!(
            "{} after {} steps: state hash {}",
            session.scene.name, ending.snapshot.step, report.state_hash
        ));
        for written in written {
            console::message(&written.to_string());
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

/// Takes pictures of a session.
struct Photographer {
    renderer: Renderer,
    offscreen: Offscreen,
    view: View,
}

impl Photographer {
    fn new(session: &Session, size: [u32; 2]) -> Result<Self> {
        Ok(Self {
            renderer: Renderer::new(&session.ctx, session.simulation.setup(), offscreen::FORMAT)?,
            offscreen: Offscreen::new(&session.ctx, size)?,
            view: View::of(&session.scene, glam::UVec2::from_array(size).as_vec2()),
        })
    }

    /// A picture of the state after the last step.
    fn take(&mut self, session: &mut Session) -> Result<RgbaImage> {
        let mut rec = session.frames.begin()?;
        self.renderer.draw(
            &mut rec,
            session.simulation.state(),
            &self.view,
            self.offscreen.canvas(),
        );
        self.offscreen.record_readback(&mut rec);
        session.frames.submit(rec)?;
        session.frames.wait_idle()?;
        Ok(self.offscreen.image())
    }
}
