//! `myxo profile --against`: two scenes, or two settings of one, take their steps in turn, so that anything that slows the machine slows
//! both.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use myxo::gpu::{Span, Statistics, Timings};
use myxo::mesh::atlas::AtlasError;
use myxo::scene::{Overrides, Scene};
use myxo::{Error, Result};
use serde::Serialize;

use super::{Profile, repeat};
use crate::cli::files::Sink;
use crate::cli::host::Watch;
use crate::cli::report::{KernelTime, Report, Times};
use crate::cli::session::{self, Earlier, Opened, Session};
use crate::cli::table::aligned;
use crate::cli::{Outcome, unless_closed};
use crate::console;

/// The fewest pairs that give an interval of the median.
const FEWEST_PAIRS: usize = 6;

/// Two measurements that took turns, as JSON.
#[derive(Clone, Debug, Serialize)]
struct Turns {
    first: Report,
    second: Report,
    /// The settings that differ, or the other scene.
    against: Vec<String>,
    /// Whole steps; `null` where the device has no timestamps, or nothing was measured.
    ratio: Option<PairRatio>,
    /// The median of each repetition, each of which restarts.
    repetitions: Vec<f64>,
    /// Each kernel that both have.
    kernels: Vec<KernelRatio>,
}

/// The ratio of a kernel's times, second to first.
#[derive(Clone, Debug, Serialize)]
struct KernelRatio {
    name: String,
    #[serde(flatten)]
    ratio: PairRatio,
}

/// The ratio of the time of a step of the second to that of a step of the first, one right after the other.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
struct PairRatio {
    /// Pairs of steps that were measured.
    pairs: usize,
    /// The median: half of the pairs have less.
    median: f64,
    /// With `high`: where the median of very many pairs lies with 95 % confidence, and at least from the lowest median of a
    /// repetition to the highest; `null` of fewer than six pairs.
    low: Option<f64>,
    high: Option<f64>,
    /// A quarter of the pairs has less; a quarter has more than `upper_quartile`.
    lower_quartile: f64,
    upper_quartile: f64,
    /// The ratio of the times of all steps together.
    of_sums: f64,
}

impl PairRatio {
    /// Pairs the steps of both in order, without those that one of them does not have.
    fn of(first_ms: &[f64], second_ms: &[f64]) -> Option<Self> {
        let pairs = first_ms.iter().zip(second_ms);
        let pairs = pairs.filter(|(a, b)| **a > 0.0 && **b > 0.0);
        let sums = pairs
            .clone()
            .fold([0.0, 0.0], |sums, (a, b)| [sums[0] + a, sums[1] + b]);
        let mut ratios: Vec<f64> = pairs.map(|(a, b)| b / a).collect();
        if ratios.is_empty() {
            return None;
        }
        ratios.sort_by(f64::total_cmp);
        let at = |part: f64| {
            let place = part * (ratios.len() - 1) as f64;
            let below = ratios[place as usize];
            below + place.fract() * (ratios[place.ceil() as usize] - below)
        };
        // The fields of the statistics are named after milliseconds, but here they are ratios.
        let spread = Statistics::of(ratios.clone());
        let known = (ratios.len() >= FEWEST_PAIRS).then_some(spread);
        Some(Self {
            pairs: ratios.len(),
            median: spread.median_ms,
            low: known.map(|spread| spread.median_low_ms),
            high: known.map(|spread| spread.median_high_ms),
            lower_quartile: at(0.25),
            upper_quartile: at(0.75),
            of_sums: sums[1] / sums[0],
        })
    }

    /// Widens the interval by the medians of the repetitions.
    fn with(mut self, medians: &[f64]) -> Self {
        for &median in medians {
            self.low = self.low.map(|low| low.min(median));
            self.high = self.high.map(|high| high.max(median));
        }
        self
    }

    fn interval(&self) -> String {
        match (self.low, self.high) {
            (Some(low), Some(high)) => format!("{low:.3} - {high:.3}"),
            _ => String::new(),
        }
    }
}

