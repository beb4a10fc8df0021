//! `myxo compare`: are the states of two runs equal, and how do their times compare?

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;
use myxo::Result;

use super::report::{KernelTime, Report};
use super::{Outcome, console};

/// Compare the reports of two runs: states and times
///
/// Exits 0 where the state hashes are equal, 1 where they differ, 2 where a report cannot be read.
#[derive(Clone, Debug, Args)]
#[command(after_help = "\
Examples:
  myxo render torus --steps 400 --out a.png --report a.json
  myxo render torus --steps 400 --out b.png --report b.json
  myxo compare a.json b.json && echo the same bits")]
pub struct Compare {
    /// A report
    a: PathBuf,
    /// Another one; times are given as ratios of this one's to the first one's
    b: PathBuf,
}

impl Compare {
    /// Prints the comparison.
    pub fn run(&self) -> Result<Outcome> {
        let (a, b) = (Report::read(&self.a)?, Report::read(&self.b)?);
        console::print(comparison(&a, &b))?;
        Ok(if a.state_hash == b.state_hash {
            Outcome::Done
        } else {
            Outcome::Differs
        })
    }
}

/// The comparison as text: the state first, then what differs in the set-up, then the times.
fn comparison(a: &Report, b: &Report) -> String {
    let mut text = String::new();
    if a.state_hash == b.state_hash {
        let _ = writeln!(text, "state      equal     {}", a.state_hash);
    } else {
        let _ = writeln!(
            text,
            "state      DIFFERS   {} -> {}",
            a.state_hash, b.state_hash
        );
        if let Some(step) = first_difference(a, b) {
            let _ = writeln!(
                text,
                "           the hashes along the way differ from step {step} on"
            );
        }
    }
    let setup = [
        ("scene", a.scene.clone(), b.scene.clone()),
        ("seed", a.seed.to_string(), b.seed.to_string()),
        ("steps", a.steps.to_string(), b.steps.to_string()),
        (
            "particles",
            a.particles.to_string(),
            b.particles.to_string(),
        ),
        ("atlas", a.atlas_size.to_string(), b.atlas_size.to_string()),
        ("device", a.device.clone(), b.device.clone()),
        ("driver", a.driver.clone(), b.driver.clone()),
        (
            "commit",
            a.commit.clone().unwrap_or_default(),
            b.commit.clone().unwrap_or_default(),
        ),
        (
            "validation",
            a.validation.to_string(),
            b.validation.to_string(),
        ),
    ];
    for (what, a, b) in setup.iter().filter(|(_, a, b)| a != b) {
        let _ = writeln!(text, "{what:<10} differs   {a} -> {b}");
    }
    let _ = writeln!(
        text,
        "\n{:<20} {:>12} {:>12} {:>8}",
        "ms per step", "first", "second", "ratio"
    );
    times(&mut text, "gpu", a.gpu_ms_per_step, b.gpu_ms_per_step);
    times(
        &mut text,
        "wall",
        Some(a.wall_ms_per_step),
        Some(b.wall_ms_per_step),
    );
    let find = |report: &Report, name: &str| {
        report
            .kernels
            .iter()
            .find(|kernel| kernel.name == name)
            .and_then(|kernel| kernel.mean_ms)
    };
    for KernelTime { name, mean_ms, .. } in &a.kernels {
        times(&mut text, name, *mean_ms, find(b, name));
    }
    for KernelTime { name, mean_ms, .. } in &b.kernels {
        if a.kernels.iter().all(|kernel| kernel.name != *name) {
            times(&mut text, name, None, *mean_ms);
        }
    }
    text
}

fn times(text: &mut String, name: &str, a: Option<f64>, b: Option<f64>) {
    let shown = |ms: Option<f64>| ms.map_or("-".to_owned(), |ms| format!("{ms:.3}"));
    let ratio = match (a, b) {
        (Some(a), Some(b)) if a > 0.0 => format!("{:.2}", b / a),
        _ => "-".to_owned(),
    };
    let _ = writeln!(
        text,
        "{name:<20} {:>12} {:>12} {ratio:>8}",
        shown(a),
        shown(b)
    );
}

/// The first step whose hash both have and that differs.
fn first_difference(a: &Report, b: &Report) -> Option<u64> {
    a.hashes
        .iter()
        .find(|x| {
            b.hashes
                .iter()
                .any(|y| x.step == y.step && x.hash != y.hash)
        })
        .map(|hash| hash.step)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::report::{StateHash, hash_text};

    fn report(hash: u64, ms: f64) -> Report {
        let kernel = |name: &str, ms| KernelTime {
            name: name.to_owned(),
            mean_ms: Some(ms),
            ..KernelTime::default()
        };
        Report {
            state_hash: hash_text(hash),
            hashes: (1..4)
                .map(|step| StateHash {
                    step,
                    hash: hash_text(hash * u64::from(step > 1)),
                })
                .collect(),
            gpu_ms_per_step: Some(ms),
            wall_ms_per_step: 2.0 * ms,
            kernels: vec![kernel("advance", ms / 2.0), kernel("diffuse", ms / 4.0)],
            ..Report::default()
        }
    }

    #[test]
    fn equal_states_are_equal_whatever_the_times() {
        let text = comparison(&report(5, 10.0), &report(5, 15.0));
        assert!(
            text.starts_with("state      equal     0000000000000005\n"),
            "{text}"
        );
        let line = |start: &str| {
            text.lines()
                .find(|line| line.starts_with(start))
                .unwrap_or_default()
                .to_owned()
        };
        assert!(
            line("gpu ").ends_with("10.000       15.000     1.50"),
            "{text}"
        );
        assert!(
            line("wall ").ends_with(" 1.50")
                && line("diffuse ").ends_with("2.500        3.750     1.50"),
            "{text}"
        );
    }

    #[test]
    fn the_first_step_that_differs_is_named() {
        let mut other = report(6, 10.0);
        other.steps = 9;
        other.kernels.remove(0);
        let text = comparison(&report(5, 10.0), &other);
        assert!(
            text.contains("DIFFERS") && text.contains("from step 2 on"),
            "{text}"
        );
        assert!(text.contains("steps      differs   0 -> 9"), "{text}");
        let line = text
            .lines()
            .find(|line| line.starts_with("advance"))
            .unwrap_or_default();
        assert!(line.ends_with("5.000            -        -"), "{text}");
    }
}
