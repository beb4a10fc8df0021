//! `myxo render`: pictures, sequences and films without a window.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use image::RgbaImage;
use myxo::plain_text::{Shown as _, escaped};
use myxo::render::exposure::Exposure;
use myxo::render::lens;
use myxo::render::mean::Mean;
use myxo::render::offscreen::{self, Offscreen, too_large};
use myxo::render::pick;
use myxo::render::view::{self, View};
use myxo::render::{draw_network, renderer::Renderer};
use myxo::scene::Scene;
use myxo::scene::settings::Show;
use myxo::sim::graph::network_of;
use myxo::sweep::{Unseen, unseen};
use myxo::{Error, Result};

use super::files::{Sink, check_distinct};
use super::options::{CommonOptions, Size};
use super::outputs::Outputs;
use super::session::Session;
use super::times::Run;
use super::{Command, Outcome, interrupt};
use crate::console;

/// The most turns of the camera.
const MOST_TURNS: f32 = 1000.0;

/// Run a scene without a window and write pictures
///
/// The name of each --out says what it becomes: x.png is the last picture, x_%05d.png or a folder a sequence of them,
/// x.mp4 and x.gif films. Pictures of a sequence or film are --every steps apart.
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Examples:
  myxo render torus --steps 400 --out torus.png --report torus.json
  myxo render cube --steps 1200 --every 4 --out cube.mp4 --out cube.png
  myxo render trio --steps 900 --from 300 --out trio.gif
  myxo render suzanne --steps 900 --from 300 --turns 1 --out suzanne.mp4
  myxo render torus --size 3840x2160 --transparent --out torus_4k.png
  myxo render crowd --steps 600 --aperture 0.15 --out crowd.png
  myxo render fish.glb --steps 600 --out 'frames/fish_%05d.png' --size 1920x1080
  myxo render trio --steps 900 --view relief --split --out relief.png
  myxo render torus --preset cells --set picture.color_map=viridis --out cells.png
  myxo render --resume torus.ckpt --steps 400 --out later.png")]
pub struct Render {
    /// A built-in name, a .toml file, a model, or a built-in mesh such as builtin:torus?tube=0.2; with --resume it may be left out
    #[arg(required_unless_present = "resume")]
    scene: Option<PathBuf>,
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
    /// Leaves out the background: pictures get an alpha channel. PNG only
    #[arg(long)]
    transparent: bool,
    /// What the picture shows; in place of the scene's `picture.show`
    #[arg(long, value_name = "NAME", value_parser = views())]
    view: Option<Show>,
    /// The unwrapped texture in the right half of the picture
    #[arg(long)]
    split: bool,
    /// Draws the network's graph over each picture: its edges as lines, its nodes as dots
    #[arg(long, conflicts_with = "transparent")]
    network: bool,
    /// Steps from one picture of a sequence or film to the next
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..))]
    every: u32,
    /// Begins sequences and films after so many steps, when the network has grown
    #[arg(long, value_name = "N", default_value_t = 0)]
    from: u32,
    /// Lets the camera go round the scene so many times in a sequence or film; below 0 the other way round
    #[arg(long, value_name = "N", default_value_t = 0.0, value_parser = turns, allow_negative_numbers = true)]
    turns: f32,
    /// Diameter of the camera's lens, in scene radii: what is nearer or farther than the middle of the picture is out of focus. Each
    /// picture is the mean of 32 pictures from places all over the lens, or of as many as --passes says
    #[arg(long, value_name = "X", default_value_t = 0.0, value_parser = aperture)]
    aperture: f32,
    /// Draws each picture so many times, each time a part of a pixel beside the last, and takes the mean: fine lines become smooth. The
    /// window's picture at rest has 8
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    passes: Option<u32>,
    /// Pictures a second in a film
    #[arg(long, value_name = "N", default_value_t = 30, value_parser = clap::value_parser!(u32).range(1..=240))]
    fps: u32,
    #[command(flatten)]
    common: CommonOptions,
}

