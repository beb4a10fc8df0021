//! An export under way: a picture, a film, a model or a checkpoint. The window's thread does the part that needs the device, in
//! small pieces; other threads do the rest.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use myxo::Result;
use myxo::export::{self, Colors, ExportFile, ExportOnTheWay, Watch};
use myxo::gpu::{Context, Format, Frames, Recorder};
use myxo::render::exposure::Exposure;
use myxo::render::output::{Output, Written};
use myxo::render::{View, output};
use myxo::scene::Scene;
use myxo::scene::settings::Settings;

use crate::lab::command::Model;
use crate::lab::export::encoder::{Encoder, Frame};
use crate::lab::export::shot::{Care, Shot};
use crate::lab::export_panel::ExportPanel;
use crate::lab::facts::Making;
use crate::lab::job::Job;
use crate::lab::names::Reserved;
use crate::lab::objects::begin_on_food_that_is;
use crate::lab::stage::Stage;
use crate::lab::undo::Entry;

/// The time that one frame of the window spends on an export.
const MOMENT: Duration = Duration::from_millis(45);
/// In a film the exposure follows the trail with each picture by this share at the least.
const SLOWEST_ADAPTATION: f32 = 0.12;

/// An export under way.
pub enum Export {
    /// One picture.
    Picture(Picture),
    /// A film at a fixed step.
    Film(Film),
    /// A file of the state.
    File(FileExport),
}

impl Export {
    /// Advances for a moment. While the look changes, every picture of a film has a look of its own.
    pub fn advance(
        &mut self,
        frames: &mut Frames,
        stage: &mut Stage,
        look_changes: bool,
    ) -> Result<()> {
        match self {
            Self::Picture(picture) => picture.advance(frames, stage),
            Self::Film(film) => film.advance(frames, stage, look_changes),
            Self::File(_) => Ok(()),
        }
    }

    /// The result, once, when it has ended.
    pub fn take(&mut self) -> Option<Result<Written>> {
        match self {
            Self::Picture(picture) => picture.writer.as_mut()?.take(),
            Self::Film(film) => film.encoder.take(),
            Self::File(export) => export.writer.as_mut()?.take(),
        }
    }

    /// Cancels it.
    pub fn cancel(&mut self) {
        match self {
            Self::Picture(picture) => {
                picture.is_cancelled = true;
                picture.shot = None;
                // A picture that is already being written is done soon.
                if picture.writer.is_none() {
                    picture.writer = nothing();
                }
            }
            Self::Film(film) => film.encoder.cancel(),
            Self::File(export) => export.cancel(),
        }
    }

    /// Does the simulation stop for it, or step only for it?
    pub fn holds(&self) -> bool {
        match self {
            Self::Picture(picture) => picture.writer.is_none(),
            Self::Film(film) => !film.is_filmed(),
            Self::File(_) => false,
        }
    }

    /// For the interface.
    pub fn facts(&self) -> Making {
        match self {
            Self::Picture(picture) => Making {
                name: name_of(picture.name.path()),
                doing: match picture.writer {
                    None => "drawing".to_owned(),
                    Some(_) => "writing".to_owned(),
                },
                can_finish: false,
                done: Some(0.8 * picture.shot.as_ref().map_or(1.0, Shot::share)),
                is_cancelled: picture.is_cancelled,
            },
            Self::Film(film) => film.facts(),
            Self::File(export) => export.facts(),
        }
    }

    /// How much there is of a film whose pictures are being taken, seconds.
    pub fn filmed(&self) -> Option<f64> {
        match self {
            Self::Film(film) if !film.is_filmed() => Some(film.done as f64 / f64::from(film.fps)),
            _ => None,
        }
    }

    /// The file, or the folder of files, that it makes.
    pub fn path(&self) -> &Path {
        match self {
            Self::Picture(picture) => picture.name.path(),
            Self::Film(film) => &film.path,
            Self::File(export) => &export.path,
        }
    }

    /// Is it not wanted any more?
    pub fn is_cancelled(&self) -> bool {
        match self {
            Self::Picture(picture) => picture.is_cancelled,
            Self::Film(film) => film.encoder.is_cancelled(),
            Self::File(export) => export.watch.is_cancelled(),
        }
    }

    /// Is there a picture whose parts are still to be drawn?
    pub fn draws(&self) -> bool {
        matches!(self, Self::Picture(picture) if picture.writer.is_none())
    }

    /// Ends it with the window, and waits until its file is whole: a film has the pictures that it has. Returns nothing if
    /// there is nothing to be written yet.
    pub fn close(self) -> Option<Result<Written>> {
        match self {
            Self::Picture(picture) => picture.writer?.wait(),
            Self::Film(mut film) => {
                film.stop();
                film.encoder.wait()
            }
            Self::File(export) => export.writer?.wait(),
        }
    }
}

