//! `myxo network`: the network of a state as a graph.

use std::path::{Path, PathBuf};

use clap::Args;
use glam::UVec2;
use myxo::export::{NetworkFile, NetworkFormat, network_columns};
use myxo::plain_text::{Shown as _, counted, escaped};
use myxo::render::offscreen::{self, Offscreen, too_large};
use myxo::render::output::write_png;
use myxo::render::{Renderer, View, draw_network};
use myxo::scene::Scene;
use myxo::sim::Snapshot;
use myxo::sim::graph::{Graph, Measures, network_of};
use myxo::sweep::unseen;
use myxo::{Error, Result};

use super::files::{Sink, check_distinct};
use super::options::{CommonOptions, Size};
use super::report::hash_text;
use super::session::Session;
use super::{Command, Outcome, interrupt};
use crate::console;

/// Run a scene without a window and write its network as a graph
///
/// The network is where the trail is more than 1.5 times its mean. It is thinned to lines, over seams and from object to object where
/// they touch: nodes are where lines meet or end, edges have a length, a width and a mean trail. Lengths are in scene radii.
///
/// The name of each --out says what it becomes: x.json has everything, x.graphml is for networkx and other graph libraries, x.csv has a
/// row for each edge, and x.png is a picture of the scene with the graph drawn over the trail.
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Examples:
  myxo network oats --steps 800 --out oats.json
  myxo network oats --steps 800 --out oats.png --size 1920x1080
  myxo network torus --steps 2000 --out torus.graphml --out torus.csv
  myxo network trio --steps 2000 --network-every 100 --series trio.csv
  myxo network --resume torus.ckpt --steps 0 --out torus.json")]
pub struct Network {
    /// A built-in name, a .toml file, a model, or a built-in mesh such as builtin:torus?tube=0.2; with --resume it may be left out
    #[arg(required_unless_present = "resume")]
    scene: Option<PathBuf>,
    /// How many steps to run; 0 takes the start, or what --resume names, as it is
    #[arg(long, value_name = "N", default_value_t = 400)]
    steps: u32,
    /// What to write: .json, .graphml, .csv or .png. May be repeated
    #[arg(long, value_name = "FILE", required_unless_present = "series")]
    out: Vec<PathBuf>,
    /// Also measures the graph after every step whose number is a multiple of N, for --series
    #[arg(long, value_name = "N", requires = "series", value_parser = clap::value_parser!(u32).range(1..))]
    network_every: Option<u32>,
    /// Writes the graph's measures along the way and at the end as CSV, a row for each step; - for the standard output
    #[arg(long, value_name = "FILE")]
    series: Option<PathBuf>,
    /// Size of pictures, in pixels
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "1280x720")]
    size: Size,
    #[command(flatten)]
    common: CommonOptions,
}

/// What an output becomes: text, or `None` for a picture.
fn format_of(path: &Path) -> Result<Option<NetworkFormat>> {
    match path.extension() {
        Some(ending) if ending.eq_ignore_ascii_case("png") => Ok(None),
        _ => NetworkFormat::of(path).map(Some),
    }
}

impl Command for Network {
    fn run(&self) -> Result<Outcome> {
        let files = || self.out.iter().chain(&self.series);
        check_distinct(files().chain(&self.common.state.checkpoint))?;
        let formats: Vec<Option<NetworkFormat>> = (self.out.iter())
            .map(|path| format_of(path))
            .collect::<Result<_>>()?;
        let scene = self.common.load(self.scene.as_deref())?;
        let is_drawn = formats.iter().any(Option::is_none);
        if is_drawn {
            check_view(&scene, self.steps)?;
        }
        interrupt::install()?;
        let sinks: Vec<Sink> = (self.out.iter())
            .map(|path| Sink::create(path))
            .collect::<Result<_>>()?;
        let series_sink = self.series.as_deref().map(Sink::create).transpose()?;
        self.common.check_outputs(files())?;
        let mut session = Session::open(scene, &self.common, u64::from(self.steps))?;
        // Checked again: masks and maps are inputs, too, and have been read by now.
        self.common.check_outputs(files())?;
        // Before the steps, so that a size that is too large is refused at once.
        let painter = (is_drawn.then(|| Painter::new(&session, self.size))).transpose()?;
        let (mut series, completed) = self.run_steps(&mut session)?;
        let ending = session.finish()?;
        session.progress.doing("following the network");
        let (graph, measures) = found(&session, &ending.snapshot);
        let picture = painter
            .map(|painter| painter.picture(&mut session, &graph))
            .transpose()?;
        session.progress.finish();
        let hash = hash_text(ending.snapshot.hash());
        let objects = session.simulation.settings().objects.iter();
        let objects: Vec<String> = objects.map(|object| object.name.clone()).collect();
        let file = NetworkFile {
            scene: &session.scene.name,
            step: ending.snapshot.step,
            state_hash: &hash,
            radius: f64::from(session.simulation.setup().radius),
            objects: &objects,
            measures: &measures,
            graph: &graph,
        };
        let name = escaped(&session.scene.name);
        console::message(&format!("{name} at step {}: state hash {hash}", file.step));
        console::message(&line(&measures));
        for ((sink, format), path) in sinks.into_iter().zip(formats).zip(&self.out) {
            if let Some(format) = format {
                sink.write(file.content(format))?;
            } else if let Some(picture) = &picture {
                sink.write(picture)?;
            }
            console::message(&format!("wrote {}", path.shown()));
        }
        // After Ctrl-C the last step may be there already.
        if series.last().is_none_or(|(step, _)| *step < file.step) {
            series.push((file.step, measures));
        }
        if let Some(sink) = series_sink {
            sink.write(table(&series)?)?;
        }
        Ok(match (ending.lacks_checkpoint, completed) {
            (true, _) => Outcome::Failed,
            (false, false) => Outcome::Interrupted,
            (false, true) => Outcome::Done,
        })
    }
}

