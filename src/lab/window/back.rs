//! The way back to what had grown: kept when it is left, and loaded again.

use crate::lab::back::*;
use crate::lab::loading::Origin;
use crate::lab::window::Lab;
use myxo::Result;

impl Lab {
    /// Begins to load what had grown.
    pub(super) fn go_back(&mut self) {
        let Some(grown) = self.runner.back.grown.clone() else {
            return;
        };
        self.interface.document.end_morph();
        let is_another = grown.shown.scene != self.runner.back.scenes;
        let (name, origin) = match is_another {
            true => (grown.state.name.clone(), Origin::File),
            false => (self.interface.document.name.clone(), Origin::Shown),
        };
        let sent = grown.clone();
        self.load(name, origin, move || sent.opened(is_another));
        self.runner.back.coming = Some(grown);
    }

    /// Keeps the state of the stage that is about to go. When the user goes back to an earlier state, a state that has hardly
    /// grown is kept, too, so that they can return to it.
    pub(super) fn keep_grown(&mut self, goes_back: bool) -> Result<()> {
        let shown = Shown {
            scene: self.runner.back.scenes,
            view: self.interface.document.view,
            fits: self.interface.document.is_fitted(),
            loaded: self.interface.document.loaded.clone(),
            file: self.interface.document.file.clone(),
            is_unsaved: self.interface.document.is_unsaved(),
        };
        if let Some(before) = self.runner.keep_grown(shown, goes_back)? {
            self.clocks.facts.before = Some(before);
        }
        Ok(())
    }

    /// Another scene is shown; if it has come back, it is as changed as it was.
    pub(super) fn shows_another(&mut self, come_back: Option<&Grown>) {
        self.runner.back.scenes += 1;
        let Some(grown) = come_back else {
            return;
        };
        self.interface
            .document
            .loaded
            .clone_from(&grown.shown.loaded);
        // Scenes have no shift of their own.
        let camera = &mut self.interface.document.view.camera;
        camera.shift = grown.shown.view.camera.shift;
        self.interface.document.fit_again(grown.shown.fits);
        if grown.shown.is_unsaved {
            self.interface.document.saved(None);
        }
    }
}
