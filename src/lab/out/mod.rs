//! Taking out: pictures of any size, recordings of the window, films at a fixed step, models and data; all beside what
//! runs.

mod closing;
mod encoder;
mod job;
mod names;
mod panel;
mod recording;
mod shot;

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use myxo::render::View;
use myxo::render::output::{Output, Written};
use myxo::scene::settings::Settings;
use myxo::{Error, Result};

use super::interface::Interface;
use super::stage::Stage;
use super::window::Lab;
pub(super) use closing::say;
use closing::{found_again, told_of, told_of_recording};
use job::{ExportJob, Film, Job, Picture};
pub use names::{Reserved, unnumbered};
use recording::Recording;
pub use shot::Shot;

#[cfg(test)]
pub use panel::Size;
pub use panel::{Kind, OutPanel};
pub use recording::Recorded;

/// The largest picture of a film, pixels a side.
pub const LARGEST_FILM: u32 = 4096;

/// What the interface asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Out {
    /// Begin to record the window, or end it.
    Record,
    /// A film at a fixed step.
    Film,
    /// A file of the present state.
    Export(Model),
    /// Give up what is being made.
    Cancel,
    /// End the film that is being made with the pictures that it has.
    Finish,
}

/// What a state is written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Model {
    /// A model with the trail on it.
    Glb,
    /// A mesh with colours.
    Ply,
    /// All data for NumPy.
    Npz,
    /// A scene file.
    Scene,
    /// Everything, to go on from.
    Checkpoint,
}

impl Model {
    /// Every one, in the order of the panel.
    pub const ALL: [Self; 5] = [
        Self::Glb,
        Self::Ply,
        Self::Npz,
        Self::Scene,
        Self::Checkpoint,
    ];

    /// The ending of its files.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Glb => "glb",
            Self::Ply => "ply",
            Self::Npz => "npz",
            Self::Scene => "toml",
            Self::Checkpoint => "ckpt",
        }
    }
}

/// What is being made, for the interface.
#[derive(Clone, Debug, PartialEq)]
pub struct Making {
    /// The file's name.
    pub name: String,
    /// How far it is, in words.
    pub doing: String,
    /// The share that is done, where that is known.
    pub done: Option<f32>,
    /// Would it be whole if it ended now?
    pub can_finish: bool,
    /// The user does not want it any more.
    pub is_cancelled: bool,
}

/// What the interface shows of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OutFacts {
    /// A recording under way.
    pub recording: Option<Recorded>,
    /// Anything else.
    pub making: Option<Making>,
    /// Of the film that is being made: how much of it there is, seconds.
    pub filmed: Option<f64>,
    /// The window closes when all of it is whole.
    pub ends: bool,
}

/// What is under way.
#[derive(Default)]
pub struct TakeOut {
    recording: Option<Recording>,
    job: Option<Job>,
    /// Since when all of it is only finished, because the window is to close then.
    ends: Option<Instant>,
    /// The window waits for none of it.
    gives_up: bool,
    /// Becomes true with Ctrl-C.
    interrupt: Option<&'static AtomicBool>,
}

impl TakeOut {
    /// Nothing yet; `interrupt` becomes true with Ctrl-C.
    pub fn new(interrupt: &'static AtomicBool) -> Self {
        Self {
            interrupt: Some(interrupt),
            ..Self::default()
        }
    }

    /// For the interface.
    pub fn told(&self) -> OutFacts {
        OutFacts {
            recording: self.recording.as_ref().map(Recording::told),
            making: self.job.as_ref().map(Job::told),
            filmed: self.job.as_ref().and_then(Job::filmed),
            ends: self.ends.is_some(),
        }
    }

    /// Does the simulation stand as it is, or go on only when a film asks for it?
    pub fn holds(&self) -> bool {
        self.job.as_ref().is_some_and(Job::holds)
    }

    /// Is there something to be done, or to be shown as it goes on?
    pub fn is_busy(&self) -> bool {
        self.job.is_some() || self.recording.is_some()
    }

    /// Another scene comes: films end with what they have, pictures that are not drawn are given up, and exports that have no
    /// state yet.
    pub fn leave_stage(&mut self) {
        match &mut self.job {
            Some(Job::Film(film)) => film.stop(),
            Some(job @ Job::Picture(_)) if job.draws() => job.cancel(),
            Some(Job::Export(export)) => {
                // What its file has is nothing of the next scene's.
                export.saves = None;
                if export.is_asked() {
                    export.cancel();
                }
            }
            _ => {}
        }
    }

