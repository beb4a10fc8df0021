//! The way back to what had grown: kept when it is left, and loaded again.

use crate::lab::back::*;
use crate::lab::facts::Before;
use crate::lab::loading::Origin;
use crate::lab::window::Lab;
use crate::room;
use myxo::Result;

impl Lab {
    /// Begins to load what had grown.
    pub(super) fn go_back(&mut self) {
        let Some(grown) = self.back.grown.clone() else {
            return;
        };
        self.interface.document.end_morph();
        let is_another = grown.shown.scene != self.back.scenes;
        let (name, origin) = match is_another {
            true => (grown.state.name.clone(), Origin::File),
            false => (self.name.clone(), Origin::Shown),
        };
        let sent = grown.clone();
        self.load(name, origin, move || sent.opened(is_another));
        self.back.coming = Some(grown);
    }

    /// Keeps what has grown on the stage that is about to go; also what has hardly grown, if it goes for what had grown before,
    /// so that whoever goes back can change their mind.
    pub(super) fn keep_grown(&mut self, goes_back: bool) -> Result<()> {
        let shown = Shown {
            scene: self.back.scenes,
            view: self.interface.document.view,
            loaded: self.interface.document.loaded.clone(),
            file: self.file.clone(),
            is_unsaved: self.interface.document.is_unsaved(),
        };
        let Some(left) = &mut self.stage else {
            return Ok(());
        };
        if !goes_back && left.simulation.step() < GROWN_AT {
            return Ok(());
        }
        let setup = left.simulation.setup();
        let bytes = bytes_of(setup.particles.len(), setup.atlas.texel_count());
        // The one before makes room, if that is enough.
        let before = self.back.grown.as_ref();
        let room = before.map_or(0, |grown| grown.state.bytes());
        room::check_copy(bytes.saturating_sub(room))?;
        self.back.grown = None;
        self.clocks.facts.before = None;
        let grown = Grown::of(left, shown)?;
        self.clocks.facts.before = Some(Before {
            name: grown.state.name.clone(),
            step: grown.state.checkpoint.snapshot.step,
        });
        self.back.grown = Some(grown);
        Ok(())
    }

    /// Another scene is shown; if it has come back, it is as changed as it was.
    pub(super) fn shows_another(&mut self, come_back: Option<&Grown>) {
        self.back.scenes += 1;
        let Some(grown) = come_back else {
            return;
        };
        self.interface
            .document
            .loaded
            .clone_from(&grown.shown.loaded);
        if grown.shown.is_unsaved {
            self.interface.document.saved(None);
        }
    }

    /// The device goes: what had grown may be what it was lost by.
    pub(super) fn forget_grown(&mut self) {
        self.back = Back::default();
        self.clocks.facts.before = None;
    }
}
