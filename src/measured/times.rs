//! Kernel times as a table for people and as rows of the report.

use std::fmt::Write as _;

use myxo::gpu;
use myxo::plain_text::counted;
use myxo::sim::sorting::Segments;
use myxo::sim::{FORMS_OF_ADVANCE, Setup};

use super::report::{Bandwidth, KeptBusy, KernelTime, Throughput, Times};
use super::table::{aligned, short};
use super::work::work_of;

/// The facts that rows need besides times.
#[derive(Clone, Copy)]
pub struct Of<'a> {
    /// Of the scene.
    pub setup: &'a Setup,
    /// How particles are cut into segments, of which a step sorts one.
    pub segments: Segments,
    /// How many particles advance in the measured part, if that is known.
    pub advancing: Option<u64>,
    /// The speed of copies, if it was measured.
    pub bandwidth: Option<Bandwidth>,
    /// How long the device was kept busy first, if it was.
    pub kept_busy: Option<KeptBusy>,
}

/// How many particles advance in each step; `None` where their number changes, because only the device has it, and it is another one in each
/// of the measured steps.
pub fn all_advancing(setup: &Setup) -> Option<u64> {
    let is_constant = setup.population.is_none();
    is_constant.then_some(setup.particles.len() as u64)
}

/// The rows of the report.
pub fn rows(report: &gpu::Report, of: Of<'_>) -> Vec<KernelTime> {
    // For kernels that not every step has, the median is over the steps that have them.
    let of_a_step = |row: &gpu::Row| {
        if row.steps < report.steps {
            row.time.mean_ms
        } else {
            row.time.median_ms
        }
    };
    let row = |row: &gpu::Row| {
        let work = work_of(
            &row.name,
            row.dispatches_per_step,
            of.setup,
            of.segments,
            of.advancing,
        );
        let mut ms = of_a_step(row);
        if ["advance", "wish"].contains(&row.name.as_str()) {
            // All forms together process all particles: the others those that the first one lists.
            let listed = report.rows.iter();
            let listed = listed.filter(|row| FORMS_OF_ADVANCE[1..].contains(&row.name.as_str()));
            ms += listed.map(of_a_step).sum::<f64>();
        }
        let seconds = ms * 1e-3;
        let timed = work.filter(|_| seconds > 0.0);
        let gigabytes_per_second = timed.map(|work| work.bytes / seconds * 1e-9);
        KernelTime {
            name: row.name.clone(),
            dispatches_per_step: row.dispatches_per_step,
            of_steps: Some(row.steps as f64 / report.steps as f64),
            time: Times::from(&row.time),
            share: Some(row.share),
            throughput: timed.map(|work| Throughput {
                of: work.of.to_owned(),
                per_second: work.count / seconds,
            }),
            bytes_per_step: work.map(|work| work.bytes),
            gigabytes_per_second,
            of_copy_bandwidth: gigabytes_per_second
                .zip(of.bandwidth)
                .map(|(own, copy)| own / copy.gigabytes_per_second),
        }
    };
    report.rows.iter().map(row).collect()
}

/// Why there are no times, if there are none.
pub fn unavailable(report: &gpu::Report, has_timestamps: bool) -> Option<&'static str> {
    match (has_timestamps, report.is_empty()) {
        (false, _) => Some("the device has no timestamps"),
        (true, true) => Some("no step was measured"),
        (true, false) => None,
    }
}

/// What was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Run {
    /// All kernels of a step.
    Step,
    /// All kernels of a step, overlapping: none has a time of its own.
    Overlapping,
    /// One kernel alone.
    Kernel,
}

/// The part of a mean step between kernels.
pub fn between_kernels(report: &gpu::Report) -> f64 {
    let kernels: f64 = report.rows.iter().map(|row| row.time.mean_ms).sum();
    report.step.mean_ms - kernels
}

/// The table: kernel, dispatches a step, mean, median, 95th percentile, standard deviation, least and most, share, bytes,
/// throughput; what lies between kernels; the whole step; and what bytes are compared with.
pub fn table(report: &gpu::Report, of: Of<'_>, run: Run) -> String {
    let step = &report.step;
    // Enough digits to distinguish kernels on fast devices, too.
    let decimals = if step.mean_ms < 1.0 { 4 } else { 3 };
    let mut cells = vec![header(run).map(str::to_owned)];
    let rows = match run {
        Run::Overlapping => Vec::new(),
        Run::Step | Run::Kernel => rows(report, of),
    };
    for (row, times) in rows.iter().zip(&report.rows) {
        cells.push(cells_of_kernel(row, times, run, decimals));
    }
    let is_rare = |row: &gpu::Row| row.steps < report.steps;
    let rare = if run == Run::Step && report.rows.iter().any(is_rare) {
        "Of kernels that not every step has the mean is over all steps, and all else over the steps that have them.\n"
    } else {
        ""
    };
    let notes = notes(of);
    if run == Run::Kernel {
        let mut text = aligned(&cells, None);
        let _ = writeln!(
            text,
            "GPU time of {}, nothing else between them.",
            counted(report.steps, "run", "runs")
        );
        return text + &notes;
    }
    if run == Run::Step {
        let between = between_kernels(report);
        cells.push(std::array::from_fn(|column| match column {
            0 => "between kernels".to_owned(),
            2 => milliseconds(between, decimals),
            8 => format!("{:.1} %", 100.0 * between / step.mean_ms),
            _ => String::new(),
        }));
    }
    cells.push(cells_of_step(step, decimals));
    let mut text = aligned(&cells, Some(cells.len() - 1));
    let steps = counted(report.steps, "step", "steps");
    if run == Run::Overlapping {
        let _ = writeln!(text, "GPU time of {steps}, whose kernels may overlap.");
        return text;
    }
    let _ = writeln!(text, "GPU time of {steps}.");
    text + rare + &notes
}

