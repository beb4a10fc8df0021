//! The report of a headless run: the device, the scene, the final state and the times, as JSON.

use std::collections::BTreeMap;
use std::path::Path;

use glam::Affine3A;
use myxo::gpu::{CopyBandwidth, DeviceInfo, Statistics};
use myxo::plain_text::Shown as _;
use myxo::scene::Scene;
use myxo::scene::motion::in_decimals;
use myxo::scene::settings::{ObjectSettings, Settings};
use myxo::sim::yardstick::{self, CopiedBy};
use myxo::sim::{Setup, Snapshot, arithmetic};
use myxo::{Error, Result, regular_file};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::counters::Counters;
use super::host::{self, HostLoad};
use super::measures::Measure;
use super::times::between_kernels;

/// The most bytes that are read of a file: far more than a report has, in case the file never ends.
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
    /// Every key of the scene as it was run, as a scene file has them: `settings["physarum"]["speed"]`. `null` in reports of earlier
    /// versions.
    #[serde(default, skip_serializing_if = "Value::is_null")]
    pub settings: Value,
    /// Steps that were run, fewer than asked for when interrupted; of `profile` those after the warm-up, in all
    /// repetitions. Of a kernel alone those before it, which the state is of.
    pub steps: u64,
    /// How many steps the GPU times are of, or runs of a kernel alone, in all repetitions. Reports of earlier versions lack it;
    /// [`Report::sample_count`] handles them, too.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub samples: Option<u64>,
    /// Warm-up steps of `profile`. Reports of earlier versions lack it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub warmup: Option<u64>,
    /// Particles of all objects together; where their number changes, those that there is room for.
    pub particles: u64,
    /// Texels of the atlas along a side.
    pub atlas_size: u32,
    /// Triangles of all objects together.
    pub triangles: u64,
    /// The hash of particles, trail, paint, food and pulses, as 16 hexadecimal digits; empty in reports of a window.
    pub state_hash: String,
    /// Does the run end in this hash on every device? `true` where the device calculates by IEEE 754, distances are not drawn
    /// (`distance.method = "raster"`), and the run does not continue a state of other arithmetic. `null` if that was not tested: by
    /// `profile --compiled`, and by earlier versions.
    #[serde(default)]
    pub hash_is_portable: Option<bool>,
    /// The version of the arithmetic of the steps. Hashes of different versions, and hashes without a version, cannot be compared.
    #[serde(default)]
    pub arithmetic: Option<u32>,
    /// The hashes along the way, with `--hash-every`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub hashes: Vec<StateHash>,
    /// The measures of the network along the way and at the end, with `--measure-every`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub measures: Vec<Measure>,
    /// GPU time of a step, between timestamps at its beginning and end: the mean of those that were measured. `render`
    /// and `export` leave out the first one, which compiles kernels, and keep the last 4,096.
    pub gpu_ms_per_step: Option<f64>,
    /// The same with its spread.
    #[serde(default)]
    pub gpu_step: Times,
    /// The part of that mean between kernels: barriers, timestamps, and other work of the device.
    #[serde(default)]
    pub gpu_ms_between_kernels: Option<f64>,
    /// The host's time for a step, measured by `profile`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub host_step: Option<HostTimes>,
    /// Wall time of a step: the mean of those that were run. `null` if none were run, as for a kernel alone.
    #[serde(default)]
    pub wall_ms_per_step: Option<f64>,
    /// The GPU time of each kernel.
    pub kernels: Vec<KernelTime>,
    /// The kernel that `--kernel` ran alone: then the times of `kernels` are of its runs, and none are of steps.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub alone: Option<String>,
    /// How fast the device copies, which bytes of kernels are compared with.
    #[serde(default)]
    pub copy_bandwidth: Option<Bandwidth>,
    /// How long a graphics card was kept busy before times were taken, by `profile`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kept_busy: Option<KeptBusy>,
    /// The results of each repetition, with `--repeat`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub repetitions: Vec<Repetition>,
    /// Counts of the final state; `null` in reports of a window.
    pub counters: Option<Counters>,
    /// Foods and markers, and their remaining amounts.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub foods: Vec<FoodLeft>,
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
    /// How busy the host's processors were while times were taken.
    #[serde(default)]
    pub host_load: Option<HostLoad>,
}

/// The state hash after a step.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StateHash {
    /// Steps done.
    pub step: u64,
    /// As [`Report::state_hash`].
    pub hash: String,
}

