//! Kernel times as a table for people and as rows of the report.

use comfy_table::presets::UTF8_HORIZONTAL_ONLY;
use comfy_table::{CellAlignment, Table};
use myxo::gpu;
use myxo::sim::Setup;

use super::report::KernelTime;

/// What one dispatch of a kernel works on, and how many of them there are.
fn work_of(kernel: &str, setup: &Setup) -> Option<(u64, &'static str)> {
    match kernel {
        "advance" => Some((setup.particles.len() as u64, "particles")),
        "diffuse" => Some((setup.atlas.texel_count() as u64, "texels")),
        "exchange_seams" => Some((setup.atlas.seams.len() as u64, "gutter texels")),
        _ => None,
    }
}

/// The rows of the report.
pub fn rows(report: &gpu::Report) -> Vec<KernelTime> {
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
        })
        .collect()
}

/// The table: kernel, dispatches a step, mean, median, 95th percentile, share, throughput; and how much of the step
/// the kernels account for.
pub fn table(report: &gpu::Report, setup: &Setup) -> String {
    if report.is_empty() {
        return "Kernel times are unavailable: the device has no timestamps.\n".to_owned();
    }
    let mut table = Table::new();
    table.load_style(UTF8_HORIZONTAL_ONLY);
    table.set_header([
        "kernel",
        "a step",
        "mean ms",
        "median ms",
        "p95 ms",
        "share",
        "throughput",
    ]);
    for row in &report.rows {
        let throughput = work_of(&row.name, setup).map_or(String::new(), |(count, unit)| {
            let a_second = count as f64 * row.dispatches_per_step / (row.time.median_ms * 1e-3);
            format!("{} {unit}/s", short(a_second))
        });
        table.add_row([
            row.name.clone(),
            format!("{:.4}", row.dispatches_per_step)
                .trim_end_matches('0')
                .trim_end_matches('.')
                .to_owned(),
            format!("{:.3}", row.time.mean_ms),
            format!("{:.3}", row.time.median_ms),
            format!("{:.3}", row.time.p95_ms),
            format!("{:.1} %", 100.0 * row.share),
            throughput,
        ]);
    }
    let sum =
        |of: fn(&gpu::Statistics) -> f64| report.rows.iter().map(|row| of(&row.time)).sum::<f64>();
    let step = &report.step;
    table.add_row([
        "whole step".to_owned(),
        String::new(),
        format!("{:.3}", step.mean_ms),
        format!("{:.3}", step.median_ms),
        format!("{:.3}", step.p95_ms),
        String::new(),
        format!("{:.1} steps/s", 1e3 / step.median_ms),
    ]);
    for column in 1..7 {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    let covered = 100.0 * sum(|time| time.mean_ms) / step.mean_ms;
    format!(
        "{table}\nGPU time of {} steps; the kernels account for {covered:.1} % of it.\n",
        report.steps
    )
}

/// Three digits and a unit prefix: `12.3 M`.
fn short(value: f64) -> String {
    let (scaled, prefix) = match value {
        v if v >= 1e9 => (v * 1e-9, "G"),
        v if v >= 1e6 => (v * 1e-6, "M"),
        v if v >= 1e3 => (v * 1e-3, "k"),
        v => (v, ""),
    };
    format!("{scaled:.*} {prefix}", if scaled < 10.0 { 2 } else { 1 })
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn throughput_is_short() {
        assert_eq!(short(9_340_000.0), "9.34 M");
        assert_eq!(short(123_400.0), "123.4 k");
        assert_eq!(short(2.5e9), "2.50 G");
        assert_eq!(short(7.0), "7.00 ");
    }
}