impl Command for Render {
    /// Checks everything that can be checked beforehand, then runs and writes.
    fn run(&self) -> Result<Outcome> {
        check_distinct(
            self.out
                .iter()
                .chain(&self.report)
                .chain(&self.common.state.checkpoint),
        )?;
        let mut scene = self.common.load(self.scene.as_deref())?;
        if let Some(view) = self.view {
            scene.settings.picture.show = view;
        }
        self.check_view(&scene)?;
        if self.from > 0 && self.from >= self.steps {
            return Err(Error::Invalid(format!(
                "--from {} leaves out all of the {} steps: use fewer, or more --steps",
                self.from, self.steps
            )));
        }
        // Installed before files are begun: without the handler, Ctrl-C would leave unfinished files behind.
        interrupt::install()?;
        let report_sink = self.report.as_deref().map(Sink::create).transpose()?;
        let size = [self.size.width, self.size.height];
        let mut outputs = Outputs::create(&self.out, size, self.fps)?;
        if let (true, Some(opaque)) = (self.transparent, outputs.opaque()) {
            return Err(Error::Invalid(format!(
                "{} cannot be transparent: with --transparent, write NAME.png, NAME_%05d.png or a folder",
                opaque.shown()
            )));
        }
        let films = [("--from", self.from > 0), ("--turns", self.turns != 0.0)];
        if let Some((option, _)) = films.iter().find(|(_, is_asked_for)| *is_asked_for)
            && !outputs.want_every_frame()
        {
            return Err(Error::Invalid(format!(
                "{option} is for sequences and films, and no --out is one: omit it, or write NAME.gif, NAME.mp4 or a folder"
            )));
        }

        let frames = outputs.existing(self.pictures());
        let written = || self.out.iter().chain(&self.report).chain(&frames);
        self.common.check_outputs(written())?;
        let mut session = Session::open(scene, &self.common, u64::from(self.steps))?;
        // Checked again: masks and maps are inputs, too, and have been read by now.
        self.common.check_outputs(written())?;
        let ran = self.film(&mut session, &mut outputs, size);
        // Even after an error, films are finished with the frames so far.
        outputs.finish();
        session.progress.finish();
        let completed = ran?;
        let ending = session.finish()?;

        console::message(&session.table(Run::Step));
        let interrupted = !completed && interrupt::requested();
        let report = session.report(&ending, interrupted);
        console::message(&format!(
            "{} at step {}: state hash {}",
            escaped(&session.scene.name),
            ending.snapshot.step,
            report.state_hash
        ));
        outputs.print_written();
        if let Some(sink) = report_sink {
            sink.write(report.to_json())?;
        }
        Ok(if outputs.failed() || ending.lacks_checkpoint {
            Outcome::Failed
        } else if interrupted {
            Outcome::Interrupted
        } else {
            Outcome::Done
        })
    }
}

impl Render {
    /// The number of pictures in a sequence or film.
    fn pictures(&self) -> u32 {
        let pictures = (self.steps - self.from).div_ceil(self.every);
        pictures.max(1)
    }

    /// Can the scene be shown in this view?
    fn check_view(&self, scene: &Scene) -> Result<()> {
        let show = scene.settings.picture.show;
        let word = show.word();
        match unseen(scene, u64::from(self.steps)) {
            Some(Unseen::Lacks(why)) => {
                return Err(Error::Invalid(format!(
                    "the view {word} cannot be shown: {why}: choose another --view"
                )));
            }
            Some(Unseen::BeforeSteps) => {
                return Err(Error::Invalid(format!(
                    "the view {word} cannot be shown: distances are taken by a step: use --steps 1 or more"
                )));
            }
            None => {}
        }
        if self.turns != 0.0 && show.is_flat() {
            return Err(Error::Invalid(format!(
                "--turns cannot turn the view {word}, which is flat: omit it, or choose another --view"
            )));
        }
        if self.aperture > 0.0 && show.is_flat() {
            return Err(Error::Invalid(format!(
                "--aperture has no effect on the view {word}, which is flat: omit it, or choose another --view"
            )));
        }
        if self.network && show.is_flat() {
            return Err(Error::Invalid(format!(
                "--network has no effect on the view {word}, which is flat: omit it, or choose another --view"
            )));
        }
        if self.passes.is_some() && show.is_flat() {
            return Err(Error::Invalid(format!(
                "--passes has no effect on the view {word}, which is flat: omit it, or choose another --view"
            )));
        }
        if self.split && (show.is_flat() || self.size.width < 2) {
            return Err(Error::Invalid(format!(
                "--split cannot show the view {word} beside the texture: choose another --view, and a --size 2 pixels wide at least"
            )));
        }
        Ok(())
    }

