//! `myxo render`: pictures, sequences and films without a window.

use std::path::PathBuf;

use clap::Args;
use image::RgbaImage;
use myxo::gpu::GpuError;
use myxo::render::exposure::Exposure;
use myxo::render::offscreen::{self, Offscreen};
use myxo::render::renderer::Renderer;
use myxo::render::view::View;
use myxo::sim::memory;
use myxo::{Error, Result};

use super::files::{Sink, check_distinct};
use super::options::{CommonOptions, Size};
use super::outputs::Outputs;
use super::session::Session;
use super::times::Run;
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
        let mut outputs = Outputs::create(&self.out, size, self.fps)?;
        interrupt::install()?;

        let mut session = Session::open(scene, &self.common, u64::from(self.steps))?;
        let ran = self.film(&mut session, &mut outputs, size);
        // Whatever happened: what there is of films becomes whole files.
        outputs.finish();
        session.progress.finish();
        let completed = ran?;
        let ending = session.finish()?;

        console::message(&session.table(Run::Step));
        let interrupted = !completed && interrupt::requested();
        let report = session.report(&ending, interrupted);
        console::message(&format!(
            "{} at step {}: state hash {}",
            session.scene.name, ending.snapshot.step, report.state_hash
        ));
        outputs.tell();
        if let Some(sink) = report_sink {
            sink.write(report.to_json())?;
        }
        Ok(if outputs.failed() {
            Outcome::Failed
        } else if interrupted {
            Outcome::Interrupted
        } else {
            Outcome::Done
        })
    }

    /// Runs the steps and takes the pictures; says whether all steps were run.
    fn film(&self, session: &mut Session, outputs: &mut Outputs, size: [u32; 2]) -> Result<bool> {
        let mut camera = Photographer::new(session, size, outputs.want_every_frame())?;
        let mut filmed = None;
        let mut done = 0;
        while done < self.steps && !interrupt::requested() {
            session.step()?;
            done += 1;
            if done == 1 && self.steps > 1 {
                // The first step compiles kernels, which is no part of what a step takes.
                session.forget_times()?;
            }
            if done.is_multiple_of(self.every) && outputs.want_every_frame() {
                let picture = camera.take(session)?;
                outputs.frame(&picture, &session.progress);
                filmed = Some(done);
            }
            if !outputs.any_left() && self.common.state.checkpoint.is_none() {
                break;
            }
        }
        let picture = camera.take(session)?;
        outputs.last_frame(&picture, filmed == Some(done), &session.progress);
        Ok(done == self.steps)
    }
}

/// In a film the exposure follows the mean of the pictures so far, and later ones at least so quickly.
const SLOWEST_ADAPTATION: f32 = 0.12;

/// Takes pictures of a session.
struct Photographer {
    renderer: Renderer,
    offscreen: Offscreen,
    view: View,
    /// Pictures in a row: the exposure follows the trail slowly, so that films do not flicker.
    film: bool,
    taken: f32,
}

impl Photographer {
    fn new(session: &Session, size: [u32; 2], film: bool) -> Result<Self> {
        Ok(Self {
            renderer: Renderer::new(&session.ctx, session.simulation.setup(), offscreen::FORMAT)?,
            offscreen: Offscreen::new(&session.ctx, size)
                .map_err(|error| too_large(size, error))?,
            view: View::of(&session.scene, glam::UVec2::from_array(size).as_vec2()),
            film,
            taken: 0.0,
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
        self.taken += 1.0;
        if let (true, Exposure::Auto { adaptation, .. }) = (self.film, &mut self.view.exposure) {
            *adaptation = (1.0 / (self.taken + 1.0)).max(SLOWEST_ADAPTATION);
        }
        Ok(self.offscreen.image())
    }
}

/// Says what to do about a picture that the device cannot hold.
fn too_large([width, height]: [u32; 2], error: GpuError) -> Error {
    match error {
        GpuError::OutOfMemory { object, size, .. } => Error::Invalid(format!(
            "the device has no room for a picture of {width} x {height} ({object} alone takes {}): use a smaller --size",
            memory::human(size)
        )),
        error @ GpuError::TooLarge { .. } => Error::Invalid(format!(
            "a picture of {width} x {height} is too large: {error}: use a smaller --size"
        )),
        error => Error::Gpu(error),
    }
}