fn name_of(path: &Path) -> String {
    path.file_name()
        .unwrap_or(path.as_os_str())
        .to_string_lossy()
        .into_owned()
}

/// A file on its way: nothing to write yet, or a job that writes it.
type Writer = Option<Job<Written>>;

fn writing(write: impl FnOnce() -> Result<Written> + Send + 'static) -> Writer {
    Some(Job::begin("writing the file", move |_| write()))
}

/// The end of something that was cancelled before there was anything to write.
fn nothing() -> Writer {
    writing(|| {
        Ok(Written {
            files: Vec::new(),
            frames: 0,
        })
    })
}

/// A picture of any size.
pub struct Picture {
    /// None once it is drawn, or not wanted any more.
    shot: Option<Shot>,
    view: View,
    name: Arc<Reserved>,
    writer: Writer,
    is_cancelled: bool,
}

impl Picture {
    /// Nothing is drawn.
    pub fn begin(
        ctx: &Arc<Context>,
        size: [u32; 2],
        format: Format,
        mut view: View,
        care: Care,
        name: Reserved,
    ) -> Result<Self> {
        // As bright as the window is now.
        if let Exposure::Auto { adaptation, .. } = &mut view.exposure {
            *adaptation = 0.0;
        }
        Ok(Self {
            shot: Some(Shot::new(ctx, size, format, care)?),
            view,
            name: Arc::new(name),
            writer: None,
            is_cancelled: false,
        })
    }

    fn advance(&mut self, frames: &mut Frames, stage: &mut Stage) -> Result<()> {
        let begun = Instant::now();
        while let Some(shot) = &mut self.shot
            && begun.elapsed() < MOMENT
        {
            if shot.advance(frames, stage, &self.view)? {
                let frame = shot.take(0, &self.view);
                self.shot = None;
                let name = Arc::clone(&self.name);
                self.writer = writing(move || write(frame, &name));
            }
        }
        Ok(())
    }
}

fn write(frame: Frame, name: &Reserved) -> Result<Written> {
    let picture = frame.into_picture();
    let mut file = output::Output::create(name.path(), picture.dimensions(), 1.0)?;
    file.frame(&picture)?;
    Ok(file.finish()?)
}

/// A film at a fixed step: a number of steps, a picture, and so on, however long each takes.
pub struct Film {
    /// None once it was stopped.
    shot: Option<Shot>,
    /// The view of the first picture.
    view: View,
    turns: f64,
    encoder: Encoder,
    path: PathBuf,
    /// Steps from one picture to the next.
    every: u64,
    /// Pictures a second.
    fps: u32,
    /// Pictures in all, and those that were handed over.
    all: u64,
    done: u64,
    /// The step that the next picture is of.
    step: u64,
    begun: Instant,
}

impl Film {
    /// Begins with a picture of the state as it is.
    #[expect(clippy::too_many_arguments, reason = "each is asked for once")]
    pub fn begin(
        ctx: &Arc<Context>,
        output: Output,
        size: [u32; 2],
        format: Format,
        view: View,
        care: Care,
        name: Reserved,
        panel: &ExportPanel,
        step: u64,
    ) -> Result<Self> {
        Ok(Self {
            shot: Some(Shot::new(ctx, size, format, care)?),
            view,
            path: name.path().to_owned(),
            encoder: Encoder::begin(output, size, name),
            turns: panel.turns,
            every: u64::from(panel.every),
            fps: panel.film_fps,
            all: panel.film_frames(),
            done: 0,
            step,
            begun: Instant::now(),
        })
    }

    /// Are all its pictures taken?
    fn is_filmed(&self) -> bool {
        self.done == self.all || self.encoder.is_cancelled()
    }

    /// Ends it with the pictures that it has; it has nothing on the device any more.
    pub fn stop(&mut self) {
        self.shot = None;
        self.all = self.done;
        self.encoder.end(self.done);
    }

