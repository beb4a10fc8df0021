//! Strokes that end, are taken back and come again.

use crate::lab::lost::is_loss;
use crate::lab::strokes::*;
use crate::lab::window::Lab;
use myxo::sim::paint::Repainted;
use myxo::{Error, Result};

impl Lab {
    /// The button was released: what was painted since the press is one stroke, unless it has changed nothing.
    pub(crate) fn end_stroke(&mut self) -> Result<()> {
        let pending_ends = &mut self.interface.tools.pending_ends;
        *pending_ends = pending_ends.saturating_sub(1);
        self.paint_now()?;
        let (Some(open), Some(stage)) = (self.edits.strokes.open.take(), &mut self.runner.stage)
        else {
            return Ok(());
        };
        let Some(before) = open.before else {
            self.forget_strokes();
            return Ok(());
        };
        let changed = match stage.simulation.repainted(&before, open.span) {
            Ok(changed) => changed,
            Err(error) => {
                self.forget_strokes();
                return self.report_unless_lost(CANNOT_UNDO, error);
            }
        };
        let is_first = before.is_empty();
        if changed.is_empty() {
            let forgotten = if is_first {
                stage.simulation.forget_areas()
            } else {
                Ok(())
            };
            return forgotten.or_else(|error| self.report_unless_lost("Empty areas stay", error));
        }
        let is_kept = changed.len() <= MOST_TEXELS;
        let undo = &mut self.interface.document.undo;
        self.edits.strokes.keep(undo, changed, is_first);
        if !is_kept {
            let text = format!("{CANNOT_UNDO}: it has more than {MOST_TEXELS} texels");
            self.notify(text, false);
        }
        // The buttons of undo and redo may be others now.
        self.host.request_redraw();
        Ok(())
    }

    /// Takes these texels' areas away: one more thing to undo.
    pub(crate) fn take_away(&mut self, texels: Vec<Repainted>) -> Result<()> {
        let Some(stage) = &mut self.runner.stage else {
            return Ok(());
        };
        let mut rec = self.runner.frames.begin()?;
        stage.simulation.put_areas(&mut rec, &texels, true)?;
        self.runner.frames.submit(rec)?;
        stage.forget_picture();
        self.interface.note_changes();
        let undo = &mut self.interface.document.undo;
        self.edits.strokes.keep(undo, texels, false);
        Ok(())
    }

    /// Paints what the next frame would, and waits for it.
    pub(crate) fn paint_now(&mut self) -> Result<()> {
        if self.edits.has_dabs() {
            let mut rec = self.runner.frames.begin()?;
            self.record_dabs(&mut rec)?;
            self.runner.frames.submit(rec)?;
        }
        Ok(self.runner.frames.wait_idle()?)
    }

    /// Undoes or redoes strokes until this is the last one.
    pub(crate) fn take_strokes(&mut self, last: u64) -> Result<()> {
        self.paint_now()?;
        // An open stroke would count this change as its own.
        self.edits.strokes.open = None;
        let Some(stage) = &mut self.runner.stage else {
            return Ok(());
        };
        let strokes = &mut self.edits.strokes;
        let mut refused = None;
        while let Some((stroke, is_back)) = strokes.take_towards(last) {
            let taken = if is_back && stroke.is_first {
                stage.simulation.forget_areas()
            } else {
                let mut rec = self.runner.frames.begin()?;
                let put = (stage.simulation).put_areas(&mut rec, &stroke.changed, !is_back);
                if put.is_ok() {
                    self.runner.frames.submit(rec)?;
                }
                put
            };
            // A refused stroke stays where it was: the next undo or redo includes it.
            strokes.put(stroke, is_back == taken.is_err());
            if let Err(error) = taken {
                refused = Some((is_back, error));
                break;
            }
        }
        stage.forget_picture();
        self.host.request_redraw();
        match refused {
            None => Ok(()),
            Some((true, error)) => self.report_unless_lost("A stroke could not be undone", error),
            Some((false, error)) => self.report_unless_lost("A stroke could not be redone", error),
        }
    }

    /// An undo for which there is no memory is no reason to end the lab. With a lost device the whole lab restarts.
    pub(crate) fn report_unless_lost(&mut self, what: &str, error: Error) -> Result<()> {
        if is_loss(&error) {
            return Err(error);
        }
        let text = format!("{what}: {error}");
        self.notify(text, true);
        Ok(())
    }

    /// Another atlas has other texels: strokes on the one before are no longer known.
    pub(crate) fn forget_strokes(&mut self) {
        self.edits.strokes = Strokes::default();
        self.edits.strokes.limit(&mut self.interface.document.undo);
    }
}
