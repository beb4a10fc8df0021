//! Where the device's time goes: the spans of finished frames, and statistics over many steps.
//!
//! The recorder measures every dispatch, draw and copy, and every scope; all times are of the device's clock. A span
//! begins when all work before it is finished and ends when its own is, so spans of one depth do not overlap.

use std::collections::VecDeque;

/// What a span measures.
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

/// One measured stretch.
#[derive(Clone, Debug, PartialEq)]
pub struct Span {
    /// Name of the kernel or the scope; `frame` for a whole frame.
    pub name: String,
    /// What it measures.
    pub kind: SpanKind,
    /// The span that it lies in, as an index into the frame's spans.
    pub parent: Option<usize>,
    /// Start, in nanoseconds of the device's clock.
    pub begin_ns: f64,
    /// End, in nanoseconds of the device's clock.
    pub end_ns: f64,
}

impl Span {
    /// Length in milliseconds.
    #[must_use]
    pub fn ms(&self) -> f64 {
        (self.end_ns - self.begin_ns) * 1e-6
    }

    fn is_work(&self) -> bool {
        matches!(
            self.kind,
            SpanKind::Kernel | SpanKind::Draw | SpanKind::Copy
        )
    }
}

/// Spans of the frames that have finished, oldest first, as many as the window holds.
#[derive(Clone, Debug)]
pub struct Timings {
    frames: VecDeque<Vec<Span>>,
    window: usize,
}

/// Mean and spread of something over the steps of a report, in milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Statistics {
    /// Arithmetic mean.
    pub mean_ms: f64,
    /// Half of the steps took no longer.
    pub median_ms: f64,
    /// 95 of 100 steps took no longer.
    pub p95_ms: f64,
    /// The fastest step.
    pub min_ms: f64,
}

/// One kernel of a report.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Name of the kernel.
    pub name: String,
    /// Dispatches in a step, on average.
    pub dispatches_per_step: f64,
    /// What a step spends in all of them.
    pub time: Statistics,
    /// Mean share of the step, 0 to 1.
    pub share: f64,
}

/// One scope or kernel of a report's tree.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Name of the scope or the kernel.
    pub name: String,
    /// 0 directly in the step.
    pub depth: usize,
    /// Occurrences in a step, on average.
    pub per_step: f64,
    /// Mean time a step, milliseconds.
    pub mean_ms: f64,
}

/// Statistics over all steps in the window. Empty where the device has no timestamps.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Steps that were measured.
    pub steps: usize,
    /// The whole step, gaps between kernels included.
    pub step: Statistics,
    /// Kernels, draws and copies, the longest first.
    pub rows: Vec<Row>,
    /// Scopes and kernels as they nest, in the order of their first occurrence.
    pub tree: Vec<Node>,
}

impl Report {
    /// Was nothing measured?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.steps == 0
    }
}

impl Default for Timings {
    fn default() -> Self {
        Self {
            frames: VecDeque::new(),
            window: 4096,
        }
    }
}

impl Timings {
    /// The number of frames to remember; 4,096 at first.
    pub fn set_window(&mut self, frames: usize) {
        self.window = frames.max(1);
        self.shrink();
    }

    /// Forgets all frames, as after a warm-up.
    pub fn clear(&mut self) {
        self.frames.clear();
    }

    /// The spans of each frame, oldest first; the first span of a frame is the frame itself.
    pub fn frames(&self) -> impl ExactSizeIterator<Item = &[Span]> {
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
            self.frames.push_back(spans);
            self.shrink();
        }
    }

    fn shrink(&mut self) {
        while self.frames.len() > self.window {
            self.frames.pop_front();
        }
    }

    /// Statistics where a step is one occurrence of the scope or frame called `step`: `"frame"` for whole frames,
    /// or the name of the scope that is put round each step where a frame holds several.
    #[must_use]
    pub fn report(&self, step: &str) -> Report {
        let mut collector = Collector::default();
        for spans in &self.frames {
            collector.frame(spans, step);
        }
        collector.finish()
    }
}

/// Sums up spans without copying names: a report is made for every picture of a window.
#[derive(Default)]
struct Collector<'a> {
    /// Length of each step.
    steps: Vec<f64>,
    rows: Vec<RowSums<'a>>,
    nodes: Vec<NodeSums<'a>>,
}

struct RowSums<'a> {
    name: &'a str,
    count: usize,
    /// Each step that had any, and its time.
    times: Vec<(usize, f64)>,
}

struct NodeSums<'a> {
    name: &'a str,
    /// An index into the nodes; `None` directly in the step.
    parent: Option<usize>,
    count: usize,
    sum: f64,
}

