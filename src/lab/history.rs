//! Recent times of each kernel, step by step.

use std::collections::VecDeque;

use myxo::gpu::{Span, SpanKind};

/// Frames that are kept: some seconds.
const KEPT: usize = 240;

/// Milliseconds a step of every kernel, for the last frames with steps in them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct History {
    names: Vec<String>,
    /// One value a name; names that came later have none in older ones.
    frames: VecDeque<Vec<f32>>,
}

impl History {
    /// Takes up what was measured in one frame; one without steps says nothing.
    pub fn push(&mut self, spans: &[Span]) {
        let mut steps = 0;
        // Which spans lie in a step, whatever scopes are between.
        let mut in_step = vec![false; spans.len()];
        let mut times = vec![0.0; self.names.len()];
        for (i, span) in spans.iter().enumerate() {
            let is_step = span.kind == SpanKind::Scope && span.name == "step";
            in_step[i] = is_step || span.parent.is_some_and(|parent| in_step[parent]);
            steps += u32::from(is_step);
            let is_work = !matches!(span.kind, SpanKind::Scope | SpanKind::Frame);
            if in_step[i] && is_work {
                let known = self.names.iter().position(|name| *name == span.name);
                let place = known.unwrap_or_else(|| {
                    self.names.push(span.name.clone());
                    times.push(0.0);
                    times.len() - 1
                });
                times[place] += span.ms() as f32;
            }
        }
        if steps > 0 {
            times.iter_mut().for_each(|time| *time /= steps as f32);
            self.frames.push_back(times);
            if self.frames.len() > KEPT {
                self.frames.pop_front();
            }
        }
    }

    /// The time that all kernels together do not exceed in 95 % of the frames, milliseconds a step. The first frames of a run,
    /// which compile kernels, are beyond it.
    pub fn usual(&self) -> f64 {
        let mut sums: Vec<f64> = self.sums(&|_| true).collect();
        sums.sort_by(f64::total_cmp);
        let last = sums.len().saturating_sub(1);
        sums.get(last * 95 / 100).copied().unwrap_or_default()
    }

    /// How many frames are kept.
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// The time that the steps of each picture took in these kernels together, from the oldest.
    pub fn sums<'a>(&'a self, among: &'a dyn Fn(&str) -> bool) -> impl Iterator<Item = f64> + 'a {
        let chosen: Vec<bool> = self.names.iter().map(|name| among(name)).collect();
        self.frames.iter().map(move |times| {
            let parts = times.iter().zip(&chosen).filter(|(_, chosen)| **chosen);
            parts.map(|(time, _)| f64::from(*time)).sum()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn span(name: &str, kind: SpanKind, parent: Option<usize>, ms: f64) -> Span {
        Span {
            name: name.to_owned(),
            kind,
            parent,
            begin_ns: 0.0,
            end_ns: 1e6 * ms,
        }
    }

    #[test]
    fn a_picture_is_the_mean_of_its_steps() {
        use SpanKind::{Draw, Frame, Kernel, Scope};
        let mut history = History::default();
        history.push(&[
            span("frame", Frame, None, 9.0),
            span("step", Scope, Some(0), 4.0),
            span("advance", Kernel, Some(1), 3.0),
            span("step", Scope, Some(0), 4.0),
            span("turn", Scope, Some(3), 4.0),
            span("advance", Kernel, Some(4), 1.0),
            span("sort", Kernel, Some(3), 2.0),
            span("surface", Draw, Some(0), 1.0),
        ]);
        history.push(&[
            span("frame", Frame, None, 9.0),
            span("surface", Draw, Some(0), 1.0),
        ]);
        assert_eq!(history.len(), 1, "without steps there is nothing to say");
        let of = |history: &History, name: &str| {
            history.sums(&|other| other == name).collect::<Vec<f64>>()
        };
        assert_eq!(of(&history, "advance"), [2.0]);
        assert_eq!(of(&history, "sort"), [1.0]);
        assert_eq!(of(&history, "surface"), [0.0]);
        history.push(&[
            span("step", Scope, None, 4.0),
            span("diffuse", Kernel, Some(0), 1.5),
        ]);
        assert_eq!(of(&history, "diffuse"), [0.0, 1.5]);
        history = History::default();
        for ms in [900.0].into_iter().chain([2.0; 99]) {
            let step = span("step", Scope, None, ms);
            history.push(&[step, span("diffuse", Kernel, Some(0), ms)]);
        }
        assert_eq!(history.usual(), 2.0, "one that compiled does not count");
        for _ in 0..2 * KEPT {
            history.push(&[span("step", Scope, None, 4.0)]);
        }
        assert_eq!(history.len(), KEPT);
    }
}