/// The scene that is measured against the first: another one, or the same with keys that are set otherwise.
pub fn other(profile: &Profile, scene: &Path) -> Result<Scene> {
    // Options of a mesh have signs of equality, and so may files.
    let is_scene = |text: &&String| {
        !text.contains('=') || text.starts_with("builtin:") || Path::new(text).is_file()
    };
    let (scenes, keys): (Vec<&String>, Vec<&String>) = profile.against.iter().partition(is_scene);
    let scene = match scenes[..] {
        [] => scene.to_owned(),
        [other] => PathBuf::from(other),
        [one, two, ..] => {
            return Err(Error::Invalid(format!(
                "--against names two scenes, `{one}` and `{two}`: one is measured against one"
            )));
        }
    };
    let mut overrides: Overrides = profile.common.scene.overrides();
    let is_seed = |text: &&String| {
        text.split('=')
            .next()
            .is_some_and(|key| key.trim() == "seed")
    };
    if keys.iter().any(is_seed) {
        overrides.seed = None;
    }
    overrides.set.extend(keys.into_iter().cloned());
    Ok(Scene::load(&scene, &overrides)?)
}

/// Measures both, and prints the result.
pub fn run(profile: &Profile, scenes: &[Scene; 2], sink: Option<Sink>) -> Result<Outcome> {
    let mut watch = Watch::new();
    let device = &profile.common.device;
    if device.validate {
        console::message("the validation layers are on: these times are not worth comparing");
    }
    if scenes[0].settings == scenes[1].settings {
        console::message(
            "both are the same: the ratio shows how far chance alone may go, such as where buffers come to lie",
        );
    }
    let opened = session::device(device, scenes)?;
    let mut earlier = [Earlier::default(), Earlier::default()];
    let mut medians: Vec<f64> = Vec::new();
    let mut turns: Option<Turns> = None;
    let mut completed = true;
    for _ in 0..profile.repeat {
        let mut both = match Both::open(&opened, scenes, profile) {
            // Ctrl-C: there are the results of the repetitions before.
            Err(Error::Atlas(AtlasError::Cancelled)) if turns.is_some() => {
                completed = false;
                break;
            }
            both => both?,
        };
        profile.common.check_outputs(profile.report.iter())?;
        completed = both.measure(profile, &mut watch)?;
        let [first, second] = both.timings();
        let ratio = PairRatio::of(&times_ms(first, "step"), &times_ms(second, "step"));
        medians.extend(ratio.map(|ratio| ratio.median));
        // Devices without timestamps give no medians; the command succeeds anyway.
        turns = Some(both.turns(profile, &watch, &mut earlier, &medians)?);
        if !completed {
            break;
        }
    }
    let mut turns = turns.expect("there is at least one repetition");
    for report in [&mut turns.first, &mut turns.second] {
        report.interrupted = !completed;
    }
    if let Some(warning) = watch.load().warning() {
        console::message(&warning);
    }
    // The file is written even if nothing can be printed.
    let printed = console::print(if profile.json {
        turns.to_json()
    } else {
        turns.text()
    });
    if let Some(sink) = sink {
        unless_closed(sink.write(turns.to_json()))?;
    }
    unless_closed(printed)?;
    Ok(if completed {
        Outcome::Done
    } else {
        Outcome::Interrupted
    })
}

/// The sessions of both scenes.
struct Both {
    sessions: [Session; 2],
    /// How long the host waited for each.
    wall: [Duration; 2],
    /// Steps done by each.
    pairs: u32,
}

impl Both {
    fn open(opened: &Opened, [first, second]: &[Scene; 2], profile: &Profile) -> Result<Self> {
        let steps = u64::from(profile.warmup) + u64::from(profile.steps);
        let mut first = Session::on(opened, first.clone(), &profile.common, steps)?;
        // One bar is enough.
        first.progress.silence();
        let mut second = Session::on(opened, second.clone(), &profile.common, steps)?;
        for session in [&mut first, &mut second] {
            session.separates = true;
        }
        Ok(Self {
            sessions: [first, second],
            wall: [Duration::ZERO; 2],
            pairs: 0,
        })
    }

