//! Strokes of brushes that attract, repel, forbid or erase, from the press to the release: what each has changed, so that it
//! goes back by Ctrl Z and comes again.

use std::ops::Range;

use myxo::Result;
use myxo::gpu::Recorder;
use myxo::sim::paint::{Brush, Painted, Repainted};
use myxo::sim::{Areas, Simulation};

use super::super::window::Lab;

/// Strokes that can be undone, at the most.
const MOST: usize = 200;
/// Texels that they have changed, at the most, all of them together: 192 MiB.
const MOST_TEXELS: usize = 1 << 24;

/// What is said of a stroke that has changed too much.
const CANNOT_UNDO: &str = "This stroke and those before it cannot be undone";

/// A stroke that is over.
#[derive(Debug)]
struct Stroke {
    /// As [`super::super::undo::Undo`] numbers them.
    number: u64,
    changed: Vec<Repainted>,
    /// Before it nothing had been painted.
    is_first: bool,
}

/// A stroke that goes on.
struct Open {
    /// None where there was no room to keep it.
    before: Option<Areas>,
    /// Texels among which all lie that it has touched.
    span: Range<u32>,
}

/// All that can be undone or brought back.
#[derive(Default)]
pub struct Strokes {
    done: Vec<Stroke>,
    undone: Vec<Stroke>,
    open: Option<Open>,
}

impl Strokes {
    /// Records what is needed to undo a dab that is recorded next. Gives what is to be said where that is too much.
    pub fn before(&mut self, rec: &mut Recorder, run: &Simulation, brush: Brush) -> Option<String> {
        if self.open.is_some() || !run.changes_areas(brush) {
            return None;
        }
        let before = run.record_areas(rec);
        let text = (before.as_ref().err()).map(|error| format!("{CANNOT_UNDO}: {error}"));
        self.open = Some(Open {
            before: before.ok(),
            span: 0..0,
        });
        text
    }

    /// A dab has been recorded.
    pub fn painted(&mut self, painted: &Painted) {
        let Some(open) = self.open.as_mut().filter(|_| painted.count() > 0) else {
            return;
        };
        open.span = if open.span.is_empty() {
            painted.span.clone()
        } else {
            open.span.start.min(painted.span.start)..open.span.end.max(painted.span.end)
        };
    }

    /// The last one that is known up to a number; 0 for none.
    pub fn known(&self, number: u64) -> u64 {
        let all = self.done.iter().chain(&self.undone);
        let numbers = all.map(|stroke| stroke.number);
        numbers.filter(|known| *known <= number).max().unwrap_or(0)
    }

    /// One more; the oldest are forgotten where they would be too many.
    fn push(&mut self, stroke: Stroke) {
        self.undone.clear();
        self.done.push(stroke);
        let mut texels = 0;
        let kept = self.done.iter().rev().take(MOST).take_while(|stroke| {
            texels += stroke.changed.len();
            texels <= MOST_TEXELS
        });
        let kept = kept.count();
        self.done.drain(..self.done.len() - kept);
    }
}

impl Lab {
    /// The hand has let go: what was painted since it pressed is one stroke. Where it has changed nothing there is none.
    pub(in super::super) fn end_stroke(
        &mut self,
        context: &egui::Context,
        number: u64,
    ) -> Result<()> {
        self.paint_now(context)?;
        if let (Some(open), Some(stage)) = (self.hand.strokes.open.take(), &mut self.stage) {
            let Some(before) = open.before else {
                self.forget_strokes();
                return Ok(());
            };
            let is_first = before.is_empty();
            let changed = stage.simulation.repainted(&before, open.span)?;
            if !changed.is_empty() {
                let is_kept = changed.len() <= MOST_TEXELS;
                self.hand.strokes.push(Stroke {
                    number,
                    changed,
                    is_first,
                });
                if !is_kept {
                    let text = format!("{CANNOT_UNDO}: it has more than {MOST_TEXELS} texels");
                    self.interface.notice(context, text, false);
                }
            } else if is_first {
                stage.simulation.forget_areas()?;
            }
        }
        self.tell_strokes();
        Ok(())
    }

