//! The device's times: the spans of finished frames.
//!
//! The recorder measures every dispatch, draw and copy, and every scope; all times are of the device's clock. A span
//! begins when all work before it is finished and ends when its own is, so spans of one depth do not overlap.

use std::collections::VecDeque;

/// The kind of work that a span measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpanKind {
    /// All that one frame recorded.
    Frame,
    /// [`Recorder::scope`](super::Recorder::scope)
    Scope,
    /// A dispatch.
    Kernel,
    /// A draw.
    Draw,
    /// A copy, fill or update.
    Copy,
}

/// One measured interval.
#[derive(Clone, Debug, PartialEq)]
pub struct Span {
    /// Name of the kernel or the scope; `frame` for a whole frame.
    pub name: String,
    /// The kind of work.
    pub kind: SpanKind,
    /// The span that it lies in, as an index into the frame's spans.
    pub parent: Option<usize>,
    /// Start, in nanoseconds of the device's clock since its first reading.
    pub begin_ns: f64,
    /// End, counted alike.
    pub end_ns: f64,
}

impl Span {
    /// Length in milliseconds.
    #[must_use]
    pub fn ms(&self) -> f64 {
        (self.end_ns - self.begin_ns) * 1e-6
    }

    pub(super) fn is_work(&self) -> bool {
        matches!(
            self.kind,
            SpanKind::Kernel | SpanKind::Draw | SpanKind::Copy
        )
    }
}

/// Spans of the frames that have finished, oldest first, at most the capacity.
#[derive(Clone, Debug)]
pub struct Timings {
    frames: VecDeque<Vec<Span>>,
    capacity: usize,
    /// If given, only frames with this scope count; of the others only the newest is kept.
    counted: Option<String>,
}

impl Default for Timings {
    fn default() -> Self {
        Self {
            frames: VecDeque::new(),
            capacity: 4096,
            counted: None,
        }
    }
}

impl Timings {
    /// The number of frames to remember; 4,096 at first.
    pub fn set_capacity(&mut self, frames: usize) {
        self.capacity = frames.max(1);
        self.shrink();
    }

    /// As [`set_capacity`](Self::set_capacity), counting frames in which this scope occurs. Of the other frames only the newest is kept,
    /// and only while it is the newest frame, so that they displace no others.
    pub fn set_capacity_of(&mut self, scope: &str, frames: usize) {
        self.counted = Some(scope.to_owned());
        if let Some(newest) = self.frames.pop_back() {
            self.frames.retain(|spans| has_scope(spans, scope));
            self.frames.push_back(newest);
        }
        self.set_capacity(frames);
    }

    /// Forgets all frames, as after a warm-up.
    pub fn clear(&mut self) {
        self.frames.clear();
    }

    /// The spans of each frame, oldest first; the first span of a frame is the frame itself.
    pub fn frames(&self) -> impl DoubleEndedIterator<Item = &[Span]> + ExactSizeIterator {
        self.frames.iter().map(Vec::as_slice)
    }

    /// The newest frame's length in milliseconds.
    #[must_use]
    pub fn last_frame_ms(&self) -> Option<f64> {
        self.frames.back()?.first().map(Span::ms)
    }

    /// Adds a finished frame. Parents come before their children.
    pub fn push(&mut self, spans: Vec<Span>) {
        if !spans.is_empty() {
            if self.newest_is_extra() {
                self.frames.pop_back();
            }
            self.frames.push_back(spans);
            self.shrink();
        }
    }

    /// Puts the frames of an earlier run before these; the capacity grows to hold all of them.
    pub fn prepend(&mut self, earlier: &Timings) {
        for spans in earlier.frames.iter().rev() {
            self.frames.push_front(spans.clone());
        }
        self.capacity = self.capacity.max(self.frames.len());
    }

    fn newest_is_extra(&self) -> bool {
        let (Some(scope), Some(newest)) = (&self.counted, self.frames.back()) else {
            return false;
        };
        !has_scope(newest, scope)
    }

    fn shrink(&mut self) {
        let most = self.capacity + usize::from(self.newest_is_extra());
        while self.frames.len() > most {
            self.frames.pop_front();
        }
    }
}

