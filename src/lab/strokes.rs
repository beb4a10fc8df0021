//! Strokes of brushes that attract, repel, forbid or erase, from the press to the release: what each has changed, so that it
//! goes back by Ctrl Z and comes again.

use std::ops::Range;

use myxo::gpu::Recorder;
use myxo::sim::paint::{Brush, Painted, Repainted};
use myxo::sim::{Areas, Simulation};

use crate::lab::undo::Undo;

/// Strokes that can be undone, at the most.
const MOST: usize = 200;
/// Texels that they have changed, at the most, all of them together: 192 MiB.
pub const MOST_TEXELS: usize = 1 << 24;

/// The notice for a stroke that has changed too much.
pub const CANNOT_UNDO: &str = "This stroke and those before it cannot be undone";

/// A stroke that has ended.
#[derive(Debug)]
pub struct Stroke {
    /// As [`Undo`] numbers them.
    pub number: u64,
    pub changed: Vec<Repainted>,
    /// Before it nothing had been painted.
    pub is_first: bool,
}

/// A stroke in progress.
pub struct Open {
    /// None if there was no room to keep it.
    pub before: Option<Areas>,
    /// Texels among which all lie that it has touched.
    pub span: Range<u32>,
}

/// All that can be undone or brought back.
#[derive(Default)]
pub struct Strokes {
    pub done: Vec<Stroke>,
    pub undone: Vec<Stroke>,
    pub open: Option<Open>,
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

    /// The last stroke that is kept up to a number; 0 for none.
    pub fn known(&self, number: u64) -> u64 {
        let all = self.done.iter().chain(&self.undone);
        let numbers = all.map(|stroke| stroke.number);
        numbers.filter(|known| *known <= number).max().unwrap_or(0)
    }

    /// A stroke has changed something: that is one more thing to undo.
    pub fn keep(&mut self, undo: &mut Undo, changed: Vec<Repainted>, is_first: bool) {
        self.push(Stroke {
            number: undo.stroke(),
            changed,
            is_first,
        });
        self.limit(undo);
    }

    /// One more; the oldest are forgotten where they would be too many.
    pub fn push(&mut self, mut stroke: Stroke) {
        // The count of texels then equals the memory in use.
        stroke.changed.shrink_to_fit();
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

    /// Limits undo and redo to the strokes that are kept.
    pub fn limit(&self, undo: &mut Undo) {
        undo.keep_strokes(|number| self.known(number));
    }

    /// The next stroke on the way to the state whose last stroke is `last`, and whether it is undone. The caller has to put it
    /// back.
    pub fn take_towards(&mut self, last: u64) -> Option<(Stroke, bool)> {
        if let Some(stroke) = self.done.pop_if(|stroke| stroke.number > last) {
            return Some((stroke, true));
        }
        let stroke = self.undone.pop_if(|stroke| stroke.number <= last)?;
        Some((stroke, false))
    }

    pub fn put(&mut self, stroke: Stroke, is_done: bool) {
        let to = if is_done {
            &mut self.done
        } else {
            &mut self.undone
        };
        to.push(stroke);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::edits::Edits;
    use glam::Vec2;
    use myxo::render::View;
    use myxo::scene::Scene;
    use myxo::scene::settings::Settings;
    use myxo::sim::paint::PaintedField;

    const TEXEL: Repainted = Repainted {
        field: PaintedField::Bias,
        texel: 0,
        before: 0.0,
        after: 1.0,
    };

    fn stroke(number: u64, texels: usize) -> Stroke {
        Stroke {
            number,
            changed: vec![TEXEL; texels],
            is_first: false,
        }
    }

    /// Which strokes go back (true) or come again on the way there.
    fn taken(strokes: &mut Strokes, last: u64) -> Vec<(u64, bool)> {
        let mut taken = Vec::new();
        while let Some((stroke, is_back)) = strokes.take_towards(last) {
            taken.push((stroke.number, is_back));
            strokes.put(stroke, !is_back);
        }
        taken
    }

    #[test]
    fn undo_leads_through_the_strokes_one_by_one() {
        let mut settings = Settings::default();
        let scene = Scene::from_settings("torus".to_owned(), settings.clone(), ".".into()).unwrap();
        let mut view = View::of(&scene, Vec2::ONE);
        let mut undo = Undo::new(&settings, &view);
        let mut strokes = Strokes::default();
        // Ends that have waited come one right after the other.
        for number in 1..=3_u64 {
            strokes.keep(&mut undo, vec![TEXEL; 3], number == 1);
            assert_eq!(undo.strokes(), number);
        }
        for number in [3_u64, 2, 1] {
            assert!(undo.undo(&mut settings, &mut view));
            assert_eq!(taken(&mut strokes, undo.strokes()), [(number, true)]);
        }
        assert!(!undo.can_undo());
        for number in 1..=2_u64 {
            assert!(undo.redo(&mut settings, &mut view));
            assert_eq!(taken(&mut strokes, undo.strokes()), [(number, false)]);
        }
        // A new stroke takes the place of the undone one.
        strokes.keep(&mut undo, vec![TEXEL; 3], false);
        assert!(!undo.can_redo() && undo.strokes() == 4);
        assert!(undo.undo(&mut settings, &mut view));
        assert_eq!(taken(&mut strokes, undo.strokes()), [(4, true)]);
        assert_eq!(undo.strokes(), 2);
        // A stroke that cannot be undone for want of memory is undone with the next one.
        assert!(undo.undo(&mut settings, &mut view));
        let (refused, is_back) = strokes.take_towards(undo.strokes()).unwrap();
        assert!(is_back);
        strokes.put(refused, true);
        assert!(undo.undo(&mut settings, &mut view));
        let both = [(2_u64, true), (1, true)];
        assert_eq!(taken(&mut strokes, undo.strokes()), both);
    }

    #[test]
    fn strokes_take_no_more_memory_than_is_counted() {
        let mut changed = Vec::with_capacity(1000);
        changed.push(TEXEL);
        let mut strokes = Strokes::default();
        strokes.push(Stroke {
            changed,
            ..stroke(1, 0)
        });
        assert!(strokes.done[0].changed.capacity() < 1000);
    }

    #[test]
    fn a_lost_device_ends_the_open_stroke() {
        let mut edits = Edits::default();
        edits.strokes.open = Some(Open {
            before: Some(Areas::default()),
            span: 0..0,
        });
        edits.leave_device();
        assert!(edits.strokes.open.is_none());
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
        // Strokes are dropped by their size, too; one that is too large leaves none, because those before it cannot be undone
        // without it.
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