/// A food or a marker, and its remaining amount. Lengths are world units.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FoodLeft {
    /// The name of the object that it lies on.
    pub object: String,
    /// Its place in the world at the last step.
    pub position: [f64; 3],
    /// How far along the surface it is sensed.
    pub radius: f64,
    /// How far along the surface it is eaten; 0 for a marker.
    pub size: f64,
    /// The scent where it lies, at its full amount.
    pub strength: f32,
    /// Its meals at the start; 0 for an endless amount.
    pub amount: u32,
    /// The meals that are left; `null` for an endless amount.
    pub remaining: Option<u32>,
}

impl FoodLeft {
    /// All foods and markers, those that the scene names first.
    #[must_use]
    pub fn all(
        snapshot: &Snapshot,
        setup: &Setup,
        objects: &[ObjectSettings],
        world_from_object: &[Affine3A],
    ) -> Vec<Self> {
        let places = setup.food_set.places.iter().zip(&setup.food_set.marks);
        let all = places.zip(&snapshot.food.remaining);
        all.map(|((place, mark), &left)| {
            let object = place.object as usize;
            Self {
                object: objects[object].name.clone(),
                position: in_decimals(
                    world_from_object[object]
                        .transform_point3(mark.position)
                        .as_dvec3()
                        + setup.origins[object].world,
                    setup.radius,
                ),
                radius: place.radius,
                size: place.size,
                strength: place.strength,
                amount: place.amount,
                remaining: (place.amount > 0).then_some(left),
            }
        })
        .collect()
    }
}

/// Times and their spread over the steps that were measured; `null` where the device has no timestamps. For a kernel that not every step
/// has, the mean is over all steps, and the other values are over the steps that have it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Times {
    /// Arithmetic mean.
    pub mean_ms: Option<f64>,
    /// Half of the steps take less.
    pub median_ms: Option<f64>,
    /// 95 % of the steps take less.
    pub p95_ms: Option<f64>,
    /// Standard deviation.
    pub std_ms: Option<f64>,
    /// The fastest step.
    pub min_ms: Option<f64>,
    /// The slowest step.
    pub max_ms: Option<f64>,
    /// With `median_high_ms`: where the median lies. By ranks, with 95 % confidence for independent steps; with
    /// repetitions at least from their lowest to their highest median.
    pub median_low_ms: Option<f64>,
    /// The upper end of that interval.
    pub median_high_ms: Option<f64>,
}

/// The host's time for a step: all its work from one step to the next, without waiting for the device. The device waits for the host only
/// if this takes longer than the step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HostTimes {
    /// Beginning the frame: reading the times of the frame that used this slot before, freeing unused objects, and resetting the buffers
    /// for commands and times. Reports of earlier versions lack it.
    #[serde(default)]
    pub beginning: Times,
    /// Recording the commands, with the poses and the list of distances that the step needs.
    pub recording: Times,
    /// The submission.
    pub submitting: Times,
    /// The sum.
    #[serde(alias = "both")]
    pub all: Times,
}

impl HostTimes {
    /// The medians of steps that took so many milliseconds to begin, to record and to submit; `None` without steps.
    #[must_use]
    pub fn of(steps: &[[f64; 3]]) -> Option<Self> {
        if steps.is_empty() {
            return None;
        }
        let times =
            |ms: fn(&[f64; 3]) -> f64| Times::from(&Statistics::of(steps.iter().map(ms).collect()));
        Some(Self {
            beginning: times(|step| step[0]),
            recording: times(|step| step[1]),
            submitting: times(|step| step[2]),
            all: times(|step| step.iter().sum()),
        })
    }
}

impl From<&Statistics> for Times {
    fn from(of: &Statistics) -> Self {
        Self {
            mean_ms: Some(of.mean_ms),
            median_ms: Some(of.median_ms),
            p95_ms: Some(of.p95_ms),
            std_ms: Some(of.std_ms),
            min_ms: Some(of.min_ms),
            max_ms: Some(of.max_ms),
            median_low_ms: Some(of.median_low_ms),
            median_high_ms: Some(of.median_high_ms),
        }
    }
}

impl Times {
    /// Widens the interval of the median so that it holds another one.
    pub fn include(&mut self, median_ms: f64) {
        self.median_low_ms = self.median_low_ms.map(|low| low.min(median_ms));
        self.median_high_ms = self.median_high_ms.map(|high| high.max(median_ms));
    }

    /// The median and the ends of its interval, if they are above 0; `None` if there is no interval.
    pub fn interval(&self) -> Option<[f64; 3]> {
        let median = self.median_ms.filter(|ms| *ms > 0.0)?;
        Some([median, self.median_low_ms?, self.median_high_ms?])
    }
}

