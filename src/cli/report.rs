//! The report of a headless run: what ran where, how it ended, and what it cost, as JSON.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use myxo::scene::parameters::grouped;
use myxo::scene::settings::ObjectSettings;
use myxo::sim::{Setup, Snapshot};
use myxo::{Error, Result};
use serde::{Deserialize, Serialize};

/// Bytes of a file that are read: far more than a report has, and not all of one that never ends.
const LARGEST: u64 = 64 << 20;

/// Everything about one run. Times are `null` where the device has no timestamps.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// The device's name.
    pub device: String,
    /// The driver's name and version.
    pub driver: String,
    /// The scene's name.
    pub scene: String,
    /// The seed.
    pub seed: u64,
    /// Steps that were run, fewer than asked for when interrupted.
    pub steps: u64,
    /// Particles of all objects together.
    pub particles: u64,
    /// Texels of the atlas along a side.
    pub atlas_size: u32,
    /// Triangles of all objects together.
    pub triangles: u64,
    /// Sum over everything that the state holds, as 16 hexadecimal digits.
    pub state_hash: String,
    /// The hash along the way, where `--hash-every` asked for it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub hashes: Vec<StateHash>,
    /// GPU time of a step, between timestamps at its beginning and end: the mean of those that were measured. `render`
    /// leaves out the first one, which compiles kernels, and keeps the last 4,096.
    pub gpu_ms_per_step: Option<f64>,
    /// Time of a step as people experience it.
    pub wall_ms_per_step: f64,
    /// Where the GPU time goes.
    pub kernels: Vec<KernelTime>,
    /// The kernel that `--kernel` ran alone: then the times of `kernels` are of its runs, and none are of steps.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub alone: Option<String>,
    /// What was counted.
    pub counters: Counters,
    /// Whether Vulkan's validation layers were on; times are not worth comparing then.
    pub validation: bool,
    /// Whether the run was stopped by Ctrl-C.
    pub interrupted: bool,
    /// The command line.
    pub command: String,
    /// The program's version.
    pub version: String,
    /// The commit that the program was built from, if it was known.
    pub commit: Option<String>,
    /// The host's processor.
    pub processor: Option<String>,
    /// The host's load averages over 1, 5 and 15 minutes at the end of the run.
    pub load_average: Option<[f64; 3]>,
}

/// The state hash after a step.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StateHash {
    /// Steps done.
    pub step: u64,
    /// As [`Report::state_hash`].
    pub hash: String,
}

/// The times of one kernel.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct KernelTime {
    /// The kernel.
    pub name: String,
    /// How often it is dispatched in a step.
    pub dispatches_per_step: f64,
    /// Mean time of a step's dispatches.
    pub mean_ms: Option<f64>,
    /// Half of the steps take less.
    pub median_ms: Option<f64>,
    /// 95 % of the steps take less.
    pub p95_ms: Option<f64>,
    /// Part of the GPU time of the whole step, 0 to 1.
    pub share: Option<f64>,
    /// What it gets through.
    #[serde(default)]
    pub throughput: Option<Throughput>,
}

/// How much a kernel gets through, by the median of its times.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Throughput {
    /// What is counted: `particles`, `texels`.
    pub of: String,
    /// How many of them in a second.
    pub per_second: f64,
}

/// What was counted at the end of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Counters {
    /// Particle ids that no particle has; always 0.
    pub lost: u64,
    /// Particles whose id another one has too; always 0.
    pub doubled: u64,
    /// Sum over all texels of trail times area, in world units.
    pub trail_mass: f64,
    /// Particles that went into another object and were selected to change, the refused ones among them.
    #[serde(default)]
    pub selected: u64,
    /// Particles that have arrived, on another object or, where texels knew no triangle of it, on their own; with the
    /// strategy `respawn`, that began anew.
    #[serde(default)]
    pub transferred: u64,
    /// Particles that went on from where their walk met the other object; the others went to its nearest point.
    #[serde(default)]
    pub crossed: u64,
    /// Particles under way from one object to another.
    #[serde(default)]
    pub in_flight: u64,
    /// Particles that found the transfer buffer full and stayed on their object.
    #[serde(default)]
    pub transfer_overflow: u64,
    /// The transfer buffer size that would have done so far.
    #[serde(default)]
    pub transfer_buffer_wanted: u64,
    /// How many particles have left each object for each other one, or have found none and come back to their own.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub flux: Vec<Flux>,
}

/// Particles from one object to another.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Flux {
    /// The object that they left.
    pub from: String,
    /// The object that they went to.
    pub to: String,
    /// How many.
    pub particles: u64,
}

impl Counters {
    /// What a state tells.
    #[must_use]
    pub fn of(snapshot: &Snapshot, setup: &Setup, objects: &[ObjectSettings]) -> Self {
        let census = snapshot.census();
        let transfers = &snapshot.transfers;
        let flow = &transfers.flow;
        let pairs = transfers.flux.iter().enumerate();
        let flux = |(pair, &particles): (usize, &u32)| Flux {
            from: objects[pair / objects.len()].name.clone(),
            to: objects[pair % objects.len()].name.clone(),
            particles: particles.into(),
        };
        Self {
            lost: census.lost,
            doubled: census.doubled,
            trail_mass: snapshot.trail_mass(setup),
            selected: flow.selected.into(),
            transferred: flow.arrived.into(),
            crossed: flow.crossed.into(),
            in_flight: transfers.in_flight.len() as u64,
            transfer_overflow: flow.refused.into(),
            transfer_buffer_wanted: flow.most_wanted.into(),
            flux: pairs.filter(|(_, count)| **count > 0).map(flux).collect(),
        }
    }