    /// The device goes: a recording, too, ends with what it has. What is left is written without a device.
    pub fn leave_device(&mut self) {
        if let Some(recording) = &mut self.recording
            && !recording.is_ending()
        {
            recording.stop();
        }
        self.leave_stage();
    }
}

/// A folder as somebody types it, who means their own by ~ as in a shell.
fn typed_folder(text: &str, home: Option<&Path>) -> PathBuf {
    let text = Path::new(text.trim());
    match (text.strip_prefix("~"), home) {
        (Ok(below), Some(home)) => home.join(below),
        _ => text.to_owned(),
    }
}

impl Lab {
    /// Where files go.
    pub(super) fn folder_out(&self) -> PathBuf {
        let home = directories::UserDirs::new();
        let home = home.as_ref().map(|dirs| dirs.home_dir());
        typed_folder(&self.interface.out.folder, home)
    }

    /// Does what the interface asks for; what is wrong is said.
    pub(super) fn take_out(&mut self, context: &egui::Context, out: Out, picture: [u32; 2]) {
        let done = match out {
            Out::Record => self.record(context, picture),
            Out::Film => self.film(picture),
            Out::Export(model) => self.export(model),
            Out::Cancel => {
                if let Some(job) = &mut self.out.job {
                    job.cancel();
                }
                Ok(())
            }
            Out::Finish => {
                if let Some(Job::Film(film)) = &mut self.out.job
                    && film.told().can_finish
                {
                    film.stop();
                }
                Ok(())
            }
        };
        if let Err(error) = done {
            self.interface.notice(context, error.to_string(), true);
        }
        self.host.request_redraw();
    }

    /// Begins a picture of the size that is chosen.
    pub(super) fn picture(&mut self, context: &egui::Context, picture: [u32; 2]) {
        let begun = self.begin_picture(picture);
        if let Err(error) = begun {
            self.interface.notice(context, error.to_string(), true);
        }
    }

    fn begin_picture(&mut self, picture: [u32; 2]) -> Result<()> {
        if self.stage.is_none() {
            return Ok(());
        }
        self.is_free()?;
        let panel = &self.interface.out;
        let size = panel.size.pixels(picture, panel.custom);
        let most = self.ctx.info().max_image_side;
        check_size(size, most)?;
        let name = Reserved::next(&self.folder_out(), "screenshot", "png")?;
        let mut view = scaled(&self.interface.view, picture, size);
        view.is_transparent = panel.transparent;
        let made = Picture::begin(&self.ctx, size, self.format, view, name);
        self.out.job = Some(Job::Picture(made.map_err(|error| too_large(size, error))?));
        Ok(())
    }

    /// One thing at a time, or files would be made of different states.
    fn is_free(&self) -> Result<()> {
        match &self.out.job {
            None => Ok(()),
            Some(job) => Err(Error::Invalid(format!(
                "{} is being made: wait for it, or cancel it",
                job.told().name
            ))),
        }
    }

    fn record(&mut self, context: &egui::Context, picture: [u32; 2]) -> Result<()> {
        if let Some(recording) = &mut self.out.recording {
            if !recording.is_ending() {
                self.frames.wait_idle()?;
                recording.stop();
            }
            return Ok(());
        }
        if self.stage.is_none() || picture.contains(&0) {
            return Ok(());
        }
        let panel = &self.interface.out;
        let (kind, fps) = (panel.kind, panel.fps);
        let (name, output) = self.output("recording", kind, picture, fps)?;
        let (ctx, format) = (&self.ctx, self.format);
        let recording = Recording::begin(ctx, output, picture, name, fps, format);
        self.out.recording = Some(recording);
        self.interface
            .notice(context, "Recording: F9 ends it", false);
        Ok(())
    }

