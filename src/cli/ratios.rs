//! Two reports side by side: how their runs differ, and the ratios of their times with intervals. `myxo compare`
//! and `myxo profile --compare` print these.

use std::fmt::Write as _;

use super::report::{KernelTime, Report, Times};
use super::settings;

/// If the speeds of copies differ by more than this factor, the machine was not equally fast both times.
const APART: f64 = 1.15;

/// A ratio of medians with its interval, of the same confidence as the medians' own intervals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ratio {
    pub value: f64,
    pub low: f64,
    pub high: f64,
}

impl Ratio {
    /// The ratio of `b` to `a`. The errors of the two medians' logarithms, taken from their intervals, are independent, so their squares
    /// add up, for each side separately.
    pub fn of(a: &Times, b: &Times) -> Option<Self> {
        let ([a, a_low, a_high], [b, b_low, b_high]) = (a.interval()?, b.interval()?);
        let below = (b / b_low).ln().hypot((a_high / a).ln());
        let above = (b_high / b).ln().hypot((a / a_low).ln());
        let value = b / a;
        Some(Self {
            value,
            low: value * (-below).exp(),
            high: value * above.exp(),
        })
    }

    /// May they be equal?
    pub fn holds_one(&self) -> bool {
        (self.low..=self.high).contains(&1.0)
    }
}

impl std::fmt::Display for Ratio {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { value, low, high } = self;
        write!(f, "{value:>8.3}  {:>15}", format!("{low:.3} - {high:.3}"))?;
        if self.holds_one() {
            write!(f, "  may be equal")?;
        }
        Ok(())
    }
}

/// How the set-ups of two runs differ: the name of a setting, and its value in each.
pub fn differences(a: &Report, b: &Report) -> Vec<(&'static str, String, String)> {
    let number = |known: Option<u64>| known.map_or("unknown".to_owned(), |n| n.to_string());
    let setup = |of: &Report| {
        [
            ("scene", of.scene.clone()),
            ("seed", of.seed.to_string()),
            // The steps before a kernel that ran alone are its warm-up.
            ("steps", number(of.alone.is_none().then_some(of.steps))),
            ("runs", number(of.alone.as_ref().and(of.samples))),
            ("warmup", number(of.warmup)),
            ("particles", of.particles.to_string()),
            ("atlas", of.atlas_size.to_string()),
            ("triangles", of.triangles.to_string()),
            ("device", of.device.clone()),
            ("driver", of.driver.clone()),
            ("processor", of.processor.clone().unwrap_or_default()),
            ("arithmetic", number(of.arithmetic.map(u64::from))),
            ("commit", of.commit.clone().unwrap_or_default()),
            ("validation", of.validation.to_string()),
        ]
    };
    let pairs = setup(a).into_iter().zip(setup(b));
    pairs
        .filter(|((_, a), (_, b))| a != b)
        .map(|((what, a), (_, b))| (what, a, b))
        .collect()
}

/// The differences as lines: of the set-up, then keys of the scene.
pub fn differences_text(a: &Report, b: &Report) -> String {
    let mut text = String::new();
    for (what, a, b) in differences(a, b) {
        let _ = writeln!(text, "{what:<10} differs   {a} -> {b}");
    }
    match (a.settings.is_null(), b.settings.is_null()) {
        (false, false) => {
            for line in settings::differences(&a.settings, &b.settings) {
                let _ = writeln!(text, "settings   differ    {line}");
            }
        }
        // Earlier versions wrote reports without settings.
        (true, true) => {}
        (true, false) => text.push_str("settings   unknown   the first report has none\n"),
        (false, true) => text.push_str("settings   unknown   the second report has none\n"),
    }
    text
}

