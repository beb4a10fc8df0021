//! `myxo export`: models, data and scene files of a state.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use myxo::Result;
use myxo::export::{self, Export, ExportFile};
use myxo::render::output::Written;

use super::files::{Sink, check_distinct};
use super::options::CommonOptions;
use super::session::{Ending, Session};
use super::{Outcome, console, interrupt};

/// Vertices that are more texels apart than this are too few for the trail.
const FINE: f32 = 6.0;

/// Run a scene without a window and take its state out: as model, as data, as scene file
///
/// The name of each --out says what it becomes: x.glb is a model with the trail as texture (or, by --colors vertex, as
/// colours of its vertices), x.ply a mesh with colours, x.npz all data for NumPy, x.toml a scene that begins here.
#[derive(Clone, Debug, Args)]
#[command(
    name = "export",
    after_help = "\
Examples:
  myxo export torus --steps 400 --out torus.glb
  myxo export trio --steps 900 --out trio.npz --out trio.ply --report trio.json
  myxo export suzanne --preset cells --steps 600 --colors vertex --out head.glb
  myxo export --resume torus.ckpt --steps 0 --out torus.npz"
)]
pub struct ExportCommand {
    /// A built-in name, a .toml file or a model; with --resume it may be left out
    #[arg(required_unless_present = "resume")]
    scene: Option<PathBuf>,
    /// How many steps to run; 0 takes the start, or what --resume names, as it is
    #[arg(long, value_name = "N", default_value_t = 400)]
    steps: u32,
    /// What to write: .glb, .ply, .npz or .toml. May be repeated
    #[arg(long, value_name = "FILE", required = true)]
    out: Vec<PathBuf>,
    /// Writes the report of the run as JSON; - for the standard output
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// What carries the colours of a .glb
    #[arg(long, value_enum, default_value_t)]
    colors: Colors,
    #[command(flatten)]
    common: CommonOptions,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum Colors {
    /// As fine as the trail is
    #[default]
    Texture,
    /// As fine as the mesh is, for programs without textures
    Vertex,
}

impl ExportCommand {
    /// Checks everything that can be checked before the work, and does it.
    pub fn run(&self) -> Result<Outcome> {
        let files = self.out.iter().chain(&self.report);
        check_distinct(files.chain(&self.common.state.checkpoint))?;
        let files: Vec<ExportFile> = self
            .out
            .iter()
            .map(|path| ExportFile::create(path))
            .collect::<Result<_>>()?;
        let scene = self.common.load(self.scene.as_deref())?;
        let report_sink = self.report.as_deref().map(Sink::create).transpose()?;
        interrupt::install()?;

        let mut session = Session::open(scene, &self.common, u64::from(self.steps))?;
        let ran = self.step(&mut session).and_then(|completed| {
            let ending = session.finish()?;
            let written = self.write(files, &session, &ending)?;
            Ok((completed, ending, written))
        });
        session.progress.finish();
        let (completed, ending, written) = ran?;

        let all = written.len() == self.out.len() && !ending.lacks_checkpoint;
        console::message(&format!(
            "{} at step {}: state hash {:016x}",
            session.scene.name,
            ending.snapshot.step,
            ending.snapshot.hash()
        ));
        for written in written {
            console::message(&written.to_string());
        }
        if let Some(sink) = report_sink {
            sink.write(session.report(&ending, !completed).to_json())?;
        }
        Ok(match (all, completed) {
            (false, _) => Outcome::Failed,
            (true, false) => Outcome::Interrupted,
            (true, true) => Outcome::Done,
        })
    }

    /// Runs the steps; says whether all of them were run.
    fn step(&self, session: &mut Session) -> Result<bool> {
        for _ in 0..self.steps {
            if interrupt::requested() {
                return Ok(false);
            }
            session.step()?;
            session.forget_first(self.steps)?;
        }
        Ok(true)
    }

    /// Writes the files. One that fails is told about, and the others go on.
    fn write(
        &self,
        files: Vec<ExportFile>,
        session: &Session,
        ending: &Ending,
    ) -> Result<Vec<Written>> {
        let export = Export::of(&session.scene, &session.simulation, &ending.snapshot)?;
        let colors = match self.colors {
            Colors::Texture => export::Colors::Texture,
            Colors::Vertex => export::Colors::Vertex,
        };
        let apart = export.texels_between_vertices();
        if apart > FINE && files.iter().any(|file| file.is_as_fine_as_its_mesh(colors)) {
            session.progress.say(&format!(
                "{}: vertices lie about {apart:.0} texels apart, and the trail is finer than that: colours of vertices \
                 show little of it; a .glb with texture shows it all",
                session.scene.name
            ));
        }
        let mut written = Vec::new();
        for file in files {
            session
                .progress
                .doing(&format!("writing {}", file.path().display()));
            match file.write(&export, colors) {
                Ok(file) => written.push(file),
                Err(error) => session.progress.say(&format!("myxo: {error}")),
            }
        }
        Ok(written)
    }
}