    fn film(&mut self, picture: [u32; 2]) -> Result<()> {
        let Some(stage) = &self.stage else {
            return Ok(());
        };
        let first_step = stage.simulation.step();
        self.is_free()?;
        let panel = self.interface.out.clone();
        let size = panel.film_size.pixels(picture, panel.custom);
        check_size(size, LARGEST_FILM)?;
        let (name, output) = self.output("film", panel.kind, size, panel.film_fps)?;
        let mut view = scaled(&self.interface.view, picture, size);
        view.is_transparent = panel.film_transparent && panel.kind == Kind::Png;
        if panel.turns != 0.0 {
            self.interface.stand_back(&mut view.camera, size);
        }
        let film = Film::begin(
            &self.ctx,
            output,
            size,
            self.format,
            view,
            name,
            &panel,
            first_step,
        );
        self.out.job = Some(Job::Film(film.map_err(|error| too_large(size, error))?));
        Ok(())
    }

    fn output(
        &self,
        stem: &str,
        kind: Kind,
        size: [u32; 2],
        fps: u32,
    ) -> Result<(Reserved, Output)> {
        let name = Reserved::next(&self.folder_out(), stem, kind.ending())?;
        let path = match kind {
            Kind::Png => name.as_folder(),
            Kind::Mp4 | Kind::Gif => name.path().to_owned(),
        };
        let mut output = Output::create(&path, size.into(), f64::from(fps))?;
        if let Some(flag) = self.out.interrupt {
            output.set_interrupt(flag);
        }
        Ok((name, output))
    }

    fn export(&mut self, model: Model) -> Result<()> {
        self.is_free()?;
        if self.stage.is_none() {
            return Ok(());
        }
        let stem = unnumbered(&self.name).replace(std::path::is_separator, "_");
        let name = Reserved::next(&self.folder_out(), &stem, model.ending())?;
        let colors = self.interface.out.colors;
        self.out.job = Some(Job::Export(ExportJob::ask(model, colors, name)));
        Ok(())
    }

    /// Records what an export takes of the state, if one is asked for; no memory for it is said.
    pub(super) fn record_export(&mut self, rec: &mut myxo::gpu::Recorder, context: &egui::Context) {
        if let Err(error) = self.record_asked(rec) {
            self.out.job = None;
            self.interface.notice(context, error.to_string(), true);
        }
    }

    fn record_asked(&mut self, rec: &mut myxo::gpu::Recorder) -> Result<()> {
        let (Some(Job::Export(job)), Some(stage)) = (&mut self.out.job, &self.stage) else {
            return Ok(());
        };
        if job.is_asked_for(Model::Scene) && !self.interface.is_pending() {
            job.saves = Some(self.interface.state_to_save());
        }
        let Interface { view, edited, .. } = &self.interface;
        job.record(rec, stage, view, edited)
    }

    /// Goes on with what is being made, for a moment, and tells what has come of it.
    pub(super) fn make(&mut self, context: &egui::Context) -> Result<()> {
        if let Some(job) = &mut self.out.job
            && let Some(stage) = &mut self.stage
        {
            // Where that fails, what there is of it is still kept.
            job.advance(&mut self.frames, stage, self.interface.morph.is_some())?;
        }
        let ended = self.out.job.as_mut().and_then(Job::take);
        if let Some(ended) = ended {
            let job = self.out.job.take();
            let was = job
                .as_ref()
                .map(|job| (job.path().to_owned(), job.is_cancelled()));
            if let (true, Some((path, is_cancelled))) = (self.out.ends.is_some(), was) {
                say(&told_of(&path, &ended, is_cancelled));
            }
            match job.as_ref().map(Job::told) {
                Some(making) if making.is_cancelled => {
                    let text = format!("{} was given up", making.name);
                    self.interface.notice(context, text, false);
                }
                _ => {
                    if let (Some(Job::Export(export)), Ok(_)) = (job, &ended)
                        && export.saves.is_some()
                    {
                        self.interface.saved(export.saves);
                        self.back.saved(self.file.as_ref());
                    }
                    self.tell_written(context, ended, "");
                }
            }
        }
        let recording = self.out.recording.as_mut();
        if let Some(ended) = recording.and_then(Recording::take) {
            let recording = self.out.recording.take();
            let told = recording.as_ref().map(Recording::told);
            let remarks = told.unwrap_or_default().remarks();
            if let (true, Some(recording)) = (self.out.ends.is_some(), recording) {
                say(&told_of_recording(recording.path(), &ended, &remarks));
            }
            self.tell_written(context, ended, &remarks);
        }
        Ok(())
    }