/// What makes the ratios of two reports' times doubtful, as lines.
pub fn doubts_text(a: &Report, b: &Report) -> String {
    let mut text = String::new();
    for (which, report) in [("first", a), ("second", b)] {
        let doubts = [
            (report.validation).then(|| "the validation layers were on".to_owned()),
            report.host_load.and_then(|load| load.warning()),
            report
                .interrupted
                .then(|| "the measurement was interrupted".to_owned()),
        ];
        for doubt in doubts.into_iter().flatten() {
            let _ = writeln!(text, "warning: {which}: {doubt}");
        }
    }
    if let Some((first, second)) = speeds_apart(a, b) {
        let _ = writeln!(
            text,
            "warning: the device was not as fast both times: copies reached {first:.1} GB/s in the first and \
             {second:.1} in the second; at such times measure both in turn, by `myxo profile --against`"
        );
    }
    let has_other_work = differences(a, b)
        .iter()
        .any(|(what, ..)| !["seed", "steps", "runs", "arithmetic", "commit"].contains(what));
    if has_other_work {
        text.push_str(
            "warning: the two were not measured under the same conditions: a ratio shows the effect of all differences\n",
        );
    }
    let fewest = [a, b].into_iter().filter_map(Report::sample_count).min();
    if fewest.is_some_and(|fewest| fewest < 6) {
        let what = if a.alone.is_some() { "runs" } else { "steps" };
        let _ = writeln!(
            text,
            "warning: of fewer than 6 {what} an interval is from the least to the most, and says nothing about other {what}"
        );
    }
    if a.repetitions.is_empty() || b.repetitions.is_empty() {
        text.push_str(
            "note: one run each: intervals do not include changes from run to run; `myxo profile --repeat` includes them\n",
        );
    }
    text
}

/// The speeds of copies, made in the same way, if they show that the machine was faster in one of the two measurements.
fn speeds_apart(a: &Report, b: &Report) -> Option<(f64, f64)> {
    let (a, b) = a.copy_bandwidth.zip(b.copy_bandwidth)?;
    if a.by_kernel != b.by_kernel {
        return None;
    }
    let [a, b] = [a, b].map(|copy| copy.gigabytes_per_second);
    (a.max(b) > APART * a.min(b)).then_some((a, b))
}

/// The times of both: medians and their ratio where both have them, otherwise means.
pub fn table(a: &Report, b: &Report) -> String {
    let mut text = String::new();
    let is_alone = a.alone.is_some() && b.alone.is_some();
    let head = if is_alone {
        "ms per run"
    } else {
        "ms per step"
    };
    let _ = writeln!(
        text,
        "{:<20} {:>12} {:>12} {:>8}  {:>15}",
        head, "first", "second", "ratio", "95 % interval"
    );
    let of_step = |of: &Report| Times {
        mean_ms: of.gpu_ms_per_step,
        ..of.gpu_step
    };
    let wall = |of: &Report| Times {
        mean_ms: of.wall_ms_per_step,
        ..Times::default()
    };
    let none = Times::default();
    // A kernel that ran alone is no part of a step.
    if !is_alone {
        row(&mut text, "gpu", &of_step(a), &of_step(b));
        row(&mut text, "wall", &wall(a), &wall(b));
    }
    let find = |report: &Report, name: &str| {
        let kernel = report.kernels.iter().find(|kernel| kernel.name == name);
        kernel.map_or(none, KernelTime::in_each_step)
    };
    for kernel in &a.kernels {
        let name = &kernel.name;
        row(&mut text, name, &kernel.in_each_step(), &find(b, name));
    }
    for kernel in &b.kernels {
        let name = &kernel.name;
        if a.kernels.iter().all(|kernel| kernel.name != *name) {
            row(&mut text, name, &none, &kernel.in_each_step());
        }
    }
    text
}

