//! The parts of suites: cases to measure, measured points, and the results as JSON and as a table.

use std::collections::BTreeMap;

use myxo::Result;
use myxo::scene::Settings;
use myxo::scene::parameters::grouped;
use myxo::sim::memory::human;
use myxo::sim::sorting::SORT_INTERVAL;
use serde::Serialize;

use super::plot::{Dot, Line, Plot};
use crate::cli::host::HostLoad;
use crate::cli::report::{Bandwidth, KernelTime, Times};
use crate::cli::table::aligned;

/// How much is measured.
#[derive(Clone, Debug)]
pub struct Extent {
    /// A few minutes for all suites together.
    pub is_quick: bool,
    /// Cases further out on the suite's axis are left out.
    pub up_to: f64,
    /// `KEY=VALUE`: overrides what suites set, but not what they vary.
    pub set: Vec<String>,
}

impl Extent {
    /// The shorter or the longer one of two.
    pub fn of<T>(&self, quick: T, whole: T) -> T {
        if self.is_quick { quick } else { whole }
    }
}

/// A family of measurements along one axis.
pub struct Suite {
    pub name: &'static str,
    /// The question that it answers, in words.
    pub about: &'static str,
    /// What the axis counts.
    pub axis: &'static str,
    /// What the whole time of a point measures.
    pub whole: &'static str,
    /// Parts with a column in the table.
    pub parts: &'static [&'static str],
    /// Warm-up steps, which are not measured.
    pub warmup: u32,
    pub work: Work,
    pub plots: fn(&[Point]) -> Vec<Plot>,
}

/// How its cases are measured.
pub enum Work {
    /// Steps of scenes, on the device.
    Scenes(fn(&Extent) -> Result<Vec<Case>>),
    /// Geometry, on the host.
    Meshes,
}

/// A scene that is to be measured.
#[derive(Clone, Debug)]
pub struct Case {
    /// Cases of one series are joined by a line.
    pub series: String,
    /// Its value on the axis.
    pub x: f64,
    /// Its other varied values, for the table and for plots.
    pub also: BTreeMap<&'static str, f64>,
    pub settings: Settings,
    /// The count with which the time of a step grows at most. From it and the case before in the series follows whether the case would take
    /// too long.
    pub effort: f64,
}

impl Case {
    /// A name for messages: `auto, 10,000`.
    pub fn name(&self) -> String {
        let also = also_text(&self.also);
        format!("{}, {}{also}", self.series, grouped(self.x))
    }
}

fn also_text(also: &BTreeMap<&'static str, f64>) -> String {
    let all = also.iter();
    all.map(|(what, value)| format!(", {what} {}", grouped(*value)))
        .collect()
}

/// A case that was measured.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Point {
    pub series: String,
    pub x: f64,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub also: BTreeMap<&'static str, f64>,
    pub particles: u64,
    /// Texels along a side.
    pub atlas_size: u32,
    pub triangles: u64,
    pub objects: usize,
    /// Of the device.
    pub memory_bytes: u64,
    /// Warm-up steps in each run.
    pub warmup: u32,
    /// Steps measured in all runs together.
    pub steps: usize,
    /// At how many of the 16 positions in the interval between two sorts steps were measured; 0 if particles are not sorted.
    pub sort_places: usize,
    /// The median of each run; each run restarts.
    pub runs_ms: Vec<f64>,
    /// Of the whole.
    pub time: Times,
    /// The times of its parts.
    pub parts: Vec<KernelTime>,
    /// The time between kernels in the mean step; on the device only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub between_kernels_ms: Option<f64>,
}

impl Point {
    /// The whole time as a point of a plot.
    pub fn whole(&self) -> Dot {
        self.dot([self.time])
    }

    /// The sum of some parts as a point of a plot.
    pub fn parts(&self, names: &[&str]) -> Dot {
        let parts = self.parts.iter();
        self.dot(
            parts
                .filter(|part| names.contains(&part.name.as_str()))
                .map(KernelTime::in_each_step),
        )
    }

    /// Medians are added, and so are the ends of their intervals, which makes the interval wider than that of the sum. Kernels that not
    /// every step has count by their mean.
    fn dot(&self, times: impl IntoIterator<Item = Times>) -> Dot {
        let mut dot = Dot {
            x: self.x,
            y: 0.0,
            low: 0.0,
            high: 0.0,
        };
        let known = |time: Times| time.interval().or(time.mean_ms.map(|mean| [mean; 3]));
        for [median, low, high] in times.into_iter().filter_map(known) {
            dot.y += median;
            dot.low += low;
            dot.high += high;
        }
        dot
    }
}