/// The times of one kernel.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct KernelTime {
    /// The name of the kernel.
    pub name: String,
    /// How often it is dispatched in a step.
    pub dispatches_per_step: f64,
    /// The part of the steps that have it, 0 to 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub of_steps: Option<f64>,
    /// The time of all its dispatches in a step.
    #[serde(flatten)]
    pub time: Times,
    /// Part of the GPU time of the whole step, 0 to 1, by means.
    pub share: Option<f64>,
    /// Its throughput.
    #[serde(default)]
    pub throughput: Option<Throughput>,
    /// The bytes that it must read and write in a step; `super::work` says how they are counted.
    #[serde(default)]
    pub bytes_per_step: Option<f64>,
    /// These bytes per second, in units of 10^9.
    #[serde(default)]
    pub gigabytes_per_second: Option<f64>,
    /// The same, relative to the speed of copies.
    #[serde(default)]
    pub of_copy_bandwidth: Option<f64>,
}

impl KernelTime {
    /// Its times as a part of each step: for a kernel that not every step has, only the mean.
    pub fn in_each_step(&self) -> Times {
        if self.of_steps.is_none_or(|part| part >= 1.0) {
            return self.time;
        }
        Times {
            mean_ms: self.time.mean_ms,
            ..Times::default()
        }
    }
}

/// The throughput of a kernel, by the median of its times; by the mean if not every step has it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Throughput {
    /// The unit: `particles`, `texels`.
    pub of: String,
    /// How many per second.
    pub per_second: f64,
}

/// How long a graphics card was kept busy, so that its clock had risen when times were taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct KeptBusy {
    /// Seconds.
    pub seconds: f64,
    /// Were its times steady at the end?
    pub is_steady: bool,
}

impl From<yardstick::KeptBusy> for KeptBusy {
    fn from(of: yardstick::KeptBusy) -> Self {
        Self {
            seconds: of.seconds,
            is_steady: of.is_steady,
        }
    }
}

/// How fast the device copies: by its own copies or by a kernel, whichever is faster.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Bandwidth {
    /// Bytes read plus bytes written per second, in units of 10^9, by the median.
    pub gigabytes_per_second: f64,
    /// Bytes of a copy, from one buffer of the device to another.
    pub size_in_bytes: u64,
    /// How many were measured.
    pub runs: usize,
    /// Time of a copy.
    pub median_ms: f64,
    /// Standard deviation.
    pub std_ms: f64,
    /// Did a kernel copy? If not, the device's own copies were at least as fast.
    #[serde(default)]
    pub by_kernel: bool,
}

impl From<&(CopyBandwidth, CopiedBy)> for Bandwidth {
    fn from((of, by): &(CopyBandwidth, CopiedBy)) -> Self {
        Self {
            by_kernel: *by == CopiedBy::Kernel,
            gigabytes_per_second: of.bytes_per_second() * 1e-9,
            size_in_bytes: of.size_in_bytes,
            runs: of.runs,
            median_ms: of.time.median_ms,
            std_ms: of.time.std_ms,
        }
    }
}

/// One repetition of a measurement: medians in milliseconds.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Repetition {
    /// Steps, or runs of a kernel alone.
    pub steps: usize,
    /// Of the whole step.
    pub step_ms: f64,
    /// Of each kernel.
    pub kernels_ms: BTreeMap<String, f64>,
}

impl From<&myxo::gpu::Report> for Repetition {
    fn from(of: &myxo::gpu::Report) -> Self {
        let kernels = of.rows.iter();
        Self {
            steps: of.steps,
            step_ms: of.step.median_ms,
            kernels_ms: kernels
                .map(|row| (row.name.clone(), row.time.median_ms))
                .collect(),
        }
    }
}

/// Widens the intervals of medians, of the step and of its kernels, by the medians of the repetitions.
pub fn widen(step: &mut Times, kernels: &mut [KernelTime], repetitions: &[Repetition]) {
    for repetition in repetitions {
        step.include(repetition.step_ms);
        for kernel in &mut *kernels {
            if let Some(median_ms) = repetition.kernels_ms.get(&kernel.name) {
                kernel.time.include(*median_ms);
            }
        }
    }
}

impl Report {
    /// Adds the repetitions of which the report is the sum, and widens the intervals of medians by them.
    pub fn add_repetitions(&mut self, repetitions: Vec<Repetition>) {
        widen(&mut self.gpu_step, &mut self.kernels, &repetitions);
        self.repetitions = repetitions;
    }

    /// How many steps its times are of, or runs of a kernel alone; `None` where an older report does not say.
    #[must_use]
    pub fn sample_count(&self) -> Option<u64> {
        let repeated: usize = self.repetitions.iter().map(|one| one.steps).sum();
        let repeated = (repeated > 0).then_some(repeated as u64);
        let steps = self.alone.is_none().then_some(self.steps);
        self.samples.or(repeated).or(steps)
    }

    /// Was any kernel timed?
    #[must_use]
    pub fn has_kernel_times(&self) -> bool {
        let mut kernels = self.kernels.iter();
        kernels.any(|kernel| kernel.time.mean_ms.is_some())
    }