fn row(text: &mut String, name: &str, a: &Times, b: &Times) {
    let shown = |ms: Option<f64>| ms.map_or("-".to_owned(), |ms| format!("{ms:.3}"));
    let ratio = Ratio::of(a, b);
    let (first, second) = match ratio {
        Some(_) => (a.median_ms, b.median_ms),
        None => (a.mean_ms.or(a.median_ms), b.mean_ms.or(b.median_ms)),
    };
    let ratio = match (ratio, first, second) {
        (Some(ratio), ..) => ratio.to_string(),
        (None, Some(a), Some(b)) if a > 0.0 => format!("{:>8.3}", b / a),
        _ => format!("{:>8}", "-"),
    };
    let _ = writeln!(
        text,
        "{name:<20} {:>12} {:>12} {ratio}",
        shown(first),
        shown(second)
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::report::Bandwidth;

    fn times(median: f64, low: f64, high: f64) -> Times {
        Times {
            median_ms: Some(median),
            median_low_ms: Some(low),
            median_high_ms: Some(high),
            ..Times::default()
        }
    }

    #[test]
    fn intervals_of_ratios_follow_from_those_of_medians() {
        let exact = times(10.0, 10.0, 10.0);
        // Only one of them has an interval: the ratio's interval has the same width.
        let ratio = Ratio::of(&exact, &times(20.0, 19.0, 22.0)).expect("both are known");
        assert!((ratio.value - 2.0).abs() < 1e-12);
        assert!((ratio.low - 1.9).abs() < 1e-12 && (ratio.high - 2.2).abs() < 1e-12);
        let ratio = Ratio::of(&times(10.0, 8.0, 12.5), &exact).expect("both are known");
        assert!((ratio.low - 0.8).abs() < 1e-12 && (ratio.high - 1.25).abs() < 1e-12);
        assert!(ratio.holds_one() && ratio.to_string().ends_with("0.800 - 1.250  may be equal"));
        // Both vary by 10 %: the ratio varies by the root of two times that.
        let unsure = times(10.0, 10.0 / 1.1, 11.0);
        let ratio = Ratio::of(&unsure, &unsure).expect("both are known");
        assert!((ratio.high.ln() - 1.1_f64.ln() * 2.0_f64.sqrt()).abs() < 1e-12);
        assert!((ratio.low * ratio.high - 1.0).abs() < 1e-12);
        assert_eq!(Ratio::of(&exact, &Times::default()), None);
        assert_eq!(
            Ratio::of(&times(0.0, 0.0, 1.0), &exact),
            None,
            "a rare kernel"
        );
    }

    #[test]
    fn another_warmup_and_another_speed_give_warnings() {
        let copies = |gigabytes_per_second| {
            Some(Bandwidth {
                gigabytes_per_second,
                ..Bandwidth::default()
            })
        };
        let a = Report {
            warmup: Some(50),
            copy_bandwidth: copies(36.0),
            ..Report::default()
        };
        let b = Report {
            warmup: Some(5),
            copy_bandwidth: copies(32.0),
            ..Report::default()
        };
        let text = differences_text(&a, &b);
        assert!(text.contains("warmup     differs   50 -> 5\n"), "{text}");
        let older = Report::default();
        let text = differences_text(&older, &a);
        assert!(
            text.contains("warmup     differs   unknown -> 50\n"),
            "{text}"
        );
        let hour = "copies reached 36.0 GB/s in the first and 19.0 in the second";
        assert!(
            !doubts_text(&a, &b).contains("copies reached"),
            "within 15 %"
        );
        let slow = Report {
            copy_bandwidth: copies(19.0),
            ..b
        };
        let text = doubts_text(&a, &slow);
        assert!(text.contains(hour) && text.contains("--against"), "{text}");
        assert!(doubts_text(&slow, &a).contains("19.0 GB/s in the first and 36.0"));
        assert!(
            !doubts_text(&a, &older).contains("copies reached"),
            "not known"
        );
    }

    /// A kernel alone is measured in runs, not in the steps of its warm-up.
    #[test]
    fn kernels_alone_are_judged_by_their_runs() {
        let alone = |steps, samples| Report {
            alone: Some("advance".to_owned()),
            steps,
            samples,
            ..Report::default()
        };
        let few = "warning: of fewer than 6 runs";
        let (many_runs, few_runs) = (alone(0, Some(200)), alone(50, Some(5)));
        assert!(!doubts_text(&many_runs, &many_runs).contains(few));
        assert!(doubts_text(&many_runs, &few_runs).contains(few));
        assert!(
            !doubts_text(&many_runs, &alone(0, None)).contains(few),
            "an older report"
        );
        let text = differences_text(&many_runs, &few_runs);
        assert!(text.contains("runs       differs   200 -> 5"), "{text}");
        let text = table(&many_runs, &few_runs);
        assert!(
            !text.contains("wall") && text.starts_with("ms per run "),
            "{text}"
        );
        let old = Report {
            repetitions: vec![Default::default(); 2],
            steps: 9,
            ..Report::default()
        };
        assert_eq!(old.sample_count(), Some(9));
    }

    #[test]
    fn differences_are_named_once() {
        let a = Report {
            particles: 5,
            device: "abacus".to_owned(),
            ..Report::default()
        };
        let b = Report {
            device: "slide rule".to_owned(),
            ..a.clone()
        };
        let expected = ("device", "abacus".to_owned(), "slide rule".to_owned());
        assert_eq!(differences(&a, &b), [expected]);
        assert!(differences(&a, &a).is_empty());
    }
}