    /// Takes the steps in turn; returns whether all were done.
    fn measure(&mut self, profile: &Profile, watch: &mut Watch) -> Result<bool> {
        let warm = repeat(profile.warmup, || self.step())?;
        for session in &mut self.sessions {
            session.keep_busy()?;
            session.begin_measuring(profile.steps as usize, false)?;
        }
        self.wall = [Duration::ZERO; 2];
        watch.begin();
        let completed = warm && repeat(profile.steps, || self.step())?;
        watch.end();
        Ok(completed)
    }

    /// A step of each, one after the other. The order alternates, so that neither always runs with the caches as the other has left them.
    fn step(&mut self) -> Result<()> {
        let first = (self.pairs % 2) as usize;
        self.pairs += 1;
        for which in [first, 1 - first] {
            let begun = Instant::now();
            self.sessions[which].step()?;
            self.sessions[which].frames.wait_idle()?;
            self.wall[which] += begun.elapsed();
        }
        Ok(())
    }

    fn timings(&self) -> [&Timings; 2] {
        self.sessions
            .each_ref()
            .map(|session| session.frames.timings())
    }

    /// The results of a repetition together with all before. Its sessions end here, as the device may have no room for others beside
    /// them.
    fn turns(
        mut self,
        profile: &Profile,
        watch: &Watch,
        earlier: &mut [Earlier; 2],
        medians: &[f64],
    ) -> Result<Turns> {
        let mut report = |which: usize| {
            let session = &mut self.sessions[which];
            let mut ending = session.finish()?;
            ending.wall = self.wall[which];
            session.progress.finish();
            session.add_earlier(&mut earlier[which], &mut ending);
            let mut report = session.report(&ending, false);
            report.host_load = Some(watch.load());
            report.warmup = Some(profile.warmup.into());
            Ok::<Report, Error>(report)
        };
        let (first, second) = (report(0)?, report(1)?);
        let [a, b] = self.timings();
        let ratio = |name: &str| PairRatio::of(&times_ms(a, name), &times_ms(b, name));
        let kernel = |kernel: &KernelTime| {
            let name = kernel.name.clone();
            ratio(&name).map(|ratio| KernelRatio { name, ratio })
        };
        Ok(Turns {
            against: profile.against.clone(),
            ratio: ratio("step").map(|ratio| ratio.with(medians)),
            repetitions: medians.to_vec(),
            kernels: first.kernels.iter().filter_map(kernel).collect(),
            first,
            second,
        })
    }
}

impl Turns {
    fn to_json(&self) -> String {
        let json = serde_json::to_string_pretty(self);
        json.expect("reports are plain numbers and texts") + "\n"
    }

    fn text(&self) -> String {
        let head = format!(
            "{} ({})\nfirst   {}\nsecond  {} with {}\n\n",
            self.first.device,
            self.first.driver,
            self.first.scene,
            self.second.scene,
            self.against.join(" ")
        );
        head + &self.table() + &self.conclusion()
    }

