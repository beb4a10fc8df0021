//! Exports that the window begins, advances and reports.

use crate::lab::command::{ExportRequest, Model};
use crate::lab::document::Document;
use crate::lab::export::making::{Export, FileExport, Film, Picture};
use crate::lab::export::recording::Recording;
use crate::lab::export::times::save_times;
use crate::lab::export::*;
use crate::lab::export_panel::Kind;
use crate::lab::names::{Reserved, unnumbered};
use crate::lab::saving::whole;
use crate::lab::window::Lab;
use crate::lab::window::closing::found_again;
use crate::lab::window::scene_text::has_painted_look;
use myxo::plain_text::Shown as _;
use myxo::render::output::{Output, Written};
use myxo::{Error, Result};
use std::path::PathBuf;

impl Lab {
    /// The folder for exports.
    pub(super) fn export_folder(&self) -> PathBuf {
        let home = directories::UserDirs::new();
        let home = home.as_ref().map(|dirs| dirs.home_dir());
        typed_folder(&self.interface.exports.folder, home)
    }

    /// Obeys a request of the interface; an error is shown in a notice.
    pub(super) fn obey_export(&mut self, out: ExportRequest, picture: [u32; 2]) {
        let done = match out {
            ExportRequest::Record => self.record(picture),
            ExportRequest::Film => self.film(picture),
            ExportRequest::Export(model) => self.export(model),
            ExportRequest::Cancel => {
                if let Some(job) = &mut self.jobs.exports.job {
                    job.cancel();
                }
                Ok(())
            }
            ExportRequest::Finish => {
                if let Some(Export::Film(film)) = &mut self.jobs.exports.job
                    && film.facts().can_finish
                {
                    film.stop();
                }
                Ok(())
            }
        };
        if let Err(error) = done {
            self.notify(error.to_string(), true);
        }
        self.host.request_redraw();
    }

    /// Begins a picture of the size that is chosen.
    pub(super) fn picture(&mut self, picture: [u32; 2]) {
        let begun = self.begin_picture(picture);
        if let Err(error) = begun {
            self.notify(error.to_string(), true);
        }
    }

    fn begin_picture(&mut self, picture: [u32; 2]) -> Result<()> {
        let Some(stage) = &self.runner.stage else {
            return Ok(());
        };
        self.is_free()?;
        let panel = &self.interface.exports;
        let size = panel.size.pixels(picture, panel.custom);
        let most = self.runner.ctx.info().max_image_side;
        check_size(size, most)?;
        let name = Reserved::next(&self.export_folder(), "screenshot", "png")?;
        let mut view = scaled(&self.interface.document.view, picture, size);
        view.is_transparent = panel.transparent;
        let care = Care::Fine.of(&view, panel.lens as f32 * stage.scene.radius);
        let made = Picture::begin(&self.runner.ctx, size, self.runner.format, view, care, name);
        self.jobs.exports.job = Some(Export::Picture(
            made.map_err(|error| too_large(size, error))?,
        ));
        Ok(())
    }

    /// Writes the times that are shown, and their trace beside them.
    pub(super) fn save_times(&mut self) {
        let (ctx, frames) = (&self.runner.ctx, &self.runner.frames);
        let stage = self.runner.stage.as_ref();
        let times = stage.and_then(|stage| self.clocks.measured(ctx, frames, stage));
        let no_times = || Error::Invalid("there are no times yet: they come while it runs".into());
        let saved = times.ok_or_else(no_times);
        match saved.and_then(|times| save_times(&self.export_folder(), &times)) {
            Ok(path) => {
                let path = whole(&path);
                let text = format!("Saved {}, and a trace beside it", path.shown());
                self.notify(text, false);
            }
            Err(error) => self.notify(error.to_string(), true),
        }
    }

    /// One thing at a time, or files would be made of different states.
    fn is_free(&self) -> Result<()> {
        match &self.jobs.exports.job {
            None => Ok(()),
            Some(job) => Err(Error::Invalid(format!(
                "{} is being made: wait for it, or cancel it",
                job.facts().name
            ))),
        }
    }