impl Network {
    /// Runs the steps until Ctrl-C. Returns the measures of the graph along the way, each with its step, and whether all steps were done.
    fn run_steps(&self, session: &mut Session) -> Result<(Vec<(u64, Measures)>, bool)> {
        let mut series = Vec::new();
        for done in 1..=self.steps {
            if interrupt::requested() {
                return Ok((series, false));
            }
            session.step()?;
            session.forget_first(self.steps)?;
            let step = session.simulation.step();
            let is_due = |every: u32| step.is_multiple_of(u64::from(every));
            if done < self.steps && self.network_every.is_some_and(is_due) {
                let snapshot = session.snapshot()?;
                session.progress.doing("following the network");
                series.push((step, found(session, &snapshot).1));
                session.progress.doing_steps();
            }
        }
        Ok((series, true))
    }
}

/// Refuses a view that a graph cannot be drawn over.
fn check_view(scene: &Scene, steps: u32) -> Result<()> {
    let show = scene.settings.picture.show;
    if let Some(unseen) = unseen(scene, u64::from(steps)) {
        return Err(Error::Invalid(format!(
            "the view {} cannot be shown: {}: use --set picture.show=surface",
            show.word(),
            unseen.why()
        )));
    }
    if show.is_flat() {
        return Err(Error::Invalid(format!(
            "a network is not drawn over the view {}, which is flat: use --set picture.show=surface",
            show.word()
        )));
    }
    Ok(())
}

/// The graph of a state, and its measures.
fn found(session: &Session, snapshot: &Snapshot) -> (Graph, Measures) {
    let simulation = &session.simulation;
    network_of(
        &snapshot.trail,
        simulation.setup(),
        &simulation.world_from_object(),
    )
}

/// Draws the scene with its graph over it.
struct Painter {
    renderer: Renderer,
    canvas: Offscreen,
    view: View,
}

impl Painter {
    fn new(session: &Session, size: Size) -> Result<Self> {
        let size = [size.width, size.height];
        let setup = session.simulation.setup();
        Ok(Self {
            renderer: Renderer::new(&session.ctx, setup, offscreen::FORMAT)?,
            canvas: Offscreen::new(&session.ctx, size)
                .map_err(|error| too_large(size, "--size", error))?,
            view: View::of(&session.scene, UVec2::from_array(size).as_vec2()),
        })
    }

    /// The picture as a PNG.
    fn picture(mut self, session: &mut Session, graph: &Graph) -> Result<Vec<u8>> {
        let simulation = &session.simulation;
        let mut rec = session.frames.begin()?;
        let camera = self.view.camera;
        let canvas = &self.canvas;
        let seen = [(self.view, canvas.canvas())];
        (self.renderer).draw_beside(&mut rec, simulation.state(), &seen);
        canvas.record_readback(&mut rec);
        session.frames.submit(rec)?;
        session.frames.wait_idle()?;
        let mut picture = canvas.image();
        let poses = simulation.world_from_object();
        draw_network(&mut picture, graph, simulation.setup(), &poses, &camera);
        let mut bytes = Vec::new();
        write_png(&mut bytes, &picture).map_err(|error| Error::Invalid(error.to_string()))?;
        Ok(bytes)
    }
}

/// The measures as a line of text.
fn line(measures: &Measures) -> String {
    let Measures {
        nodes,
        edges,
        length,
        cycles,
        parts,
        ..
    } = measures;
    let foods = measures.foods.as_ref().map_or_else(String::new, |foods| {
        let efficiency = foods.efficiency.map_or_else(String::new, |efficiency| {
            format!(
                ", on ways that are {:.2} times as long as over the surface",
                1.0 / efficiency
            )
        });
        let connected = 100.0 * foods.connected;
        format!(
            "; it reaches {} and connects {connected:.0} % of their pairs{efficiency}",
            counted(foods.reached, "food", "foods")
        )
    });
    let nodes = counted(*nodes, "node", "nodes");
    let edges = counted(*edges, "edge", "edges");
    let parts = counted(*parts, "part", "parts");
    let cycles = counted(*cycles, "cycle", "cycles");
    format!("the network has {nodes}, {edges} of {length:.2} radii, {parts} and {cycles}{foods}")
}

/// A row for each step.
fn table(series: &[(u64, Measures)]) -> Result<String> {
    let failed =
        |error: &dyn std::fmt::Display| Error::Invalid(format!("cannot write a table: {error}"));
    let mut writer = csv::Writer::from_writer(Vec::new());
    let mut is_first = true;
    for (step, measures) in series {
        let columns = network_columns(measures);
        if std::mem::take(&mut is_first) {
            let names = std::iter::once("step").chain(columns.iter().map(|(name, _)| *name));
            writer.write_record(names).map_err(|error| failed(&error))?;
        }
        let values = columns.iter().map(|(_, value)| match value.is_null() {
            true => String::new(),
            false => value.to_string(),
        });
        let row = std::iter::once(step.to_string()).chain(values);
        writer.write_record(row).map_err(|error| failed(&error))?;
    }
    let bytes = writer.into_inner().map_err(|error| failed(&error))?;
    String::from_utf8(bytes).map_err(|error| failed(&error))
}
