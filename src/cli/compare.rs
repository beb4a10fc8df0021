//! `myxo compare`: are the states of two runs equal, and how do their times compare?

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;
use myxo::Result;

use super::report::Report;
use super::{Command, Outcome, ratios, unless_closed};
use crate::console;

/// Compare the reports of two runs: states, settings and times
///
/// Exits 0 where the state hashes are equal, 1 where they differ, 2 where a report cannot be read. The hashes are over particles, trail,
/// paint, food and pulses, and not over the objects' poses and time.
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

impl Command for Compare {
    /// Prints the comparison.
    fn run(&self) -> Result<Outcome> {
        let (a, b) = (Report::read(&self.a)?, Report::read(&self.b)?);
        unless_closed(console::print(comparison(&a, &b)))?;
        Ok(
            if a.state_hash == b.state_hash && !a.state_hash.is_empty() {
                Outcome::Done
            } else {
                Outcome::Differs
            },
        )
    }

    /// A code of its own, so that scripts can distinguish a failure from states that differ.
    fn exit_code_of_failure(&self) -> u8 {
        2
    }
}

/// The comparison as text: the state first, then what differs in the set-up, what makes times doubtful, and the times.
fn comparison(a: &Report, b: &Report) -> String {
    let mut text = String::new();
    if a.state_hash.is_empty() || b.state_hash.is_empty() {
        text.push_str("state      unknown: a report of a window has no state hash\n");
    } else if a.state_hash == b.state_hash {
        let _ = writeln!(text, "state      equal     {}", a.state_hash);
    } else {
        let _ = writeln!(
            text,
            "state      DIFFERS   {} -> {}",
            a.state_hash, b.state_hash
        );
        let unlike = match (a.arithmetic, b.arithmetic) {
            (Some(a), Some(b)) if a == b => None,
            (Some(_), Some(_)) => Some("have different versions of the arithmetic"),
            _ => Some("do not both name the version of their arithmetic"),
        };
        if let Some(unlike) = unlike {
            let _ = writeln!(
                text,
                "           the hashes cannot be compared, because the reports {unlike}: run both with one version of myxo"
            );
        }
        if let Some(step) = first_difference(a, b) {
            let _ = writeln!(
                text,
                "           the hashes along the way differ from step {step} on"
            );
        }
    }
    text.push_str(&ratios::differences_text(a, b));
    if a.has_kernel_times() && b.has_kernel_times() {
        text.push_str(&ratios::doubts_text(a, b));
    }
    text.push('\n');
    text + &ratios::table(a, b)
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
    use crate::cli::host::HostLoad;
    use crate::cli::report::{KernelTime, StateHash, Times, hash_text};

    fn report(hash: u64, ms: f64) -> Report {
        let kernel = |name: &str, ms| KernelTime {
            name: name.to_owned(),
            time: Times {
                mean_ms: Some(ms),
                ..Times::default()
            },
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
            wall_ms_per_step: Some(2.0 * ms),
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
            line("gpu ").ends_with("10.000       15.000    1.500"),
            "{text}"
        );
        assert!(
            line("wall ").ends_with(" 1.500")
                && line("diffuse ").ends_with("2.500        3.750    1.500"),
            "{text}"
        );
    }

    #[test]
    fn doubtful_times_give_warnings() {
        let busy = Report {
            host_load: Some(HostLoad {
                others: Some(0.4),
                is_busy: true,
                ..HostLoad::default()
            }),
            steps: 9,
            ..report(5, 15.0)
        };
        let quiet = Report {
            steps: 9,
            ..report(5, 10.0)
        };
        let text = comparison(&quiet, &busy);
        let busy_line = "warning: second: the machine was busy: other programs have taken 40 % of its processors";
        for part in [busy_line, "note: one run each: "] {
            assert!(text.contains(part), "{part} in {text}");
        }
        assert!(!text.contains("warning: first"), "{text}");
        // Without times there are no warnings.
        let untimed = Report {
            kernels: Vec::new(),
            ..busy
        };
        assert!(!comparison(&quiet, &untimed).contains("warning"));
    }

    /// Would catch: states that are said to differ, and not that their hashes cannot be compared.
    #[test]
    fn hashes_of_other_arithmetic_are_not_compared() {
        let of = |hash, arithmetic| Report {
            arithmetic,
            ..report(hash, 10.0)
        };
        let text = comparison(&of(5, Some(1)), &of(6, Some(2)));
        assert!(text.contains("DIFFERS") && text.contains("have different versions"));
        assert!(text.contains("arithmetic differs   1 -> 2\n"), "{text}");
        assert!(!text.contains("the same conditions"), "{text}");
        let text = comparison(&of(5, None), &of(6, Some(2)));
        assert!(text.contains("do not both name the version"), "{text}");
        for (a, b) in [(5, 6), (6, 6)] {
            let text = comparison(&of(a, Some(2)), &of(b, Some(2)));
            assert!(!text.contains("cannot be compared"), "{text}");
        }
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
