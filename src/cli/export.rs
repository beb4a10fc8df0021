//! `myxo export`: models, data and scene files of a state.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum, value_parser};
use myxo::Result;
use myxo::export::{self, Export, ExportFile, Format};
use myxo::plain_text::{Shown as _, escaped};
use myxo::render::output::Written;
use myxo::sim::Snapshot;
use myxo::sim::areas::map_for;

use super::files::{Sink, check_distinct};
use super::options::CommonOptions;
use super::session::Session;
use super::{Command, Outcome, interrupt};
use crate::console;

/// Vertices that are more texels apart than this are too coarse for the trail.
const FINE: f32 = 6.0;

/// Run a scene without a window and export its state: as model, as data, as scene file
///
/// The name of each --out says what it becomes: x.glb is a model with the trail as texture (or, by --colors vertex, as
/// colours of its vertices), x.ply a mesh with colours, x.npz all data for NumPy, x.toml a scene that begins here. With --every
/// there is a series of each: x_000400.npz is x.npz of step 400.
#[derive(Clone, Debug, Args)]
#[command(
    name = "export",
    after_help = "\
Examples:
  myxo export torus --steps 400 --out torus.glb
  myxo export trio --steps 900 --out trio.npz --out trio.ply --report trio.json
  myxo export torus --steps 2000 --every 100 --out torus.npz
  myxo export suzanne --preset cells --steps 600 --colors vertex --out head.glb
  myxo export --resume torus.ckpt --steps 0 --out torus.npz"
)]
pub struct ExportCommand {
    /// A built-in name, a .toml file, a model, or a built-in mesh such as builtin:torus?tube=0.2; with --resume it may be left out
    #[arg(required_unless_present = "resume")]
    scene: Option<PathBuf>,
    /// How many steps to run; 0 takes the start, or what --resume names, as it is
    #[arg(long, value_name = "N", default_value_t = 400)]
    steps: u32,
    /// What to write: .glb, .ply, .npz or .toml. May be repeated
    #[arg(long, value_name = "FILE", required = true)]
    out: Vec<PathBuf>,
    /// Also writes the files after every step whose number is a multiple of N; all have the step in their names
    ///
    /// Steps are numbered over all runs, so that one that continues from a checkpoint continues with the series. The report's wall time
    /// includes the writing.
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..))]
    every: Option<u32>,
    /// Writes the report of the run as JSON; - for the standard output
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// The place of the colours in a .glb
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

impl Command for ExportCommand {
    /// Checks everything that can be checked beforehand, then runs and exports.
    fn run(&self) -> Result<Outcome> {
        let files = self.out.iter().chain(&self.report);
        check_distinct(files.chain(&self.common.state.checkpoint))?;
        let scene = self.common.load(self.scene.as_deref())?;
        interrupt::install()?;
        let files: Vec<ExportFile> = self
            .out
            .iter()
            .map(|path| ExportFile::create(path))
            .collect::<Result<_>>()?;
        let report_sink = self.report.as_deref().map(Sink::create).transpose()?;

        let written = || self.out.iter().chain(&self.report);
        self.common.check_outputs(written())?;
        let mut session = Session::open(scene, &self.common, u64::from(self.steps))?;
        // Checked again: masks and maps are inputs, too, and have been read by now.
        let existing = self.existing(session.simulation.step());
        self.common.check_outputs(written().chain(&existing))?;
        let mut series = Series::new(self.every.is_none().then_some(files));
        let ran = self.step(&mut session, &mut series).and_then(|completed| {
            let ending = session.finish()?;
            self.write(&mut series, &session, &ending.snapshot)?;
            Ok((completed, ending))
        });
        session.progress.finish();
        let written = |series: &Series| {
            for written in &series.written {
                console::message(&written.to_string());
            }
        };
        let (completed, ending) = ran.inspect_err(|_| written(&series))?;

        let all = series.has_all_files && !ending.lacks_checkpoint;
        console::message(&format!(
            "{} at step {}: state hash {:016x}",
            escaped(&session.scene.name),
            ending.snapshot.step,
            ending.snapshot.hash()
        ));
        written(&series);
        if let Some(sink) = report_sink {
            sink.write(session.report(&ending, !completed).to_json())?;
        }
        Ok(match (all, completed) {
            (false, _) => Outcome::Failed,
            (true, false) => Outcome::Interrupted,
            (true, true) => Outcome::Done,
        })
    }
}

impl ExportCommand {
    /// Runs the steps and writes the files that are due; returns whether all steps were run.
    fn step(&self, session: &mut Session, series: &mut Series) -> Result<bool> {
        for done in 1..=self.steps {
            if interrupt::requested() {
                return Ok(false);
            }
            session.step()?;
            session.forget_first(self.steps)?;
            let step = session.simulation.step();
            let is_due = |every: u32| step.is_multiple_of(u64::from(every));
            // The files of the last step are written at the end.
            if done < self.steps && self.every.is_some_and(is_due) {
                let snapshot = session.snapshot()?;
                self.write(series, session, &snapshot)?;
                session.progress.doing_steps();
            }
        }
        Ok(true)
    }