/// The lines of a plot: one for each series that `choose` accepts, with the heights that `value` returns.
pub fn lines(
    points: &[Point],
    choose: impl Fn(&Point) -> bool,
    name: impl Fn(&Point) -> String,
    value: impl Fn(&Point) -> Dot,
) -> Vec<Line> {
    let mut lines: Vec<Line> = Vec::new();
    for point in points.iter().filter(|point| choose(point)) {
        let name = name(point);
        let dot = value(point);
        match lines.iter_mut().find(|line| line.name == name) {
            Some(line) => line.points.push(dot),
            None => lines.push(Line {
                name,
                points: vec![dot],
            }),
        }
    }
    for line in &mut lines {
        line.points.sort_by(|a, b| a.x.total_cmp(&b.x));
    }
    lines
}

/// A case that was not measured.
#[derive(Clone, Debug, Serialize)]
pub struct Skipped {
    pub case: String,
    pub why: String,
}

/// All results of a suite.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Results {
    pub suite: &'static str,
    pub about: &'static str,
    pub axis: &'static str,
    pub whole: &'static str,
    pub command: String,
    pub version: String,
    pub commit: Option<String>,
    /// `null` for suites on the host.
    pub device: Option<String>,
    pub driver: Option<String>,
    pub processor: Option<String>,
    pub load_average: Option<[f64; 3]>,
    pub host_load: HostLoad,
    pub copy_bandwidth: Option<Bandwidth>,
    pub quick: bool,
    /// Runs of each case, each from the beginning.
    pub runs: u32,
    /// Warm-up steps of each run; points have their own number where there were fewer.
    pub warmup: u32,
    pub interrupted: bool,
    /// How times were taken.
    pub method: String,
    pub points: Vec<Point>,
    pub skipped: Vec<Skipped>,
    /// The plots beside this file, as SVG; the same as PNG are there too.
    pub plots: Vec<String>,
}

impl Results {
    /// As JSON text in one line: there are many numbers.
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).expect("results are plain numbers and texts") + "\n"
    }

    /// As text: the device and version, the table, and the cases that were left out.
    pub fn text(&self, parts: &[&str]) -> String {
        let mut head = vec![format!("{}: {}", self.suite, self.about)];
        if let (Some(device), Some(driver)) = (&self.device, &self.driver) {
            head.push(format!("device {device}, driver {driver}"));
        }
        let unknown = || "unknown".to_owned();
        let load = self.load_average.map_or_else(unknown, |[one, five, _]| {
            format!("{one:.2} and {five:.2} (1 and 5 minutes)")
        });
        head.push(format!(
            "processor {}, load {load}",
            self.processor.clone().unwrap_or_else(unknown)
        ));
        head.push(format!(
            "version {}, commit {}, command {}",
            self.version,
            self.commit.clone().unwrap_or_else(unknown),
            self.command
        ));
        head.push(self.method.clone());
        let mut text = head.join("\n") + "\n\n" + &self.table(parts);
        for point in self.points.iter().filter(|p| p.warmup < self.warmup) {
            text += &format!(
                "warmed up by {} steps only, for want of time: {}, {}\n",
                point.warmup,
                point.series,
                grouped(point.x)
            );
        }
        text += &self.unlike_sorts();
        for Skipped { case, why } in &self.skipped {
            text += &format!("left out: {case}: {why}\n");
        }
        text
    }

    /// Warnings about points whose steps do not cover a whole interval between sorts, and so leave out the slowest ones.
    fn unlike_sorts(&self) -> String {
        let places = SORT_INTERVAL as usize;
        let parted = self.points.iter();
        let parted = parted.filter(|point| (1..places).contains(&point.sort_places));
        let line = |point: &Point| {
            format!(
                "measured at {} of {places} places between two sorts only, for want of time: {}, {}{}\n",
                point.sort_places,
                point.series,
                grouped(point.x),
                also_text(&point.also)
            )
        };
        parted.map(line).collect()
    }

    fn table(&self, parts: &[&str]) -> String {
        let also: Vec<&str> = match self.points.first() {
            Some(point) => point.also.keys().copied().collect(),
            None => return "Nothing was measured.\n".to_owned(),
        };
        let on_device = self.device.is_some();
        let owned = |texts: &[&str]| texts.iter().map(|text| (*text).to_owned()).collect();
        let mut header: Vec<String> = owned(&["series", self.axis]);
        header.extend(owned(&also));
        header.extend(owned(&["median ms", "interval", "p95", "runs", "steps"]));
        header.extend(owned(parts));
        // On the device parts are kernels, some of which have no column; on the host the parts are the whole.
        let has_rest = on_device && !parts.is_empty();
        header.extend(owned(if has_rest { &["other"] } else { &[] }));
        let has_between = self.points.iter().any(|p| p.between_kernels_ms.is_some());
        header.extend(owned(if has_between { &["between"] } else { &[] }));
        header.extend(owned(if on_device { &["memory"] } else { &[] }));
        let mut rows: Vec<Vec<String>> = vec![header];
        for point in &self.points {
            let ms = |ms: Option<f64>| ms.map_or("-".to_owned(), milliseconds);
            let time = &point.time;
            let interval = format!("{} - {}", ms(time.median_low_ms), ms(time.median_high_ms));
            let mut row = vec![point.series.clone(), grouped(point.x)];
            row.extend(also.iter().map(|what| grouped(point.also[what])));
            row.extend([
                ms(time.median_ms),
                interval,
                ms(time.p95_ms),
                point.runs_ms.len().to_string(),
                point.steps.to_string(),
            ]);
            row.extend(parts.iter().map(|part| match point.parts(&[part]).y {
                0.0 => "-".to_owned(),
                median => milliseconds(median),
            }));
            if has_rest {
                let others = point.parts.iter().map(|part| part.name.as_str());
                let others: Vec<&str> = others.filter(|name| !parts.contains(name)).collect();
                row.push(milliseconds(point.parts(&others).y));
            }
            if has_between {
                row.push(ms(point.between_kernels_ms));
            }
            if on_device {
                row.push(human(point.memory_bytes));
            }
            rows.push(row);
        }
        aligned(&rows, None)
    }
}

