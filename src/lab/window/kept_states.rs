//! States that are kept while the scene runs, and the way back to them.

use std::sync::Arc;

use egui::ColorImage;
use myxo::Result;

use crate::lab::lost::is_loss;
use crate::lab::state_copy::StateCopy;
use crate::lab::timeline::{KeptState, Timeline};
use crate::lab::window::Lab;
use crate::room;

/// The size of a kept picture, pixels.
const PICTURE: [u32; 2] = [168, 112];

impl Lab {
    /// Keeps the present state if it is time, and nothing else needs the device.
    pub(super) fn keep_when_due(&mut self) -> Result<()> {
        let Some(stage) = &self.runner.stage else {
            return Ok(());
        };
        let (bytes, step) = (StateCopy::bytes_of(stage), stage.simulation.step());
        let is_free = self.runner.previewing.is_none()
            && self.runner.can_draw()
            && !self.jobs.exports.is_busy()
            && !self.jobs.are_waited_for()
            && !self.host.context().input(|i| i.pointer.any_down());
        let is_due = self.timeline.is_due(self.host.now(), step, bytes);
        if !is_free || !is_due {
            return Ok(());
        }
        match self.keep_state(false) {
            Err(error) if is_loss(&error) => return Err(error),
            Err(error) => {
                log::debug!("step {step} is not kept: {error}");
                self.timeline.fail(self.host.now());
            }
            Ok(_) => {}
        }
        Ok(())
    }

    /// Keeps the present state because the user asks for it.
    pub(super) fn keep_state_now(&mut self) -> Result<()> {
        let kept = self.keep_state(true);
        let text = match kept {
            Ok(Some(_)) => format!("Step {} is kept", self.clocks.facts.step),
            Ok(None) => return Ok(()),
            Err(error) => return self.report_unless_lost("The state is not kept", error),
        };
        self.notify(text, false);
        Ok(())
    }

    /// Keeps the present state, and returns it; none where nothing runs.
    fn keep_state(&mut self, by_user: bool) -> Result<Option<Arc<KeptState>>> {
        self.paint_now()?;
        let Some(stage) = &self.runner.stage else {
            return Ok(None);
        };
        let bytes = StateCopy::bytes_of(stage);
        if !Timeline::has_room(bytes) {
            let text = format!("a copy of it takes {} MiB", bytes >> 20);
            return Err(myxo::Error::Invalid(text));
        }
        room::check_copy(bytes)?;
        let copy = StateCopy::of(stage)?;
        let Some(picture) = self.small_picture()? else {
            return Ok(None);
        };
        let picture = image::imageops::thumbnail(&picture, PICTURE[0], PICTURE[1]);
        let size = PICTURE.map(|side| side as usize);
        let picture = ColorImage::from_rgba_unmultiplied(size, picture.as_raw());
        let colors = self.interface.document.view.color_map;
        let now = self.host.now();
        let kept = self.timeline.keep(copy, (colors, picture), now, by_user);
        self.clocks.facts.kept = self.timeline.facts();
        self.host.request_redraw();
        Ok(Some(kept))
    }

    /// Goes back to a kept state, with its settings. The present state is kept before, and undo returns to it.
    pub(super) fn go_to_state(&mut self, number: u64) -> Result<()> {
        if self.jobs.loading.is_some() {
            let text = "A scene is on its way: wait for it, then go back";
            self.notify(text, false);
            return Ok(());
        }
        let Some(kept) = self.timeline.find(number) else {
            return Ok(());
        };
        self.end_morph();
        self.interface.note_changes();
        let from = match self.keep_state(false) {
            Ok(from) => from,
            Err(error) if is_loss(&error) => return Err(error),
            // There is no way back to it, then.
            Err(_) => None,
        };
        if !self.put_state(&kept)? {
            return Ok(());
        }
        // Keeping the present state may have taken its place, and may have found none where those of the user leave no room.
        for state in from.iter().chain([&kept]) {
            self.timeline.keep_again(state);
        }
        let from = from.map(|from| from.number());
        self.clocks.facts.kept = self.timeline.facts();
        let document = &mut self.interface.document;
        document.edited.clone_from(&kept.copy.settings);
        document.view.color_map = kept.colors;
        let (settings, view) = (&document.edited, &document.view);
        document.undo.go_to_state(settings, view, (from, number));
        self.interface
            .looks
            .find_preset(&mut self.interface.document);
        self.interface.document.note();
        Ok(())
    }

    /// Undo or redo has led to a kept state. The settings follow.
    pub(super) fn return_to_state(&mut self, number: u64) -> Result<()> {
        let Some(kept) = self.timeline.find(number) else {
            let text = "That state is no longer kept: the settings alone are back";
            self.notify(text, false);
            return Ok(());
        };
        self.put_state(&kept)?;
        Ok(())
    }

    /// Lets the scene continue from a kept state; false if it cannot, which a notice says.
    fn put_state(&mut self, kept: &KeptState) -> Result<bool> {
        self.paint_now()?;
        let Some(stage) = &mut self.runner.stage else {
            return Ok(false);
        };
        let painted = (stage.simulation.areas()?, stage.simulation.looks()?);
        if let Err(error) = kept.copy.put(stage, &mut self.jobs.food) {
            self.report_unless_lost("The scene cannot go back to it", error)?;
            return Ok(false);
        }
        // A film ends with what it has, as before a restart.
        self.jobs.exports.leave_stage();
        self.clocks.facts.step = stage.simulation.step();
        self.clocks.facts.seconds = stage.seconds();
        self.interface.document.running = kept.copy.settings.clone();
        if let Some(checks) = &mut self.runner.checks {
            checks.restart();
        }
        let snapshot = &kept.copy.snapshot;
        if (&painted.0, &painted.1) != (&snapshot.bias, &snapshot.looks) {
            // Strokes are differences of areas and looks that are no longer there.
            self.forget_strokes();
        }
        self.moved = self.host.now();
        self.host.request_redraw();
        Ok(true)
    }

    /// Another scene is shown.
    pub(super) fn forget_states(&mut self) {
        self.timeline.forget();
        self.clocks.facts.kept.clear();
    }
}
