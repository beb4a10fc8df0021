//! Jobs beside the frames, polled once a frame: the only place that asks other threads for their results.

use crate::lab::export::making::Export;
use crate::lab::export::recording::Recording;
use crate::lab::feeding::Fed;
use crate::lab::window::Lab;
use crate::lab::window::closing::{outcome_of, outcome_of_recording, say};
use myxo::Result;
use myxo::render::output::Written;

impl Lab {
    /// Advances all jobs and takes over those that have ended. A window that closes only finishes files being written.
    pub(super) fn poll_jobs(&mut self) -> Result<()> {
        if self.closing {
            self.begin_to_end();
        } else {
            self.run_waiting()?;
            if let Some((loading, result)) = self.jobs.take_loaded() {
                self.has_loaded(loading, result)?;
                // At once, for nothing else may come before it.
                self.run_waiting()?;
            }
        }
        if let Some(stage) = &self.runner.stage
            && let Some(fed) = self.jobs.food.take(&stage.simulation)
        {
            self.has_measured(fed)?;
        }
        if let Some(export) = &mut self.jobs.exports.job
            && let Some(stage) = &mut self.runner.stage
        {
            let look_changes = self.interface.document.morph.is_some();
            // If this fails, the finished part is still kept.
            export.advance(&mut self.runner.frames, stage, look_changes)?;
        }
        if let Some((export, written)) = self.jobs.exports.take_export() {
            self.has_exported(export, written);
        }
        if let Some((recording, written)) = self.jobs.exports.take_recording() {
            self.has_recorded(&recording, written);
        }
        self.poll_network();
        let facts = &mut self.clocks.facts;
        facts.loading = (self.jobs.loading.as_ref()).map(|loading| loading.facts());
        facts.exports = self.jobs.exports.facts();
        Ok(())
    }

    /// Takes over food that was measured. Refused food goes back to the running food, with a notice.
    fn has_measured(&mut self, fed: Fed) -> Result<()> {
        let refused = self.runner.feed(fed)?;
        if let Some(stage) = &self.runner.stage {
            let runs = stage.simulation.settings();
            let running = &mut self.interface.document.running;
            running.foods.clone_from(&runs.foods);
            running.feeding = runs.feeding.clone();
        }
        if let Some((refused, error)) = refused {
            self.interface.food_is_refused(&refused);
            self.notify(error.to_string(), true);
        }
        self.host.request_redraw();
        Ok(())
    }

    /// An export has ended.
    fn has_exported(&mut self, export: Export, written: Result<Written>) {
        if self.jobs.exports.ends.is_some() {
            say(&outcome_of(export.path(), &written, export.is_cancelled()));
        }
        if export.is_cancelled() {
            let text = format!("{} was given up", export.facts().name);
            return self.notify(text, false);
        }
        if let (Export::File(file), Ok(_)) = (export, &written)
            && file.saves.is_some()
        {
            self.interface.document.saved(file.saves);
            self.runner
                .back
                .saved(self.interface.document.file.as_ref());
        }
        self.report_written(written, "");
    }

    /// A recording has ended.
    fn has_recorded(&mut self, recording: &Recording, written: Result<Written>) {
        let remarks = recording.facts().remarks();
        if self.jobs.exports.ends.is_some() {
            say(&outcome_of_recording(recording.path(), &written, &remarks));
        }
        self.report_written(written, &remarks);
    }
}