    /// Advances by steps and parts of pictures. A slower writer is waited for: no picture is left out.
    fn advance(
        &mut self,
        frames: &mut Frames,
        stage: &mut Stage,
        look_changes: bool,
    ) -> Result<()> {
        let begun = Instant::now();
        // The next picture waits for its look.
        let most = if look_changes {
            self.done + 1
        } else {
            self.all
        };
        while !self.is_filmed()
            && self.done < most
            && begun.elapsed() < MOMENT
            && let Some(shot) = &mut self.shot
        {
            if stage.simulation.step() < self.step {
                let mut rec = frames.begin()?;
                rec.scope("step", |rec| stage.simulation.record_step(rec));
                frames.submit(rec)?;
                frames.wait_idle()?;
                continue;
            }
            if !self.encoder.has_room() {
                break;
            }
            if let Exposure::Auto { adaptation, .. } = &mut self.view.exposure {
                *adaptation = (1.0 / (self.done as f32 + 2.0)).max(SLOWEST_ADAPTATION);
            }
            let mut view = self.view;
            // The frame after the last would be the first again.
            let turns = self.turns * self.done as f64 / self.all as f64;
            view.camera = view.camera.turned(turns as f32);
            if shot.advance(frames, stage, &view)? {
                self.encoder.push(shot.take(self.done, &view));
                self.done += 1;
                self.step += self.every;
                if self.done == self.all {
                    self.encoder.end(self.all);
                }
            }
        }
        Ok(())
    }

    /// For the interface.
    pub fn facts(&self) -> Making {
        let (written, _) = self.encoder.facts();
        let left = if self.done > 0 && !self.is_filmed() {
            let each = self.begun.elapsed().as_secs_f64() / self.done as f64;
            format!(", {:.0} s left", each * (self.all - self.done) as f64)
        } else {
            String::new()
        };
        Making {
            name: name_of(&self.path),
            doing: format!("frame {} of {}{left}", written, self.all),
            done: Some(self.done as f32 / self.all.max(1) as f32),
            can_finish: self.done > 0 && !self.is_filmed(),
            is_cancelled: self.encoder.is_cancelled(),
        }
    }
}

/// A file of the state, which another thread writes.
pub struct FileExport {
    watch: Arc<Watch>,
    writer: Writer,
    path: PathBuf,
    /// The file that the next frame is asked for.
    asked: Option<(Model, Colors, Reserved)>,
    /// The state for undo that a scene file has.
    pub saves: Option<Entry>,
    /// A scene file lacks a second look that was painted.
    pub lacks_look: bool,
}

impl FileExport {
    /// The state is copied in the next frame.
    pub fn ask(model: Model, colors: Colors, name: Reserved) -> Self {
        Self {
            watch: Arc::default(),
            writer: None,
            path: name.path().to_owned(),
            asked: Some((model, colors, name)),
            saves: None,
            lacks_look: false,
        }
    }

    /// Is the state still to be copied?
    pub fn is_asked(&self) -> bool {
        self.asked.is_some()
    }

    /// Is it a file of this kind, whose state is still to be copied?
    pub fn is_asked_for(&self, model: Model) -> bool {
        self.asked.as_ref().is_some_and(|asked| asked.0 == model)
    }

    /// Records copies of the state if they are asked for; the rest is up to another thread.
    pub fn record(
        &mut self,
        rec: &mut Recorder,
        stage: &Stage,
        view: &View,
        edited: &Settings,
    ) -> Result<()> {
        let Some((model, colors, name)) = self.asked.take() else {
            return Ok(());
        };
        let scene = Scene {
            settings: stage.settings_as_seen(view),
            ..stage.scene.clone()
        };
        let mut coming = ExportOnTheWay::record(&scene, &stage.simulation, rec)?;
        let export = &mut coming.export;
        export.scene.settings.camera = scene.settings.camera;
        export.scene.settings.picture = scene.settings.picture;
        // While other objects are on their way, food may lie on one that is not there.
        let on_these = edited.objects.len() == export.scene.settings.objects.len();
        if model == Model::Scene && on_these {
            // The food that the user has set, though it may still be on its way.
            export.scene.settings.foods.clone_from(&edited.foods);
            export.scene.settings.feeding = edited.feeding.clone();
            begin_on_food_that_is(&mut export.scene.settings);
        }
        export.view.camera = view.camera;
        export.view.color_map = view.color_map;
        if let Exposure::Fixed(_) = view.exposure {
            export.view.exposure = view.exposure;
        }
        let watch = Arc::clone(&self.watch);
        self.writer = writing(move || {
            let export = coming.wait(&watch)?;
            match model {
                Model::Checkpoint => export::write_checkpoint(export, name.path(), &watch),
                _ => ExportFile::create(name.path())?.write_watched(&export, colors, &watch),
            }
        });
        Ok(())
    }

    /// Cancels it.
    pub fn cancel(&mut self) {
        self.watch.cancel();
        if self.asked.take().is_some() {
            self.writer = nothing();
        }
    }

    fn facts(&self) -> Making {
        let doing = match self.watch.written() {
            0 => "copying the state".to_owned(),
            bytes => format!("{:.1} MB written", bytes as f64 / 1e6),
        };
        Making {
            name: name_of(&self.path),
            doing,
            done: None,
            can_finish: false,
            is_cancelled: self.watch.is_cancelled(),
        }
    }
}