impl<'a> Collector<'a> {
    fn frame(&mut self, spans: &'a [Span], step: &str) {
        // For each span: the number of its step, and its node; the step itself has none.
        let mut places: Vec<Option<(usize, Option<usize>)>> = Vec::with_capacity(spans.len());
        for span in spans {
            let place = match span.parent.and_then(|parent| places[parent]) {
                Some((number, parent)) => {
                    if span.is_work() {
                        self.add_to_row(number, span);
                    }
                    Some((number, Some(self.add_to_node(parent, span))))
                }
                None if span.name == step && !span.is_work() => {
                    self.steps.push(span.ms());
                    Some((self.steps.len() - 1, None))
                }
                None => None,
            };
            places.push(place);
        }
    }

    fn add_to_node(&mut self, parent: Option<usize>, span: &'a Span) -> usize {
        let found = self
            .nodes
            .iter()
            .position(|n| n.parent == parent && n.name == span.name);
        let index = found.unwrap_or(self.nodes.len());
        if found.is_none() {
            self.nodes.push(NodeSums {
                name: &span.name,
                parent,
                count: 0,
                sum: 0.0,
            });
        }
        self.nodes[index].count += 1;
        self.nodes[index].sum += span.ms();
        index
    }

    fn add_to_row(&mut self, number: usize, span: &'a Span) {
        let found = self.rows.iter().position(|row| row.name == span.name);
        let index = found.unwrap_or(self.rows.len());
        if found.is_none() {
            self.rows.push(RowSums {
                name: &span.name,
                count: 0,
                times: Vec::new(),
            });
        }
        let row = &mut self.rows[index];
        row.count += 1;
        match row.times.last_mut() {
            Some((step, ms)) if *step == number => *ms += span.ms(),
            _ => row.times.push((number, span.ms())),
        }
    }

    /// The nodes below `parent`, each followed by its own.
    fn tree(&self, parent: Option<usize>, depth: usize, tree: &mut Vec<Node>) {
        for (index, node) in self
            .nodes
            .iter()
            .enumerate()
            .filter(|(_, n)| n.parent == parent)
        {
            let steps = self.steps.len() as f64;
            tree.push(Node {
                name: node.name.to_owned(),
                depth,
                per_step: node.count as f64 / steps,
                mean_ms: node.sum / steps,
            });
            self.tree(Some(index), depth + 1, tree);
        }
    }

    fn finish(self) -> Report {
        let steps = self.steps.len();
        if steps == 0 {
            return Report::default();
        }
        let mut tree = Vec::with_capacity(self.nodes.len());
        self.tree(None, 0, &mut tree);
        let step = Statistics::of(self.steps);
        let mut rows: Vec<Row> = self
            .rows
            .into_iter()
            .map(|row| {
                let mut all = vec![0.0; steps];
                for (number, ms) in row.times {
                    all[number] = ms;
                }
                let time = Statistics::of(all);
                let share = if step.mean_ms > 0.0 {
                    time.mean_ms / step.mean_ms
                } else {
                    0.0
                };
                let dispatches_per_step = row.count as f64 / steps as f64;
                Row {
                    name: row.name.to_owned(),
                    dispatches_per_step,
                    time,
                    share,
                }
            })
            .collect();
        rows.sort_by(|a, b| b.time.mean_ms.total_cmp(&a.time.mean_ms));
        Report {
            steps,
            step,
            rows,
            tree,
        }
    }
}

impl Statistics {
    /// Of samples in milliseconds; zeros for none.
    #[must_use]
    pub fn of(mut samples: Vec<f64>) -> Self {
        if samples.is_empty() {
            return Self::default();
        }
        samples.sort_by(f64::total_cmp);
        let n = samples.len();
        let median_ms = (samples[(n - 1) / 2] + samples[n / 2]) / 2.0;
        // Nearest rank: the smallest sample that 95 % of all do not exceed.
        let p95 = (n * 95).div_ceil(100) - 1;
        Self {
            mean_ms: samples.iter().sum::<f64>() / n as f64,
            median_ms,
            p95_ms: samples[p95],
            min_ms: samples[0],
        }
    }
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
    fn statistics_know_mean_median_and_p95() {
        let of = Statistics::of((1..=100).rev().map(f64::from).collect());
        assert_eq!(
            of,
            Statistics {
                mean_ms: 50.5,
                median_ms: 50.5,
                p95_ms: 95.0,
                min_ms: 1.0
            }
        );
        assert_eq!(
            Statistics::of(vec![3.0]),
            Statistics {
                mean_ms: 3.0,
                median_ms: 3.0,
                p95_ms: 3.0,
                min_ms: 3.0
            }
        );
        assert_eq!(Statistics::of(Vec::new()), Statistics::default());
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
    fn the_window_forgets_the_oldest() {
        let mut timings = Timings::default();
        timings.set_window(2);
        for ms in [100.0, 1.0, 3.0] {
            timings.push(vec![span("frame", SpanKind::Frame, None, 0.0, ms)]);
        }
        assert_eq!(timings.report("frame").step.mean_ms, 2.0);
        assert_eq!(timings.last_frame_ms(), Some(3.0));
    }
}