    /// What to do about particles that were refused, if any were.
    #[must_use]
    pub fn overflow(&self, buffer_size: u32) -> Option<String> {
        let Self {
            transfer_overflow,
            transfer_buffer_wanted,
            ..
        } = *self;
        (transfer_overflow > 0).then(|| {
            format!(
                "transfers overflowed: {} times a particle found the transfer buffer full and stayed on its object; \
                 raise transfer.buffer_size from {} to {}",
                grouped(transfer_overflow as f64),
                grouped(buffer_size.into()),
                grouped(transfer_buffer_wanted as f64)
            )
        })
    }
}

impl Report {
    /// A report with what is known about the program and the host, all else empty.
    #[must_use]
    pub fn of_this_host() -> Self {
        Self {
            command: command(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            commit: option_env!("MYXO_COMMIT").map(str::to_owned),
            processor: processor(),
            load_average: load_average(),
            ..Self::default()
        }
    }

    /// Reads a report that `--report` or `--json` has written.
    pub fn read(path: &Path) -> Result<Self> {
        let mut text = Vec::new();
        File::open(path)
            .and_then(|file| file.take(LARGEST).read_to_end(&mut text))
            .map_err(|source| Error::Io {
                action: "read",
                path: path.to_owned(),
                source,
            })?;
        serde_json::from_slice(&text).map_err(|error| {
            Error::Invalid(format!(
                "{}: not a report of `myxo render` or `myxo profile`: {error}",
                path.display()
            ))
        })
    }

    /// The report as JSON text, with a line end.
    #[must_use]
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("a report is plain numbers and texts") + "\n"
    }
}

/// A state hash as reports write it.
#[must_use]
pub fn hash_text(hash: u64) -> String {
    format!("{hash:016x}")
}

/// The command line, quoted so that a shell takes it back.
fn command() -> String {
    let words: Vec<String> = std::env::args_os()
        .map(|word| {
            let word = word.to_string_lossy().into_owned();
            let plain = |c: char| c.is_ascii_alphanumeric() || "-_=+./:,@%".contains(c);
            if !word.is_empty() && word.chars().all(plain) {
                word
            } else {
                format!("'{}'", word.replace('\'', "'\\''"))
            }
        })
        .collect();
    words.join(" ")
}

fn processor() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let name = |key: &str| {
        text.lines()
            .find(|line| line.starts_with(key))?
            .split_once(':')
            .map(|(_, name)| name.trim())
    };
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let model = name("model name").or_else(|| name("Model"))?;
    Some(format!("{model} ({cores} threads)"))
}

fn load_average() -> Option<[f64; 3]> {
    let text = std::fs::read_to_string("/proc/loadavg").ok()?;
    let numbers: Vec<f64> = text
        .split_whitespace()
        .take(3)
        .map_while(|word| word.parse().ok())
        .collect();
    numbers.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_round_trips_and_has_the_agreed_keys() {
        let report = Report {
            state_hash: hash_text(0xabc),
            gpu_ms_per_step: Some(1.5),
            kernels: vec![KernelTime {
                name: "advance".to_owned(),
                ..KernelTime::default()
            }],
            hashes: vec![StateHash {
                step: 10,
                hash: hash_text(u64::MAX),
            }],
            ..Report::of_this_host()
        };
        let text = report.to_json();
        assert_eq!(
            serde_json::from_str::<Report>(&text).expect("it is JSON"),
            report
        );
        let value: serde_json::Value = serde_json::from_str(&text).expect("it is JSON");
        for key in [
            "device",
            "driver",
            "scene",
            "steps",
            "particles",
            "state_hash",
            "gpu_ms_per_step",
            "wall_ms_per_step",
            "kernels",
            "counters",
            "command",
            "commit",
            "processor",
            "load_average",
        ] {
            assert!(value.get(key).is_some(), "{key}");
        }
        for key in [
            "name",
            "dispatches_per_step",
            "mean_ms",
            "median_ms",
            "p95_ms",
            "share",
        ] {
            assert!(value["kernels"][0].get(key).is_some(), "{key}");
        }
        for key in [
            "lost",
            "doubled",
            "trail_mass",
            "selected",
            "transferred",
            "in_flight",
            "transfer_overflow",
            "transfer_buffer_wanted",
        ] {
            assert!(value["counters"].get(key).is_some(), "{key}");
        }
        assert_eq!(value["state_hash"], "0000000000000abc");
    }

    #[test]
    fn an_overflow_says_which_size_would_have_done() {
        let mut counters = Counters::default();
        assert_eq!(counters.overflow(16), None);
        counters.transfer_overflow = 12_345;
        counters.transfer_buffer_wanted = 812;
        let text = counters.overflow(16).unwrap_or_default();
        assert!(
            text.contains("12,345 times") && text.ends_with("from 16 to 812"),
            "{text}"
        );
    }
}
