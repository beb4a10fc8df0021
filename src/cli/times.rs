//! Kernel times as a table for people and as rows of the report.

use std::fmt::Write as _;

use myxo::gpu;
use myxo::sim::Setup;

use super::report::{KernelTime, Throughput};

/// What a kernel works on, and how many of them there are in a step in which it is dispatched so often. Each particle
/// advances once, however many turns objects have; `advancing` of them were measured, if that is known.
fn work_of(
    kernel: &str,
    dispatches: f64,
    setup: &Setup,
    advancing: Option<u64>,
) -> Option<(f64, &'static str)> {
    let (each, of) = match kernel {
        "advance" => return Some((advancing? as f64, "particles")),
        "diffuse" => (u64::from(setup.atlas.owned_count), "texels"),
        "diffuse_seams" => (setup.atlas.exchange.rows.len() as u64, "seam texels"),
        "exchange_seams" => (setup.atlas.seams.len() as u64, "gutter texels"),
        _ => return None,
    };
    Some((each as f64 * dispatches, of))
}

/// The rows of the report, of steps in which so many particles advance, if that is known.
pub fn rows(report: &gpu::Report, setup: &Setup, advancing: Option<u64>) -> Vec<KernelTime> {
    let throughput = |row: &gpu::Row| {
        let (count, of) = work_of(&row.name, row.dispatches_per_step, setup, advancing)?;
        let seconds = row.time.median_ms * 1e-3;
        (seconds > 0.0).then(|| Throughput {
            of: of.to_owned(),
            per_second: count / seconds,
        })
    };
    report
        .rows
        .iter()
        .map(|row| KernelTime {
            name: row.name.clone(),
            dispatches_per_step: row.dispatches_per_step,
            mean_ms: Some(row.time.mean_ms),
            median_ms: Some(row.time.median_ms),
            p95_ms: Some(row.time.p95_ms),
            share: Some(row.share),
            throughput: throughput(row),
        })
        .collect()
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
    /// One kernel alone.
    Kernel,
}

/// The table: kernel, dispatches a step, mean, median, 95th percentile, share, throughput; the whole step; and how
/// much of it the kernels account for.
pub fn table(report: &gpu::Report, setup: &Setup, advancing: Option<u64>, run: Run) -> String {
    // A kernel alone is no part of anything.
    let share = if run == Run::Kernel { "" } else { "share" };
    let header = [
        "kernel",
        "per step",
        "mean ms",
        "median ms",
        "p95 ms",
        share,
        "throughput",
    ];
    let step = &report.step;
    // Enough digits to tell kernels apart, whatever the device's speed.
    let decimals = if step.mean_ms < 1.0 { 4 } else { 3 };
    let milliseconds = |ms: f64| format!("{ms:.decimals$}");
    let mut cells = vec![header.map(str::to_owned)];
    let rows = rows(report, setup, advancing);
    for (row, times) in rows.iter().zip(&report.rows) {
        let throughput = row.throughput.as_ref();
        cells.push([
            row.name.clone(),
            short_count(row.dispatches_per_step),
            milliseconds(times.time.mean_ms),
            milliseconds(times.time.median_ms),
            milliseconds(times.time.p95_ms),
            match run {
                Run::Step => format!("{:.1} %", 100.0 * times.share),
                Run::Kernel => String::new(),
            },
            throughput.map_or(String::new(), |throughput| {
                format!("{}{}/s", short(throughput.per_second), throughput.of)
            }),
        ]);
    }
    if run == Run::Kernel {
        let mut text = aligned(&cells, None);
        let _ = writeln!(
            text,
            "GPU time of {}, nothing else between them.",
            counted(report.steps, "run")
        );
        return text;
    }
    cells.push([
        "whole step".to_owned(),
        String::new(),
        milliseconds(step.mean_ms),
        milliseconds(step.median_ms),
        milliseconds(step.p95_ms),
        String::new(),
        format!("{}steps/s", short(1e3 / step.median_ms)),
    ]);
    let sum: f64 = report.rows.iter().map(|row| row.time.mean_ms).sum();
    let mut text = aligned(&cells, Some(cells.len() - 1));
    let _ = writeln!(
        text,
        "GPU time of {}; the kernels account for {:.1} % of it, the rest lies between them.",
        counted(report.steps, "step"),
        100.0 * sum / step.mean_ms
    );
    text
}

/// Columns two blanks apart, the first flush left, the others flush right, none that is empty; a rule below the header, and one above row
/// number `ruled`.
fn aligned<const N: usize>(rows: &[[String; N]], ruled: Option<usize>) -> String {
    let widths: [usize; N] =
        std::array::from_fn(|i| rows.iter().map(|row| row[i].len()).max().unwrap_or(0));
    let columns = widths.iter().filter(|width| **width > 0).count();
    let rule = "─".repeat(widths.iter().sum::<usize>() + 2 * columns.saturating_sub(1));
    let mut text = String::new();
    for (number, row) in rows.iter().enumerate() {
        if number == 1 || ruled == Some(number) {
            let _ = writeln!(text, "{rule}");
        }
        let mut line = format!("{:<width$}", row[0], width = widths[0]);
        for (cell, width) in row
            .iter()
            .zip(widths)
            .skip(1)
            .filter(|(_, width)| *width > 0)
        {
            let _ = write!(line, "  {cell:>width$}");
        }
        let _ = writeln!(text, "{}", line.trim_end());
    }
    text
}

/// `1 step`, `2 steps`.
fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// `1`, or `0.25` for a kernel of every fourth step.
fn short_count(count: f64) -> String {
    let text = format!("{count:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Three digits and a prefix, to be followed by what is counted: `12.3 M `.
fn short(value: f64) -> String {
    let (scaled, prefix) = match value {
        v if v >= 1e9 => (v * 1e-9, "G "),
        v if v >= 1e6 => (v * 1e-6, "M "),
        v if v >= 1e3 => (v * 1e-3, "k "),
        v => (v, ""),
    };
    let decimals = match scaled {
        s if s < 9.995 => 2,
        s if s < 99.95 => 1,
        _ => 0,
    };
    format!("{scaled:.decimals$} {prefix}")
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
    fn throughput_is_short() {
        assert_eq!(short(9_340_000.0), "9.34 M ");
        assert_eq!(short(123_400.0), "123 k ");
        assert_eq!(short(99_960.0), "100 k ");
        assert_eq!(short(2.5e9), "2.50 G ");
        assert_eq!(short(70.0), "70.0 ");
    }

    #[test]
    fn numbers_stand_flush_right_between_two_rules() {
        let row = |a: &str, b: &str| [a.to_owned(), b.to_owned()];
        let rows = [
            row("kernel", "ms"),
            row("advance", "10.500"),
            row("sort", ""),
            row("whole", "12.000"),
        ];
        let expected = "\
kernel       ms
───────────────
advance  10.500
sort
───────────────
whole    12.000
";
        assert_eq!(aligned(&rows, Some(3)), expected);
    }

    #[test]
    fn rare_kernels_have_fractions() {
        assert_eq!(short_count(1.0), "1");
        assert_eq!(short_count(0.25), "0.25");
        assert_eq!(short_count(10.0), "10");
    }
}