    fn tell_written(&mut self, context: &egui::Context, ended: Result<Written>, remarks: &str) {
        match ended {
            Ok(written) => {
                let text = format!("Saved {}{remarks}", found_again(&written));
                self.interface.notice(context, text, false);
            }
            Err(error) => self.interface.notice(context, error.to_string(), true),
        }
    }

    /// Copies the picture of this frame, if one is being recorded; `drawn` tells it from others.
    pub(super) fn look_on(
        recording: &mut TakeOut,
        rec: &mut myxo::gpu::Recorder,
        picture: &myxo::gpu::Image,
        drawn: u64,
    ) -> Result<()> {
        match &mut recording.recording {
            Some(recording) => recording.look(rec, picture, drawn),
            None => Ok(()),
        }
    }
}

/// The view for a picture of another size: it has all that the window shows, also where it is narrower, and points of particles
/// keep their share of it.
pub fn scaled(view: &View, from: [u32; 2], to: [u32; 2]) -> View {
    let mut view = *view;
    if from.contains(&0) || to.contains(&0) {
        return view;
    }
    let aspect = |[width, height]: [u32; 2]| width as f32 / height as f32;
    let narrower = (aspect(from) / aspect(to)).max(1.0);
    let fov = &mut view.camera.vertical_fov;
    *fov = 2.0 * (narrower * (0.5 * *fov).tan()).atan();
    view.particle_size *= to[1] as f32 / from[1] as f32 / narrower;
    view
}

/// What of the look a scene file holds.
pub fn put_look(view: &View, center: glam::Vec3, settings: &mut Settings) {
    settings.camera = view.camera.to_settings(center);
    view.write_to(&mut settings.picture);
}

fn check_size(size: [u32; 2], most: u32) -> Result<()> {
    if size.iter().all(|side| (1..=most).contains(side)) {
        return Ok(());
    }
    let [width, height] = size;
    Err(Error::Invalid(format!(
        "a picture of {width} x {height} cannot be made: each side must be 1 to {most}"
    )))
}

fn too_large([width, height]: [u32; 2], error: Error) -> Error {
    match error {
        error @ Error::Gpu(_) => Error::Invalid(format!(
            "there is no room for a picture of {width} x {height}: {error}: choose a smaller size"
        )),
        error => error,
    }
}

impl Stage {
    /// The settings that run, with a look.
    fn settings_as_seen(&self, view: &View) -> Settings {
        let mut settings = self.simulation.settings().clone();
        put_look(view, self.scene.center, &mut settings);
        settings
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;
    use myxo::scene::{Overrides, Scene};

    #[test]
    fn folders_are_typed_as_in_a_shell() {
        let home = Some(Path::new("/home/somebody"));
        for (typed, wanted) in [
            ("", ""),
            (" films ", "films"),
            ("~", "/home/somebody"),
            ("~/Pictures", "/home/somebody/Pictures"),
            ("~other/films", "~other/films"),
            ("/a/~/b", "/a/~/b"),
        ] {
            assert_eq!(typed_folder(typed, home), Path::new(wanted));
        }
        assert_eq!(typed_folder("~/films", None), Path::new("~/films"));
    }

    #[test]
    fn what_the_window_shows_is_in_pictures_of_any_shape() {
        let scene = Scene::load("cube".as_ref(), &Overrides::default()).unwrap();
        let from = [1104, 876];
        let view = View::of(&scene, Vec2::new(1104.0, 876.0));
        // Of what lies at a distance of 1: half of the picture's width and height, and of a pixel.
        let half = |view: &View, [width, height]: [u32; 2]| {
            let up = (0.5 * view.camera.vertical_fov).tan();
            let aspect = width as f32 / height as f32;
            [up * aspect, up, up / height as f32]
        };
        let [across, up, pixel] = half(&view, from);
        for to in [from, [2048, 2048], [1080, 1920], [3840, 2160], [1, 900]] {
            let other = scaled(&view, from, to);
            let [its_across, its_up, its_pixel] = half(&other, to);
            let seen = [its_across / across, its_up / up];
            assert!(seen.iter().all(|share| *share > 0.9999), "{to:?}: {seen:?}");
            assert!(seen.iter().any(|share| *share < 1.0001), "{to:?}: {seen:?}");
            let size = other.particle_size * its_pixel / (view.particle_size * pixel);
            assert!((size - 1.0).abs() < 1e-3, "{to:?}: {size}");
        }
    }
}
