//! Statistics over many steps: the time of each kernel, and the nesting of scopes.

use super::timer::{Span, Timings};

/// Mean and spread of something over the steps of a report, in milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Statistics {
    /// Arithmetic mean.
    pub mean_ms: f64,
    /// Half of the steps took no longer.
    pub median_ms: f64,
    /// 95 of 100 steps took no longer.
    pub p95_ms: f64,
    /// Standard deviation of the steps, as of a sample; 0 for a single one.
    pub std_ms: f64,
    /// The fastest step.
    pub min_ms: f64,
    /// The slowest step.
    pub max_ms: f64,
    /// With [`Statistics::median_high_ms`]: the 95 % confidence interval of the median, for independent steps. See [`Statistics::of`].
    pub median_low_ms: f64,
    /// The upper end of it.
    pub median_high_ms: f64,
}

/// One kernel of a report.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Name of the kernel.
    pub name: String,
    /// Dispatches in a step, on average.
    pub dispatches_per_step: f64,
    /// Steps that have any.
    pub steps: usize,
    /// Time per step in all of them. The mean is over all steps, so that kernels add up to the step; the other statistics are over
    /// steps that have any.
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

/// Statistics over all steps that are remembered. Empty where the device has no timestamps.
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
    /// Adds a frame, whose parents come before their children.
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
                let own_steps = row.times.len();
                let mut time = Statistics::of(row.times.into_iter().map(|(_, ms)| ms).collect());
                time.mean_ms *= own_steps as f64 / steps as f64;
                let share = if step.mean_ms > 0.0 {
                    time.mean_ms / step.mean_ms
                } else {
                    0.0
                };
                let dispatches_per_step = row.count as f64 / steps as f64;
                Row {
                    name: row.name.to_owned(),
                    dispatches_per_step,
                    steps: own_steps,
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

impl Timings {
    /// Statistics where a step is one occurrence of the scope or frame called `step`: `"frame"` for whole frames,
    /// or the name of the scope around each step if a frame holds several.
    #[must_use]
    pub fn report(&self, step: &str) -> Report {
        let mut collector = Collector::default();
        for spans in self.frames() {
            collector.frame(spans, step);
        }
        collector.finish()
    }
}

impl Statistics {
    /// The statistics of samples in milliseconds; zeros for none.
    ///
    /// The interval of the median is between two samples, by rank, and assumes nothing about the distribution of samples: how many of `n`
    /// lie below the true median is binomial, about `n / 2 +- 1.96 * sqrt(n) / 2`. Of fewer than six it is all of them.
    #[must_use]
    pub fn of(mut samples: Vec<f64>) -> Self {
        if samples.is_empty() {
            return Self::default();
        }
        samples.sort_by(f64::total_cmp);
        let n = samples.len();
        let count = n as f64;
        let mean_ms = samples.iter().sum::<f64>() / count;
        let squares: f64 = samples.iter().map(|ms| (ms - mean_ms).powi(2)).sum();
        // Nearest rank: the smallest sample that 95 % of all do not exceed.
        let p95 = (n * 95).div_ceil(100) - 1;
        let below = ((count - 1.96 * count.sqrt()) / 2.0).floor().max(1.0) as usize - 1;
        Self {
            mean_ms,
            median_ms: (samples[(n - 1) / 2] + samples[n / 2]) / 2.0,
            p95_ms: samples[p95],
            std_ms: (squares / (count - 1.0).max(1.0)).sqrt(),
            min_ms: samples[0],
            max_ms: samples[n - 1],
            median_low_ms: samples[below],
            median_high_ms: samples[n - 1 - below],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::timer::SpanKind;

    /// A kernel runs twice in every fourth step: kernels add up to the step, and its median is over the steps with it.
    #[test]
    fn rare_kernels_have_statistics_of_the_steps_that_have_them() {
        let span = |name: &str, kind, parent, begin_ns: f64, end_ns: f64| Span {
            name: name.to_owned(),
            kind,
            parent,
            begin_ns,
            end_ns,
        };
        let frame = |number: u32| {
            let scope = |name: &str, parent| span(name, SpanKind::Scope, parent, 0.0, 5e6);
            let kernel = |name: &str, begin, end| span(name, SpanKind::Kernel, Some(1), begin, end);
            let mut spans = vec![scope("frame", None), scope("step", Some(0))];
            spans.push(kernel("often", 0.0, 3e6));
            if number.is_multiple_of(4) {
                let half = 5e5 * f64::from(1 + number / 4);
                spans.push(kernel("rare", 3e6, 3e6 + half));
                spans.push(kernel("rare", 4e6, 4e6 + half));
            }
            spans
        };
        let frames: Vec<Vec<Span>> = (0..8).map(frame).collect();
        let mut collector = Collector::default();
        for frame in &frames {
            collector.frame(frame, "step");
        }
        let report = collector.finish();
        let [often, rare] = &report.rows[..] else {
            panic!("{:?}", report.rows)
        };
        assert_eq!((often.steps, often.time.mean_ms), (8, 3.0));
        assert_eq!((rare.steps, rare.dispatches_per_step), (2, 0.5));
        // One step with 1 ms of it, and one with 2.
        let time = rare.time;
        assert_eq!((time.min_ms, time.median_ms, time.max_ms), (1.0, 1.5, 2.0));
        assert_eq!((time.mean_ms, rare.share), (3.0 / 8.0, 3.0 / 40.0));
    }

    #[test]
    fn statistics_know_mean_median_and_spread() {
        let of = Statistics::of((1..=100).rev().map(f64::from).collect());
        assert!((of.std_ms - (100.0_f64 * 101.0 / 12.0).sqrt()).abs() < 1e-9);
        assert_eq!(
            of,
            Statistics {
                mean_ms: 50.5,
                median_ms: 50.5,
                p95_ms: 95.0,
                std_ms: of.std_ms,
                min_ms: 1.0,
                max_ms: 100.0,
                // Binomial(100, 1/2) is 40 to 60 in 95 % of all cases.
                median_low_ms: 40.0,
                median_high_ms: 61.0,
            }
        );
        assert_eq!(
            Statistics::of(vec![3.0]),
            Statistics {
                mean_ms: 3.0,
                median_ms: 3.0,
                p95_ms: 3.0,
                std_ms: 0.0,
                min_ms: 3.0,
                max_ms: 3.0,
                median_low_ms: 3.0,
                median_high_ms: 3.0,
            }
        );
        let few = Statistics::of(vec![5.0, 1.0, 2.0, 4.0, 3.0]);
        assert_eq!((few.median_low_ms, few.median_high_ms), (1.0, 5.0));
        assert_eq!(Statistics::of(Vec::new()), Statistics::default());
    }
}