    /// Runs the steps and takes the pictures; returns whether all steps were run.
    fn film(&self, session: &mut Session, outputs: &mut Outputs, size: [u32; 2]) -> Result<bool> {
        let mut camera = Photographer::new(session, size, outputs.want_every_frame(), self.split)?;
        if let Some(warning) = camera.offscreen.canvas().warning() {
            console::message(&warning);
        }
        camera.view.is_transparent = self.transparent;
        camera.network = self.network;
        if self.turns != 0.0 && session.scene.settings.camera.distance <= 0.0 {
            camera.stand_back(&session.scene);
        }
        // The picture after the last would equal the first, so that films of whole turns can be looped.
        camera.pictures = self.pictures();
        camera.turns = self.turns;
        camera.lens = self.aperture * session.scene.radius;
        let usual = if self.aperture > 0.0 { lens::PLACES } else { 1 };
        camera.average(session, size, self.passes.unwrap_or(usual))?;
        let mut filmed = None;
        let mut done = 0;
        while done < self.steps && !interrupt::requested() {
            session.step()?;
            done += 1;
            session.forget_first(self.steps)?;
            let is_filmed = done > self.from && (done - self.from).is_multiple_of(self.every);
            if is_filmed && outputs.want_every_frame() {
                let picture = camera.take(session)?;
                outputs.frame(&picture, &session.progress);
                filmed = Some(done);
            }
            if !outputs.any_left() && self.common.state.checkpoint.is_none() {
                break;
            }
        }
        let picture = camera.take(session)?;
        let flaws = session.ctx.download(camera.renderer.flaws())?[0];
        if flaws > 0 {
            console::message(&format!(
                "{flaws} pixels are black, because their light was not a number: the trail has values that are none, or without end"
            ));
        }
        outputs.last_frame(&picture, filmed == Some(done), &session.progress);
        Ok(done == self.steps)
    }
}

/// Reads the diameter of a lens.
fn aperture(text: &str) -> Result<f32, String> {
    let aperture: f32 = text.parse().map_err(|_| "it is no number".to_owned())?;
    if (0.0..=lens::WIDEST).contains(&aperture) {
        Ok(aperture)
    } else {
        Err(format!("it must be from 0 to {}", lens::WIDEST))
    }
}

/// Reads a number of turns.
fn turns(text: &str) -> Result<f32, String> {
    let turns: f32 = text.parse().map_err(|_| "it is no number".to_owned())?;
    if turns.abs() <= MOST_TURNS {
        Ok(turns)
    } else {
        Err(format!("it must be from -{MOST_TURNS} to {MOST_TURNS}"))
    }
}

/// The views, each with its help.
fn views() -> impl TypedValueParser<Value = Show> {
    let values = Show::ALL.iter();
    let values = values.map(|show| PossibleValue::new(show.word()).help(show.help()));
    PossibleValuesParser::new(values).map(|word| {
        let mut shows = Show::ALL.iter().copied();
        shows
            .find(|show| show.word() == word)
            .expect("it is one of them")
    })
}

/// In a film the exposure follows the mean of the pictures so far; each new picture counts at least this much.
const SLOWEST_ADAPTATION: f32 = 0.12;

/// Takes pictures of a session.
struct Photographer {
    renderer: Renderer,
    offscreen: Offscreen,
    /// The view of the texture beside the picture.
    beside: Option<Offscreen>,
    /// The camera of the first picture.
    view: View,
    /// The number of pictures.
    pictures: u32,
    /// How often the camera goes round meanwhile.
    turns: f32,
    /// Diameter of the lens, world units; 0 for all in focus.
    lens: f32,
    /// How often each picture is drawn for its mean.
    passes: u32,
    /// The mean, if there are several.
    mean: Option<Mean>,
    /// The distance that is in focus, once a picture was taken. It stays for all pictures of a film, so that the blur does not jump.
    focus: Option<f32>,
    /// The network's graph is drawn over each picture.
    network: bool,
    /// Pictures in a row: the exposure follows the trail slowly, so that films do not flicker.
    film: bool,
    taken: u32,
}

impl Photographer {
    fn new(session: &Session, whole: [u32; 2], film: bool, split: bool) -> Result<Self> {
        let [width, height] = whole;
        let right = if split { width / 2 } else { 0 };
        let size = [width - right, height];
        let new = |size| {
            Offscreen::new(&session.ctx, size).map_err(|error| too_large(whole, "--size", error))
        };
        Ok(Self {
            renderer: Renderer::new(&session.ctx, session.simulation.setup(), offscreen::FORMAT)?,
            offscreen: new(size)?,
            beside: (right > 0).then(|| new([right, height])).transpose()?,
            view: View::of(&session.scene, glam::UVec2::from_array(size).as_vec2()),
            pictures: 1,
            turns: 0.0,
            lens: 0.0,
            passes: 1,
            mean: None,
            focus: None,
            network: false,
            film,
            taken: 0,
        })
    }