    fn record(&mut self, picture: [u32; 2]) -> Result<()> {
        if let Some(recording) = &mut self.jobs.exports.recording {
            if !recording.is_ending() {
                self.runner.frames.wait_idle()?;
                recording.stop();
            }
            return Ok(());
        }
        if self.runner.stage.is_none() || picture.contains(&0) {
            return Ok(());
        }
        let panel = &self.interface.exports;
        let (kind, fps) = (panel.kind, panel.fps);
        let (name, output) = self.output("recording", kind, picture, fps)?;
        let (ctx, format) = (&self.runner.ctx, self.runner.format);
        let recording = Recording::begin(ctx, output, picture, name, fps, format);
        self.jobs.exports.recording = Some(recording);
        self.notify("Recording: F9 ends it", false);
        Ok(())
    }

    fn film(&mut self, picture: [u32; 2]) -> Result<()> {
        let Some(stage) = &self.runner.stage else {
            return Ok(());
        };
        let first_step = stage.simulation.step();
        self.is_free()?;
        let panel = self.interface.exports.clone();
        let lens = panel.film_lens as f32 * stage.scene.radius;
        let size = panel.film_size.pixels(picture, panel.custom);
        check_size(size, LARGEST_FILM)?;
        let (name, output) = self.output("film", panel.kind, size, panel.film_fps)?;
        let mut view = scaled(&self.interface.document.view, picture, size);
        view.is_transparent = panel.film_transparent && panel.kind == Kind::Png;
        if panel.turns != 0.0 {
            self.interface.document.stand_back(&mut view.camera, size);
        }
        let care = Care::Once.of(&view, lens);
        let film = Film::begin(
            &self.runner.ctx,
            output,
            size,
            self.runner.format,
            view,
            care,
            name,
            &panel,
            first_step,
        );
        self.jobs.exports.job = Some(Export::Film(film.map_err(|error| too_large(size, error))?));
        Ok(())
    }

    fn output(
        &self,
        stem: &str,
        kind: Kind,
        size: [u32; 2],
        fps: u32,
    ) -> Result<(Reserved, Output)> {
        let name = Reserved::next(&self.export_folder(), stem, kind.ending())?;
        let path = match kind {
            Kind::Png => name.as_folder(),
            Kind::Mp4 | Kind::Gif => name.path().to_owned(),
        };
        let mut output = Output::create(&path, size.into(), f64::from(fps))?;
        if let Some(flag) = self.jobs.exports.interrupt {
            output.set_interrupt(flag);
        }
        Ok((name, output))
    }

    fn export(&mut self, model: Model) -> Result<()> {
        self.is_free()?;
        if model == Model::Scene {
            // Whether a second look was painted is read at once.
            self.paint_now()?;
        }
        let Some(stage) = &self.runner.stage else {
            return Ok(());
        };
        let stem = unnumbered(&self.interface.document.name).replace(std::path::is_separator, "_");
        let name = Reserved::next(&self.export_folder(), &stem, model.ending())?;
        let colors = self.interface.exports.colors;
        let mut file = FileExport::ask(model, colors, name);
        file.lacks_look = model == Model::Scene && has_painted_look(&stage.simulation);
        self.jobs.exports.job = Some(Export::File(file));
        Ok(())
    }

    /// Records the copy of the state for an export, if one is asked for; an error, such as too little memory, is shown in a
    /// notice.
    pub(super) fn record_export(&mut self, rec: &mut myxo::gpu::Recorder) {
        if let Err(error) = self.record_asked(rec) {
            self.jobs.exports.job = None;
            self.notify(error.to_string(), true);
        }
    }

    pub(super) fn record_asked(&mut self, rec: &mut myxo::gpu::Recorder) -> Result<()> {
        let (Some(Export::File(job)), Some(stage)) =
            (&mut self.jobs.exports.job, &self.runner.stage)
        else {
            return Ok(());
        };
        let document = &self.interface.document;
        if job.is_asked_for(Model::Scene) && !document.is_pending() && !job.lacks_look {
            job.saves = Some(document.state_to_save());
        }
        let Document { view, edited, .. } = &self.interface.document;
        job.record(rec, stage, view, edited)
    }

    /// Shows the outcome of a file in a notice.
    pub(super) fn report_written(&mut self, ended: Result<Written>, remarks: &str) {
        let (text, is_error) = match ended {
            Ok(written) => (format!("Saved {}{remarks}", found_again(&written)), false),
            Err(error) => (error.to_string(), true),
        };
        self.notify(text, is_error);
    }

    /// Copies the picture of this frame, if one is being recorded; `drawn` distinguishes it from others.
    pub(super) fn look_on(
        recording: &mut Exports,
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