    /// Paints what the next frame would, and waits for it.
    fn paint_now(&mut self, context: &egui::Context) -> Result<()> {
        if self.hand.has_dabs() {
            let mut rec = self.frames.begin()?;
            self.record_dabs(&mut rec, context)?;
            self.frames.submit(rec)?;
        }
        Ok(self.frames.wait_idle()?)
    }

    /// Undo and redo go through the strokes that are known.
    fn tell_strokes(&mut self) {
        let strokes = &self.hand.strokes;
        let known = |number| strokes.known(number);
        self.interface.undo.keep_strokes(known);
    }

    /// Strokes go back, or come again, until this is the last one that there is.
    pub(in super::super) fn take_strokes(
        &mut self,
        context: &egui::Context,
        last: u64,
    ) -> Result<()> {
        self.paint_now(context)?;
        // What has no end yet would count what changes here as its own.
        self.hand.strokes.open = None;
        let Some(stage) = &mut self.stage else {
            return Ok(());
        };
        let strokes = &mut self.hand.strokes;
        loop {
            let is_back = strokes.done.last().is_some_and(|s| s.number > last);
            let (from, to) = if is_back {
                (&mut strokes.done, &mut strokes.undone)
            } else {
                (&mut strokes.undone, &mut strokes.done)
            };
            let Some(stroke) = from.pop_if(|stroke| is_back || stroke.number <= last) else {
                break;
            };
            if is_back && stroke.is_first {
                stage.simulation.forget_areas()?;
            } else {
                let mut rec = self.frames.begin()?;
                (stage.simulation).put_areas(&mut rec, &stroke.changed, !is_back)?;
                self.frames.submit(rec)?;
            }
            to.push(stroke);
        }
        stage.forget_picture();
        self.window.request_redraw();
        Ok(())
    }

    /// Another atlas has other texels: strokes on the one before are no longer known.
    pub(in super::super) fn forget_strokes(&mut self) {
        self.hand.strokes = Strokes::default();
        self.tell_strokes();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stroke(number: u64, texels: usize) -> Stroke {
        let texel = Repainted {
            texel: 0,
            before: 0.0,
            after: 1.0,
        };
        Stroke {
            number,
            changed: vec![texel; texels],
            is_first: false,
        }
    }

    #[test]
    fn the_oldest_strokes_are_forgotten() {
        let mut strokes = Strokes::default();
        for number in 1..=2 * MOST as u64 {
            strokes.push(stroke(number, 1));
        }
        assert_eq!(strokes.done.len(), MOST);
        assert_eq!(strokes.known(MOST as u64), 0);
        assert_eq!(strokes.known(MOST as u64 + 1), MOST as u64 + 1);
        assert_eq!(strokes.known(u64::MAX), 2 * MOST as u64);
        // By their size, too; one that is too large leaves none, for those before it could not go back without it.
        strokes.push(stroke(1000, MOST_TEXELS / 2));
        strokes.push(stroke(1001, MOST_TEXELS / 2));
        assert_eq!(strokes.known(u64::MAX), 1001);
        assert_eq!((strokes.done.len(), strokes.known(999)), (2, 0));
        strokes.push(stroke(1002, MOST_TEXELS + 1));
        assert_eq!(strokes.known(u64::MAX), 0);
    }

    #[test]
    fn a_stroke_spans_its_dabs() {
        let mut strokes = Strokes::default();
        let painted = |span: Range<u32>| Painted {
            texels: vec![span.len() as u32],
            span,
        };
        strokes.painted(&painted(3..4));
        assert!(strokes.open.is_none(), "trail is no stroke");
        strokes.open = Some(Open {
            before: None,
            span: 0..0,
        });
        for span in [7..9, 0..0, 5..6, 8..12] {
            strokes.painted(&painted(span));
        }
        assert_eq!(strokes.open.map(|open| open.span), Some(5..12));
    }
}
