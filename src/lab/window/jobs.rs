//! Jobs beside the frames, polled once a frame: the only place that asks other threads for their results.

use crate::lab::export::making::Export;
use crate::lab::export::recording::Recording;
use crate::lab::feeding::Fed;
use crate::lab::window::Lab;
use crate::lab::window::closing::{outcome_of, outcome_of_recording, say};
use crate::lab::window::scene_text::WITHOUT_LOOK;
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
        if is_given_up(export.is_cancelled(), &written) {
            let text = format!("{} was given up", export.facts().name);
            return self.notify(text, false);
        }
        let mut remark = "";
        if let (Export::File(file), Ok(_)) = (export, &written) {
            if file.lacks_look {
                remark = WITHOUT_LOOK;
            }
            if file.saves.is_some() {
                self.interface.document.saved(file.saves);
                self.runner
                    .back
                    .saved(self.interface.document.file.as_ref());
            }
        }
        self.report_written(written, remark);
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

/// Was it cancelled before its file was written? One that is whole by then stays.
fn is_given_up(is_cancelled: bool, written: &Result<Written>) -> bool {
    let has_files = |written: &Written| !written.files.is_empty();
    is_cancelled && !written.as_ref().is_ok_and(has_files)
}

#[cfg(test)]
mod tests {
    use super::*;
    use myxo::Error;
    use std::path::PathBuf;

    /// Would catch: a picture that is there although it was given up, by what is said.
    #[test]
    fn a_file_that_is_written_was_not_given_up() {
        let written = |files: &[&str]| {
            let files = files.iter().map(PathBuf::from).collect();
            Ok(Written { files, frames: 1 })
        };
        let failed = Err(Error::Invalid("it was cancelled".to_owned()));
        for (is_cancelled, written, wanted) in [
            (true, written(&["a.png"]), false),
            (true, written(&[]), true),
            (true, failed, true),
            (false, written(&["a.png"]), false),
            (false, written(&[]), false),
        ] {
            assert_eq!(is_given_up(is_cancelled, &written), wanted, "{written:?}");
        }
    }
}