/// The titles of the columns; empty where one does not apply to the run.
fn header(run: Run) -> [&'static str; 12] {
    // A kernel alone has no share.
    let share = if run == Run::Step { "share" } else { "" };
    // These values do not apply to a whole step.
    let of_kernels = |title| if run == Run::Overlapping { "" } else { title };
    [
        of_kernels("kernel"),
        of_kernels("per step"),
        "mean ms",
        "median",
        "p95",
        "std",
        "min",
        "max",
        share,
        of_kernels("GB/s"),
        of_kernels("copy"),
        "throughput",
    ]
}

/// The cells of one kernel.
fn cells_of_kernel(row: &KernelTime, times: &gpu::Row, run: Run, decimals: usize) -> [String; 12] {
    let [mean, median, p95, std, min, max] = cells_of_times(&times.time, decimals);
    let throughput = row.throughput.as_ref();
    let or_blank = |text: Option<String>| text.unwrap_or_default();
    [
        row.name.clone(),
        short_count(row.dispatches_per_step),
        mean,
        median,
        p95,
        std,
        min,
        max,
        match run {
            Run::Step => format!("{:.1} %", 100.0 * times.share),
            Run::Overlapping | Run::Kernel => String::new(),
        },
        or_blank(row.gigabytes_per_second.map(|rate| format!("{rate:.2}"))),
        or_blank(
            row.of_copy_bandwidth
                .map(|part| format!("{:.0} %", 100.0 * part)),
        ),
        or_blank(throughput.map(|rate| format!("{}{}/s", short(rate.per_second), rate.of))),
    ]
}

/// The cells of the whole step.
fn cells_of_step(step: &gpu::Statistics, decimals: usize) -> [String; 12] {
    let [mean, median, p95, std, min, max] = cells_of_times(step, decimals);
    [
        "whole step".to_owned(),
        String::new(),
        mean,
        median,
        p95,
        std,
        min,
        max,
        String::new(),
        String::new(),
        String::new(),
        format!("{}steps/s", short(1e3 / step.median_ms)),
    ]
}

/// Mean, median, 95th percentile, standard deviation, least and most.
fn cells_of_times(time: &gpu::Statistics, decimals: usize) -> [String; 6] {
    [
        time.mean_ms,
        time.median_ms,
        time.p95_ms,
        time.std_ms,
        time.min_ms,
        time.max_ms,
    ]
    .map(|ms| milliseconds(ms, decimals))
}

fn milliseconds(ms: f64, decimals: usize) -> String {
    format!("{ms:.decimals$}")
}

/// What lies below the table: what bytes are compared with, and how long the device was kept busy.
fn notes(of: Of<'_>) -> String {
    let mut notes = of.bandwidth.map_or(String::new(), |copy| {
        format!(
            "GB/s: bytes that must be read and written; copy: as part of what copies get through, which is\n\
             {:.1} GB/s (copies of {} MiB by {}, median of {}).\n",
            copy.gigabytes_per_second,
            copy.size_in_bytes >> 20,
            if copy.by_kernel {
                "a kernel"
            } else {
                "the device"
            },
            copy.runs
        )
    });
    if let Some(kept) = of.kept_busy {
        let _ = writeln!(
            notes,
            "The device was kept busy for {:.1} s first{}.",
            kept.seconds,
            if kept.is_steady {
                ", until its times were steady"
            } else {
                ", and its times were not steady then: they may be those of a low clock"
            }
        );
    }
    notes
}

/// `1`, or `0.25` for a kernel of every fourth step.
fn short_count(count: f64) -> String {
    let text = format!("{count:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_times_have_a_reason() {
        let none = gpu::Report::default();
        let some = gpu::Report {
            steps: 1,
            ..gpu::Report::default()
        };
        assert_eq!(unavailable(&none, true), Some("no step was measured"));
        assert_eq!(
            unavailable(&none, false),
            Some("the device has no timestamps")
        );
        assert_eq!(unavailable(&some, true), None);
    }

    #[test]
    fn rare_kernels_have_fractions() {
        assert_eq!(short_count(1.0), "1");
        assert_eq!(short_count(0.25), "0.25");
        assert_eq!(short_count(10.0), "10");
    }
}
