//! Exports that the window begins, goes on with and reports.

use crate::lab::command::{Model, Out};
use crate::lab::document::Document;
use crate::lab::exports::Kind;
use crate::lab::names::Reserved;
use crate::lab::names::unnumbered;
use crate::lab::out::job::{ExportJob, Film, Job, Picture};
use crate::lab::out::recording::Recording;
use crate::lab::out::times::save_times;
use crate::lab::out::*;
use crate::lab::saving::whole;
use crate::lab::window::Lab;
use crate::lab::window::closing::{found_again, say, told_of, told_of_recording};
use crate::measured::lately::Lately;
use myxo::plain_text::Shown as _;
use myxo::render::output::{Output, Written};
use myxo::{Error, Result};
use std::path::PathBuf;

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
            self.interface.notices.say(context, error.to_string(), true);
        }
        self.host.request_redraw();
    }

    /// Begins a picture of the size that is chosen.
    pub(super) fn picture(&mut self, context: &egui::Context, picture: [u32; 2]) {
        let begun = self.begin_picture(picture);
        if let Err(error) = begun {
            self.interface.notices.say(context, error.to_string(), true);
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
        let mut view = scaled(&self.interface.document.view, picture, size);
        view.is_transparent = panel.transparent;
        let made = Picture::begin(&self.ctx, size, self.format, view, name);
        self.out.job = Some(Job::Picture(made.map_err(|error| too_large(size, error))?));
        Ok(())
    }

    /// Writes times and their trace beside each other.
    pub(super) fn save_times(&mut self, context: &egui::Context, times: &Lately) {
        let saved = save_times(&self.folder_out(), times);
        match saved {
            Ok(path) => {
                let path = whole(&path);
                let text = format!("Saved {}, and a trace beside it", path.shown());
                self.interface.notices.say(context, text, false);
            }
            Err(error) => self.interface.notices.say(context, error.to_string(), true),
        }
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
            .notices
            .say(context, "Recording: F9 ends it", false);
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
        let mut view = scaled(&self.interface.document.view, picture, size);
        view.is_transparent = panel.film_transparent && panel.kind == Kind::Png;
        if panel.turns != 0.0 {
            self.interface.document.stand_back(&mut view.camera, size);
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
            self.interface.notices.say(context, error.to_string(), true);
        }
    }

    pub(super) fn record_asked(&mut self, rec: &mut myxo::gpu::Recorder) -> Result<()> {
        let (Some(Job::Export(job)), Some(stage)) = (&mut self.out.job, &self.stage) else {
            return Ok(());
        };
        if job.is_asked_for(Model::Scene) && !self.interface.document.is_pending() {
            job.saves = Some(self.interface.document.state_to_save());
        }
        let Document { view, edited, .. } = &self.interface.document;
        job.record(rec, stage, view, edited)
    }

    /// Goes on with what is being made, for a moment, and tells what has come of it.
    pub(super) fn make(&mut self, context: &egui::Context) -> Result<()> {
        if let Some(job) = &mut self.out.job
            && let Some(stage) = &mut self.stage
        {
            // Where that fails, what there is of it is still kept.
            job.advance(
                &mut self.frames,
                stage,
                self.interface.document.morph.is_some(),
            )?;
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
                    self.interface.notices.say(context, text, false);
                }
                _ => {
                    if let (Some(Job::Export(export)), Ok(_)) = (job, &ended)
                        && export.saves.is_some()
                    {
                        self.interface.document.saved(export.saves);
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
                self.interface.notices.say(context, text, false);
            }
            Err(error) => self.interface.notices.say(context, error.to_string(), true),
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
