//! Previews of looks in the picture: they begin and end between frames, and only while nothing else uses the running scene.
//!
//! The first answer is a picture in the colours of the look, of the state that is there. It needs no copy and no kernels, and comes before
//! any step. Then what ran with another look returns to its state, and the kernels of this one are made by another thread; and once they
//! are, the state is copied on the device, and the scene continues with the look.

use crate::lab::previewing::{Previewing, with_look};
use crate::lab::window::Lab;
use myxo::Result;
use myxo::scene::settings::Settings;

impl Lab {
    /// Begins or ends to run the scene with the look that the interface previews.
    pub(super) fn follow_preview(&mut self) -> Result<()> {
        let only = self.why_only_colors();
        self.clocks.facts.only_colors = only;
        self.clocks.facts.steps_of = None;
        let look = self.interface.previewed_look().filter(|_| only.is_none());
        let Some(look) = look else {
            // A look that changes slowly waits for its kernels, too.
            if self.interface.document.morph.is_none() {
                self.jobs.ahead.give_up();
            }
            return self.end_preview();
        };
        let has = |previewing: &Previewing| previewing.has(&look.settings);
        if !self.runner.previewing.as_ref().is_some_and(has) {
            let colors = look.settings.picture.color_map;
            if !(self.runner.stage.as_ref()).is_some_and(|stage| stage.has_colors(colors)) {
                return Ok(());
            }
            self.end_preview()?;
            if self.runs_like(&look.settings) {
                // The kernels of the look that was pointed at before are not wanted.
                self.jobs.ahead.give_up();
                self.clocks.facts.steps_of = Some(look.name);
                return Ok(());
            }
            if !self.is_ready_for(&look.settings) {
                return Ok(());
            }
            if let Err(error) = self.runner.preview(&look.settings) {
                self.interface.preview.end_on(&look.name);
                return self.report_unless_lost(&format!("{} is not previewed", look.name), error);
            }
            if let Some(previewing) = &mut self.runner.previewing {
                previewing.network = self.clocks.facts.network.take();
                self.clocks.facts.runs_preview = true;
            }
        }
        if self.runner.has_preview_stepped() {
            self.clocks.facts.steps_of = Some(look.name);
        }
        Ok(())
    }

    /// Does the scene run with these parameters of a look already? Then its own steps are those of the look.
    fn runs_like(&self, look: &Settings) -> bool {
        let stage = self.runner.stage.as_ref();
        let runs = stage.map(|stage| stage.simulation.settings());
        runs.is_some_and(|runs| with_look(runs, look) == *runs)
    }

    /// Are the kernels of a look made? They are asked for once its colours are seen, because compiling takes a processor that the picture
    /// may need.
    fn is_ready_for(&mut self, look: &Settings) -> bool {
        let Some(stage) = &self.runner.stage else {
            return false;
        };
        let live = with_look(stage.simulation.settings(), look);
        self.jobs.ahead.are_made(&stage.simulation, &live)
    }

    /// The scene is what it was before the preview, if there is one.
    pub(super) fn end_preview(&mut self) -> Result<()> {
        if self.runner.previewing.is_some() {
            self.finish_steps()?;
        }
        if let Some(previewing) = self.runner.end_preview()? {
            self.clocks.facts.network = previewing.network;
            self.host.request_redraw();
        }
        // One may also have ended with its stage.
        self.clocks.facts.runs_preview = false;
        Ok(())
    }

    /// Why looks cannot be previewed on the running scene now.
    fn why_only_colors(&self) -> Option<&'static str> {
        let loads = self.runner.stage.is_none() || self.jobs.loading.is_some();
        if loads || !self.waiting.is_empty() {
            Some("a scene is on its way")
        } else if self.jobs.food.is_busy() {
            Some("food is being measured")
        } else if !self.runner.can_preview() {
            Some("the state is too large to be copied for it")
        } else if self.jobs.exports.is_busy() {
            Some("something is being recorded or exported")
        } else if self.interface.document.morph.is_some() {
            Some("the look is changing")
        } else {
            (!self.interface.document.playing).then_some("the simulation is paused")
        }
    }
}