/// Three digits or so.
fn milliseconds(ms: f64) -> String {
    let decimals = match ms {
        _ if ms >= 99.95 => 0,
        _ if ms >= 9.995 => 1,
        _ if ms >= 0.0995 => 2,
        _ => 4,
    };
    format!("{ms:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(series: &str, x: f64, median: f64) -> Point {
        let time = Times {
            median_ms: Some(median),
            median_low_ms: Some(0.5 * median),
            median_high_ms: Some(2.0 * median),
            ..Times::default()
        };
        let part = |name: &str| KernelTime {
            name: name.to_owned(),
            time,
            ..KernelTime::default()
        };
        Point {
            series: series.to_owned(),
            x,
            time,
            parts: vec![part("advance"), part("diffuse")],
            ..Point::default()
        }
    }

    #[test]
    fn lines_are_those_of_series_in_the_order_of_the_axis() {
        let points = [
            point("a", 2.0, 4.0),
            point("b", 1.0, 3.0),
            point("a", 1.0, 1.0),
        ];
        let all = lines(
            &points,
            |_| true,
            |point| point.series.clone(),
            Point::whole,
        );
        assert_eq!(all.len(), 2);
        let heights: Vec<f64> = all[0].points.iter().map(|dot| dot.y).collect();
        assert_eq!((all[0].name.as_str(), heights), ("a", vec![1.0, 4.0]));
        let both = points[0].parts(&["advance", "diffuse", "sort"]);
        assert_eq!((both.y, both.low, both.high), (8.0, 4.0, 16.0));
        assert_eq!(points[0].parts(&["sort"]).y, 0.0);
    }

    #[test]
    fn parts_without_a_column_are_in_the_rest() {
        let mut point = point("a", 1.0, 8.0);
        point.parts[0].time.median_ms = Some(3.0);
        point.parts[1].time.median_ms = Some(1.5);
        point.between_kernels_ms = Some(3.5);
        let results = |device: Option<&str>| Results {
            device: device.map(str::to_owned),
            points: vec![point.clone()],
            ..Results::default()
        };
        let table = results(Some("abacus")).table(&["advance"]);
        let words: Vec<&str> = table.split_whitespace().collect();
        for columns in [["advance", "other", "between"], ["3.00", "1.50", "3.50"]] {
            assert!(words.windows(3).any(|words| words == columns), "{table}");
        }
        point.between_kernels_ms = None;
        let results = |device: Option<&str>| Results {
            device: device.map(str::to_owned),
            points: vec![point.clone()],
            ..Results::default()
        };
        let table = results(None).table(&["advance"]);
        assert!(!table.contains("other"), "{table}");
        let table = results(Some("abacus")).table(&[]);
        assert!(!table.contains("other"), "{table}");
    }

    #[test]
    fn part_of_an_interval_between_sorts_gives_a_warning() {
        let of = |sort_places| Results {
            points: vec![Point {
                sort_places,
                ..point("auto", 1e6, 8.0)
            }],
            ..Results::default()
        };
        for whole in [0, 16] {
            assert_eq!(of(whole).unlike_sorts(), "");
        }
        assert_eq!(
            of(9).unlike_sorts(),
            "measured at 9 of 16 places between two sorts only, for want of time: auto, 1,000,000\n"
        );
    }

    #[test]
    fn times_have_as_many_digits_as_they_are_worth() {
        let texts = [0.0123, 0.5, 9.99, 10.0, 123.4].map(milliseconds);
        assert_eq!(texts, ["0.0123", "0.50", "9.99", "10.0", "123"]);
    }
}