    /// Moves the camera away until all of the scene is in the picture from every side.
    fn stand_back(&mut self, scene: &Scene) {
        let size = glam::UVec2::from_array(self.offscreen.canvas().size()).as_vec2();
        let camera = &mut self.view.camera;
        camera.fit_all_round(view::points(scene), size);
    }

    /// A picture of the state after the last step.
    fn take(&mut self, session: &mut Session) -> Result<RgbaImage> {
        let mut view = self.view;
        // The last picture of a film is taken again for outputs of the last frame.
        let number = self.taken.min(self.pictures - 1);
        view.camera = (view.camera).turned(self.turns * number as f32 / self.pictures as f32);
        match self.mean.take() {
            Some(mean) => self.draw_mean(session, view, mean)?,
            None => self.draw(session, view, true, None)?,
        }
        let mut picture = self.offscreen.image();
        self.taken += 1;
        if let (true, Exposure::Auto { adaptation, .. }) = (self.film, &mut self.view.exposure) {
            *adaptation = (1.0 / (self.taken as f32 + 1.0)).max(SLOWEST_ADAPTATION);
        }
        if self.network {
            let snapshot = session.snapshot()?;
            let (setup, poses) = {
                let simulation = &session.simulation;
                (simulation.setup(), simulation.world_from_object())
            };
            let (graph, _) = network_of(&snapshot.trail, setup, &poses);
            draw_network(&mut picture, &graph, setup, &poses, &view.camera);
        }
        if self.view.is_transparent {
            offscreen::unmultiply(&mut picture);
        }
        Ok(match &self.beside {
            Some(beside) => side_by_side(&picture, &beside.image()),
            None => picture,
        })
    }

    /// Each picture is the mean of so many from now on; `whole` is the size with the texture beside it.
    fn average(&mut self, session: &Session, whole: [u32; 2], passes: u32) -> Result<()> {
        self.passes = passes;
        if passes > 1 {
            let mean = Mean::new(&session.ctx, self.offscreen.canvas().size());
            self.mean = Some(mean.map_err(|error| too_large(whole, "--size", error))?);
        }
        Ok(())
    }

    /// Draws the mean of pictures from all over the lens, or from one place; of fewer if the run is to end.
    fn draw_mean(&mut self, session: &mut Session, view: View, mut mean: Mean) -> Result<()> {
        let size = self.offscreen.canvas().size();
        let camera = view.camera;
        let cameras = if self.lens > 0.0 {
            let pixels = glam::UVec2::from_array(size).as_vec2();
            let focus = *self.focus.get_or_insert_with(|| {
                let poses = session.simulation.world_from_object();
                let ray = camera.ray(0.5 * pixels, pixels);
                lens::focus(&camera, pick::pick(&session.scene.surface, &poses, &ray))
            });
            lens::cameras(&camera, self.lens, focus, self.passes, pixels)
        } else {
            vec![camera; self.passes as usize]
        };
        mean.restart();
        for (i, view) in (0..).zip(offscreen::passes(view, cameras, size)) {
            if i > 0 && interrupt::requested() {
                break;
            }
            // The texture beside it stays as it is.
            self.draw(session, view, i == 0, Some(&mut mean))?;
        }
        self.mean = Some(mean);
        Ok(())
    }

    /// Draws a picture, and the texture beside it if `with_beside`, and waits for them. With a `mean`, the picture is the mean with it.
    fn draw(
        &mut self,
        session: &mut Session,
        view: View,
        with_beside: bool,
        mean: Option<&mut Mean>,
    ) -> Result<()> {
        let mut rec = session.frames.begin()?;
        let atlas = View {
            show: Show::Atlas,
            ..view
        };
        let mut pictures = vec![(view, self.offscreen.canvas())];
        let beside = self.beside.as_ref().filter(|_| with_beside);
        pictures.extend(beside.map(|beside| (atlas, beside.canvas())));
        self.renderer
            .draw_beside(&mut rec, session.simulation.state(), &pictures);
        if let Some(mean) = mean {
            mean.record(&mut rec, self.offscreen.canvas().image());
        }
        self.offscreen.record_readback(&mut rec);
        if let Some(beside) = beside {
            beside.record_readback(&mut rec);
        }
        session.frames.submit(rec)?;
        session.frames.wait_idle()?;
        Ok(())
    }
}

/// Two pictures of one height as one.
fn side_by_side(left: &RgbaImage, right: &RgbaImage) -> RgbaImage {
    let mut both = RgbaImage::new(left.width() + right.width(), left.height());
    image::imageops::replace(&mut both, left, 0, 0);
    image::imageops::replace(&mut both, right, i64::from(left.width()), 0);
    both
}