    /// The files that are there already and that a run from the step `first` on will replace, but for those that options name: files of a
    /// series, and maps beside scene files.
    fn existing(&self, first: u64) -> Vec<PathBuf> {
        let last = first + u64::from(self.steps);
        let mut all = Vec::new();
        for path in &self.out {
            let mut files = match self.every.map(u64::from) {
                None => vec![path.clone()],
                Some(every) => {
                    let is_due = |step: u64| {
                        step == last || (first < step && step < last && step.is_multiple_of(every))
                    };
                    let mut files = beside(path);
                    files.retain(|file| step_of(path, file).is_some_and(is_due));
                    files
                }
            };
            if Format::of(path) == Some(Format::Toml) {
                let scenes = files.iter().filter(|file| file.is_file());
                let maps: Vec<PathBuf> = scenes.map(|scene| map_for(scene)).collect();
                files.extend(maps);
            }
            all.extend(files);
        }
        all
    }

    /// The files of a state.
    fn files(&self, series: &mut Series, step: u64) -> Vec<Result<ExportFile>> {
        match series.files.take() {
            Some(files) => files.into_iter().map(Ok).collect(),
            None => {
                let paths = self.out.iter().map(|path| of_step(path, step));
                let create = |path: PathBuf| {
                    // After an interruption it may be another step than those checked before.
                    self.common.check_outputs(std::iter::once(&path))?;
                    ExportFile::create(&path)
                };
                paths.map(create).collect()
            }
        }
    }

    /// Writes the files. An error about one of them is printed, and the others are written.
    fn write(&self, series: &mut Series, session: &Session, snapshot: &Snapshot) -> Result<()> {
        // After an interruption, the files of this step may have been written already.
        if series.step.replace(snapshot.step) == Some(snapshot.step) {
            return Ok(());
        }
        let export = Export::of(&session.scene, &session.simulation, snapshot)?;
        let colors = match self.colors {
            Colors::Texture => export::Colors::Texture,
            Colors::Vertex => export::Colors::Vertex,
        };
        let files = self.files(series, snapshot.step);
        let apart = export.texels_between_vertices();
        let mut all = files.iter().flatten();
        if !series.has_warned_of_coarseness
            && apart > FINE
            && all.any(|file| file.is_as_fine_as_its_mesh(colors))
        {
            series.has_warned_of_coarseness = true;
            session.progress.say(&format!(
                "{}: vertices lie about {apart:.0} texels apart, and the trail is finer than that: colours of vertices \
                 show little of it; a .glb with texture shows it all",
                escaped(&session.scene.name)
            ));
        }
        for file in files {
            let written = file.and_then(|file| {
                let path = file.path().shown();
                session.progress.doing(&format!("writing {path}"));
                file.write(&export, colors)
            });
            match written {
                Ok(file) => series.written.push(file),
                Err(error) => {
                    series.has_all_files = false;
                    session.progress.say(&format!("myxo: {error}"));
                }
            }
        }
        Ok(())
    }
}

/// The files written on the way and at the end.
struct Series {
    /// Files that were begun before the first step, if only the end is written.
    files: Option<Vec<ExportFile>>,
    written: Vec<Written>,
    /// The step that was written last.
    step: Option<u64>,
    /// All files so far could be written.
    has_all_files: bool,
    /// The warning about coarse vertices was printed.
    has_warned_of_coarseness: bool,
}

impl Series {
    fn new(files: Option<Vec<ExportFile>>) -> Self {
        Self {
            files,
            written: Vec::new(),
            step: None,
            has_all_files: true,
            has_warned_of_coarseness: false,
        }
    }
}

/// `x.npz` of step 400 is `x_000400.npz`.
fn of_step(path: &Path, step: u64) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(format!("_{step:06}"));
    if let Some(ending) = path.extension() {
        name.push(".");
        name.push(ending);
    }
    path.with_file_name(name)
}

/// The step of a file in the series of `path`.
fn step_of(path: &Path, file: &Path) -> Option<u64> {
    let stem = file.file_stem()?.to_string_lossy();
    let step: u64 = stem.rsplit('_').next()?.parse().ok()?;
    (of_step(path, step).file_name() == file.file_name()).then_some(step)
}

/// Everything in the folder of `path`. The files of a series are looked for there, because it may have billions of steps.
fn beside(path: &Path) -> Vec<PathBuf> {
    let folder = path.parent().filter(|folder| *folder != Path::new(""));
    let entries = std::fs::read_dir(folder.unwrap_or(Path::new(".")));
    let entries = entries.into_iter().flatten().flatten();
    let files = entries.map(|entry| path.with_file_name(entry.file_name()));
    files.collect()
}