    fn table(&self) -> String {
        let header = [
            "median ms",
            "first",
            "second",
            "ratio of pairs",
            "95 % interval",
        ];
        let mut rows = vec![header.map(str::to_owned)];
        let shown = |time: Option<&Times>| {
            let median = time.and_then(|time| time.median_ms);
            median.map_or("-".to_owned(), |ms| format!("{ms:.3}"))
        };
        let mut row =
            |name: &str, a: Option<&Times>, b: Option<&Times>, ratio: Option<&PairRatio>| {
                let [value, interval] = match ratio {
                    Some(ratio) => [format!("{:.3}", ratio.median), ratio.interval()],
                    None => ["-".to_owned(), String::new()],
                };
                rows.push([name.to_owned(), shown(a), shown(b), value, interval]);
            };
        let [first, second] = [&self.first, &self.second];
        let steps = [first, second].map(|report| Some(&report.gpu_step));
        row("whole step", steps[0], steps[1], self.ratio.as_ref());
        let time = |report: &'_ Report, name: &str| {
            let kernel = report.kernels.iter().find(|kernel| kernel.name == name);
            kernel.map(|kernel| kernel.time)
        };
        let only_second = second.kernels.iter();
        let only_second = only_second.filter(|kernel| time(first, &kernel.name).is_none());
        for KernelTime { name, .. } in first.kernels.iter().chain(only_second) {
            let ratio = self.kernels.iter().find(|kernel| kernel.name == *name);
            let [a, b] = [first, second].map(|report| time(report, name));
            row(
                name,
                a.as_ref(),
                b.as_ref(),
                ratio.map(|kernel| &kernel.ratio),
            );
        }
        aligned(&rows, None)
    }

    fn conclusion(&self) -> String {
        let Some(ratio) = &self.ratio else {
            let why = match self.first.steps {
                0 => "no step was measured",
                _ => "the device has no timestamps",
            };
            return format!("\nThere is no ratio: {why}.\n");
        };
        let pairs = match ratio.pairs {
            1 => "the only pair".to_owned(),
            pairs => format!("the median of {pairs} pairs"),
        };
        let interval = match ratio.interval() {
            none if none.is_empty() => String::new(),
            interval => format!(", {interval} with 95 %"),
        };
        let mut text = format!(
            "\nA step of the second takes {:.3} times as long as the first's before or after it: {pairs}{interval}.\n\
             Half of the pairs have {:.3} - {:.3}; all steps together {:.3}.\n",
            ratio.median, ratio.lower_quartile, ratio.upper_quartile, ratio.of_sums
        );
        text += &match &self.repetitions[..] {
            [] | [_] => "One run: the interval does not include changes from run to run, such as the places of buffers in memory; \
                         --repeat includes them.\n"
                .to_owned(),
            medians => {
                let medians: Vec<String> = medians.iter().map(|m| format!("{m:.3}")).collect();
                format!("{} repetitions, each from the beginning: medians {}.\n", medians.len(), medians.join(", "))
            }
        };
        text
    }
}

/// The device's time in each frame, oldest first: of a scope, or of all runs of a kernel.
fn times_ms(timings: &Timings, name: &str) -> Vec<f64> {
    let of_frame = |spans: &[Span]| {
        spans
            .iter()
            .filter(|span| span.name == name)
            .map(Span::ms)
            .sum()
    };
    timings.frames().map(of_frame).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_minute_does_not_change_the_ratios_of_pairs() {
        // The machine becomes ten times slower; the second always takes 1.5 times as long, but once.
        let slow = |step: usize| if step < 10 { 1.0 } else { 10.0 };
        let first: Vec<f64> = (0..20).map(slow).collect();
        let mut second: Vec<f64> = first.iter().map(|ms| 1.5 * ms).collect();
        second[0] = 8.0;
        let ratio = PairRatio::of(&first, &second).expect("there are pairs");
        assert_eq!((ratio.pairs, ratio.median), (20, 1.5));
        assert_eq!((ratio.low, ratio.high), (Some(1.5), Some(1.5)));
        assert_eq!((ratio.lower_quartile, ratio.upper_quartile), (1.5, 1.5));
        assert!((ratio.of_sums - (165.0 + 6.5) / 110.0).abs() < 1e-12);
        let wide = ratio.with(&[1.25, 1.5, 1.75]);
        assert_eq!((wide.low, wide.high), (Some(1.25), Some(1.75)));
        assert_eq!(wide.interval(), "1.250 - 1.750");
    }

    #[test]
    fn few_pairs_have_no_interval_and_steps_that_one_lacks_are_no_pair() {
        let ratio = PairRatio::of(&[1.0, 2.0], &[8.0, 3.0, 5.0]).expect("there are pairs");
        assert_eq!((ratio.pairs, ratio.median), (2, 4.75));
        assert_eq!((ratio.low, ratio.interval()), (None, String::new()));
        assert_eq!((ratio.lower_quartile, ratio.upper_quartile), (3.125, 6.375));
        // A kernel that runs in every second step.
        let ratio = PairRatio::of(&[1.0, 0.0, 1.0, 0.0], &[2.0, 0.0, 4.0, 7.0]);
        assert_eq!(
            ratio.map(|ratio| (ratio.pairs, ratio.median)),
            Some((2, 3.0))
        );
        assert_eq!(PairRatio::of(&[], &[1.0]), None);
        assert_eq!(PairRatio::of(&[0.0], &[1.0]), None, "no timestamps");
    }
}