    /// A report of times, with the facts about the device and the scene; everything else is empty.
    #[must_use]
    pub fn of(
        info: &DeviceInfo,
        scene: &Scene,
        settings: &Settings,
        setup: &Setup,
        times: &myxo::gpu::Report,
    ) -> Self {
        let was_measured = !times.is_empty();
        Self {
            device: info.name.clone(),
            driver: format!("{} {}", info.driver, info.driver_version),
            scene: scene.name.clone(),
            seed: settings.seed,
            settings: super::settings::of(scene, settings),
            samples: Some(times.steps as u64),
            particles: setup.particles.len() as u64,
            atlas_size: setup.atlas.size,
            triangles: setup.surface.triangles.len() as u64,
            arithmetic: Some(arithmetic::VERSION),
            gpu_ms_per_step: was_measured.then_some(times.step.mean_ms),
            gpu_step: if was_measured {
                Times::from(&times.step)
            } else {
                Times::default()
            },
            gpu_ms_between_kernels: was_measured.then(|| between_kernels(times)),
            ..Self::default()
        }
    }

    /// A report with the facts about the program and the host; everything else is empty.
    #[must_use]
    pub fn of_this_host() -> Self {
        Self::default().on_this_host()
    }

    /// With what is known about the program and the host.
    #[must_use]
    pub fn on_this_host(self) -> Self {
        Self {
            command: host::command(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            commit: myxo::commit(),
            processor: host::processor(),
            load_average: host::load_average(),
            ..self
        }
    }

    /// Reads a report that `--report` or `--json` has written.
    pub fn read(path: &Path) -> Result<Self> {
        let text = regular_file::read(path, LARGEST).map_err(Error::io("read", path))?;
        serde_json::from_slice(&text).map_err(|error| {
            let is_of_two = serde_json::from_slice::<Value>(&text)
                .is_ok_and(|json| json["first"].is_object() && json["second"].is_object());
            if is_of_two {
                return Error::Invalid(format!(
                    "{}: a report of `myxo profile --against`, which has both measurements and their ratio already; give \
                     reports of one each",
                    path.shown()
                ));
            }
            Error::Invalid(format!(
                "{}: not a report of `myxo render`, `export` or `profile`: {error}",
                path.shown()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_widen_the_intervals_of_steps_and_kernels() {
        let time = Times {
            median_ms: Some(2.0),
            median_low_ms: Some(1.9),
            median_high_ms: Some(2.1),
            ..Times::default()
        };
        let kernel = |name: &str| KernelTime {
            name: name.to_owned(),
            time,
            ..KernelTime::default()
        };
        let run = |step_ms, advance| Repetition {
            steps: 9,
            step_ms,
            kernels_ms: [("advance".to_owned(), advance)].into(),
        };
        let (mut step, mut kernels) = (time, [kernel("advance"), kernel("sort_scan")]);
        widen(&mut step, &mut kernels, &[run(2.5, 1.5), run(2.0, 3.0)]);
        assert_eq!(step.interval(), Some([2.0, 1.9, 2.5]));
        assert_eq!(kernels[0].time.interval(), Some([2.0, 1.5, 3.0]));
        assert_eq!(kernels[1].time, time);
    }

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
            counters: Some(Counters::default()),
            ..Report::of_this_host()
        };
        let text = report.to_json();
        assert_eq!(
            serde_json::from_str::<Report>(&text).expect("it is JSON"),
            report
        );
        let value: Value = serde_json::from_str(&text).expect("it is JSON");
        for key in [
            "device",
            "driver",
            "scene",
            "steps",
            "particles",
            "state_hash",
            "hash_is_portable",
            "arithmetic",
            "gpu_ms_per_step",
            "wall_ms_per_step",
            "kernels",
            "counters",
            "command",
            "commit",
            "processor",
            "load_average",
            "gpu_step",
            "gpu_ms_between_kernels",
            "copy_bandwidth",
            "host_load",
        ] {
            assert!(value.get(key).is_some(), "{key}");
        }
        for key in [
            "name",
            "dispatches_per_step",
            "mean_ms",
            "median_ms",
            "p95_ms",
            "std_ms",
            "min_ms",
            "max_ms",
            "share",
            "throughput",
            "gigabytes_per_second",
            "of_copy_bandwidth",
        ] {
            assert!(value["kernels"][0].get(key).is_some(), "{key}");
        }
        for key in [
            "lost",
            "doubled",
            "trail_mass",
            "selected",
            "transferred",
            "returned",
            "transfer_overflow",
            "transfer_buffer_wanted",
        ] {
            assert!(value["counters"].get(key).is_some(), "{key}");
        }
        assert_eq!(value["state_hash"], "0000000000000abc");
    }
}