fn has_scope(spans: &[Span], scope: &str) -> bool {
    let mut scopes = spans.iter().filter(|span| span.kind == SpanKind::Scope);
    scopes.any(|span| span.name == scope)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn span(name: &str, kind: SpanKind, parent: Option<usize>, begin_ms: f64, end_ms: f64) -> Span {
        Span {
            name: name.to_owned(),
            kind,
            parent,
            begin_ns: begin_ms * 1e6,
            end_ns: end_ms * 1e6,
        }
    }

    #[test]
    fn a_report_groups_by_step_and_keeps_the_tree() {
        let mut timings = Timings::default();
        // One frame of two steps; the second has no `sort`.
        timings.push(vec![
            span("frame", SpanKind::Frame, None, 0.0, 20.0),
            span("step", SpanKind::Scope, Some(0), 0.0, 10.0),
            span("advance", SpanKind::Kernel, Some(1), 0.0, 4.0),
            span("blur", SpanKind::Scope, Some(1), 4.0, 9.0),
            span("diffuse", SpanKind::Kernel, Some(3), 4.0, 5.0),
            span("diffuse", SpanKind::Kernel, Some(3), 5.0, 7.0),
            span("sort", SpanKind::Kernel, Some(1), 9.0, 10.0),
            span("step", SpanKind::Scope, Some(0), 10.0, 20.0),
            span("advance", SpanKind::Kernel, Some(7), 10.0, 16.0),
        ]);
        let report = timings.report("step");
        assert_eq!(report.steps, 2);
        assert_eq!(report.step.mean_ms, 10.0);
        let rows: Vec<_> = report
            .rows
            .iter()
            .map(|r| {
                (
                    r.name.as_str(),
                    r.dispatches_per_step,
                    r.time.mean_ms,
                    r.share,
                )
            })
            .collect();
        assert_eq!(
            rows,
            [
                ("advance", 1.0, 5.0, 0.5),
                ("diffuse", 1.0, 1.5, 0.15),
                ("sort", 0.5, 0.5, 0.05)
            ]
        );
        let tree: Vec<_> = report
            .tree
            .iter()
            .map(|n| (n.name.as_str(), n.depth))
            .collect();
        assert_eq!(
            tree,
            [("advance", 0), ("blur", 0), ("diffuse", 1), ("sort", 0)]
        );
        assert_eq!(timings.report("frame").step.mean_ms, 20.0);
        assert!(timings.report("no such scope").is_empty());
    }

    #[test]
    fn the_oldest_frames_are_forgotten() {
        let mut timings = Timings::default();
        timings.set_capacity(2);
        for ms in [100.0, 1.0, 3.0] {
            timings.push(vec![span("frame", SpanKind::Frame, None, 0.0, ms)]);
        }
        assert_eq!(timings.report("frame").step.mean_ms, 2.0);
        let mut later = Timings::default();
        later.set_capacity(1);
        later.push(vec![span("frame", SpanKind::Frame, None, 0.0, 5.0)]);
        later.prepend(&timings);
        let lengths: Vec<f64> = later.frames().map(|spans| spans[0].ms()).collect();
        assert_eq!(lengths, [1.0, 3.0, 5.0]);
        assert_eq!(timings.last_frame_ms(), Some(3.0));
    }

    #[test]
    fn frames_without_a_step_push_out_none_with_steps() {
        let with_step = |ms: f64| {
            vec![
                span("frame", SpanKind::Frame, None, 0.0, ms),
                span("step", SpanKind::Scope, Some(0), 0.0, ms),
            ]
        };
        let without = |ms: f64| vec![span("frame", SpanKind::Frame, None, 0.0, ms)];
        let mut timings = Timings::default();
        timings.push(without(50.0));
        timings.push(with_step(100.0));
        timings.set_capacity_of("step", 2);
        for ms in [1.0, 3.0] {
            timings.push(without(7.0));
            timings.push(with_step(ms));
        }
        for ms in 10..20 {
            timings.push(without(f64::from(ms)));
            assert_eq!(timings.report("step").steps, 2);
            assert_eq!(timings.report("step").step.mean_ms, 2.0);
            assert_eq!(timings.last_frame_ms(), Some(f64::from(ms)), "the newest");
        }
        timings.push(with_step(5.0));
        let lengths: Vec<f64> = timings.frames().map(|spans| spans[0].ms()).collect();
        assert_eq!(lengths, [3.0, 5.0]);
    }
}
