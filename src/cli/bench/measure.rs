//! Measures scenes on the device, one after the other, each several times from the beginning.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use myxo::gpu::{Context, ContextOptions, Frames, Free, GpuError, Timings, default_cache_folder};
use myxo::mesh::atlas::{AtlasError, Control};
use myxo::scene::Scene;
use myxo::sim::sorting::SORT_INTERVAL;
use myxo::sim::yardstick::{copy_bandwidth, keep_busy};
use myxo::sim::{Simulation, memory};
use myxo::{Error, Result};

use super::suite::{Case, Point};
use crate::cli::host::Watch;
use crate::cli::options::DeviceOptions;
use crate::cli::progress::{Progress, atlas_cache};
use crate::cli::report::{Bandwidth, Repetition, Times, widen};
use crate::cli::{interrupt, times};
use crate::room::{self, LARGE};

/// Frames that the host may be ahead of the device.
const FRAMES_IN_FLIGHT: usize = 2;
/// Copies that the median is taken of.
const COPIES: usize = 9;
/// A step of a case may take this long before the device counts as lost.
const PATIENCE: Duration = Duration::from_secs(900);
/// At least so many steps are measured, however long they take.
pub const FEWEST_STEPS: u32 = 3;
/// From one sort to the next steps become slower, and the step that sorts is the slowest. All of them are measured, if that takes at most
/// so many times the time of a case.
pub const PATIENCE_FOR_SORTS: u32 = 4;

/// Limits of the time that a case may take.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// Warm-up steps, which are not measured.
    pub warmup: u32,
    /// The warm-up ends after this time.
    pub warmup_time: Duration,
    /// The most steps that are measured.
    pub steps: u32,
    /// No step is begun after this time.
    pub time: Duration,
    /// A case is left out if its steps would take longer, as estimated from the case before it in its series.
    pub longest_step: Duration,
}

impl Budget {
    /// The limits of quick or whole suites, with so many steps of warm-up.
    pub fn of(is_quick: bool, warmup: u32) -> Self {
        let seconds =
            |quick: f64, whole: f64| Duration::from_secs_f64(if is_quick { quick } else { whole });
        Self {
            warmup,
            warmup_time: seconds(12.0, 150.0),
            steps: 64,
            time: seconds(0.5, 5.0),
            longest_step: seconds(1.0, 20.0),
        }
    }
}

/// A case and its results so far.
pub struct Measured {
    pub case: Case,
    timings: Timings,
    /// Medians of each run, of the step and of each kernel.
    runs: Vec<Repetition>,
    /// For each position in the interval between two sorts: was a step there measured in any run?
    places: [bool; SORT_INTERVAL as usize],
    /// Warm-up steps of the run that had the fewest.
    warmup: u32,
    pub point: Option<Point>,
    /// Why it was left out.
    pub skipped: Option<String>,
}

impl Measured {
    pub fn new(case: Case) -> Self {
        Self {
            case,
            timings: Timings::default(),
            runs: Vec::new(),
            places: [false; SORT_INTERVAL as usize],
            warmup: u32::MAX,
            point: None,
            skipped: None,
        }
    }

    /// Runs that were measured.
    pub fn runs(&self) -> usize {
        self.runs.len()
    }
}

/// An open device, and how fast it copies.
pub struct Rig {
    pub ctx: Arc<Context>,
    pub bandwidth: Option<Bandwidth>,
    pub cache: Option<PathBuf>,
}

impl Rig {
    /// Opens the chosen device.
    pub fn open(options: &DeviceOptions) -> Result<Self> {
        let ctx = Context::new(&ContextOptions {
            device: options.device.clone(),
            validation: options.validate,
            cache_folder: default_cache_folder(),
            // Scenes are as large as memory allows.
            timeout: PATIENCE,
            ..ContextOptions::default()
        })?;
        if !ctx.info().has_timestamps() {
            return Err(Error::Invalid(format!(
                "the device {} has no timestamps, by which suites of scenes are measured: choose another by --device, or \
                 the suite `mesh`",
                ctx.info().name
            )));
        }
        let bandwidth = copy_bandwidth(&ctx, COPIES)?;
        Ok(Self {
            bandwidth: bandwidth.as_ref().map(Bandwidth::from),
            cache: atlas_cache(),
            ctx,
        })
    }

    /// Refuses a scene that does not fit into the free memory with some to spare; returns about how many bytes it takes.
    pub fn check_room(&self, scene: &Scene) -> Result<u64> {
        let needed = memory::in_all(memory::needed(scene), self.ctx.info().kind);
        room::within(needed, Free::on(self.ctx.info()))?;
        Ok(needed)
    }

    /// Measures all cases once, as far as possible.
    pub fn round(
        &self,
        cases: &mut [Measured],
        budget: &Budget,
        watch: &mut Watch,
        progress: &mut Progress,
    ) -> Result<()> {
        for number in 0..cases.len() {
            if interrupt::requested() {
                return Ok(());
            }
            let (before, rest) = cases.split_at_mut(number);
            let measured = &mut rest[0];
            progress.doing(&measured.case.name());
            if measured.point.is_none() && measured.skipped.is_none() {
                measured.skipped = would_take_too_long(before, &measured.case, budget);
            }
            if measured.skipped.is_none() {
                match self.run(measured, budget, watch, progress) {
                    Ok(()) | Err(Error::Atlas(AtlasError::Cancelled)) => {}
                    Err(error) if is_fatal(&error) => return Err(error),
                    Err(error) => measured.skipped = Some(error.to_string()),
                }
            }
            progress.step();
        }
        Ok(())
    }

    /// Measures a case once.
    fn run(
        &self,
        measured: &mut Measured,
        budget: &Budget,
        watch: &mut Watch,
        progress: &Progress,
    ) -> Result<()> {
        let name = measured.case.name();
        let settings = measured.case.settings.clone();
        let scene = Scene::from_settings(name, settings, PathBuf::new())?;
        memory::check(self.ctx.info(), &scene)?;
        let needed = self.check_room(&scene)?;
        if needed > LARGE && measured.point.is_none() {
            progress.say(&format!(
                "{}: takes about {} of memory",
                scene.name,
                memory::human(needed)
            ));
        }
        let control = Control {
            cancelled: Some(interrupt::flag()),
            cache: self.cache.as_deref(),
            ..Control::default()
        };
        let mut simulation = Simulation::with_control(&self.ctx, &scene, &control)?;
        let mut frames = Frames::new(&self.ctx, FRAMES_IN_FLIGHT)?;
        let mut steps = |most: u32, whole: u32, time: Duration, frames: &mut Frames| {
            let begun = Instant::now();
            let mut done = 0;
            while done < most && should_continue(done, whole, begun.elapsed(), time) {
                if interrupt::requested() {
                    break;
                }
                let mut rec = frames.begin()?;
                rec.scope("step", |rec| simulation.record_step(rec));
                frames.submit(rec)?;
                done += 1;
            }
            frames.wait_idle()?;
            Ok::<u32, Error>(done)
        };
        let warmup = steps(budget.warmup, 0, budget.warmup_time, &mut frames)?;
        frames.timings_mut().clear();
        // The device was idle while the host set the scene up.
        if keep_busy(&self.ctx)?.is_some_and(|kept| !kept.is_steady) {
            let name = measured.case.name();
            progress.say(&format!(
                "{name}: the times of the card were not steady after 3 s; those of this case may be of a low clock"
            ));
        }
        watch.begin();
        let done = steps(budget.steps, SORT_INTERVAL as u32, budget.time, &mut frames);
        watch.end();
        // Interrupted in the warm-up.
        if done? == 0 {
            return Ok(());
        }
        let own = frames.timings().report("step");
        measured.runs.push(Repetition::from(&own));
        let end = simulation.step();
        for step in end - own.steps.min(measured.places.len()) as u64..end {
            measured.places[(step % SORT_INTERVAL) as usize] = true;
        }
        let mut timings = frames.timings().clone();
        timings.prepend(&measured.timings);
        measured.timings = timings;
        measured.warmup = measured.warmup.min(warmup);
        let point = self.point(measured, &simulation);
        measured.point = Some(point);
        Ok(())
    }

    fn point(&self, measured: &Measured, simulation: &Simulation) -> Point {
        let setup = simulation.setup();
        let report = measured.timings.report("step");
        let mut parts = times::rows(
            &report,
            times::Of {
                setup,
                segments: simulation.segments(),
                advancing: times::all_advancing(setup),
                bandwidth: self.bandwidth,
                kept_busy: None,
            },
        );
        let mut time = Times::from(&report.step);
        widen(&mut time, &mut parts, &measured.runs);
        let case = &measured.case;
        Point {
            series: case.series.clone(),
            x: case.x,
            also: case.also.clone(),
            particles: setup.particles.len() as u64,
            atlas_size: setup.atlas.size,
            triangles: setup.surface.triangles.len() as u64,
            objects: setup.poses.len(),
            memory_bytes: memory::size_in_bytes(setup, simulation.settings()),
            warmup: measured.warmup,
            steps: report.steps,
            sort_places: if simulation.settings().strategy().may_sort() {
                measured.places.iter().filter(|place| **place).count()
            } else {
                0
            },
            runs_ms: measured.runs.iter().map(|run| run.step_ms).collect(),
            time,
            parts,
            between_kernels_ms: Some(times::between_kernels(&report)),
        }
    }
}

/// Should another step be measured after `done`? Up to `whole` steps may take longer than the rest.
fn should_continue(done: u32, whole: u32, elapsed: Duration, time: Duration) -> bool {
    done < FEWEST_STEPS || elapsed < time || done < whole && elapsed < PATIENCE_FOR_SORTS * time
}

/// Errors after which the device cannot be used any more.
fn is_fatal(error: &Error) -> bool {
    matches!(
        error,
        Error::Gpu(GpuError::DeviceLost { .. } | GpuError::Timeout { .. })
    )
}

/// Why a case is left out, by the last case of its series that was measured.
fn would_take_too_long(before: &[Measured], case: &Case, budget: &Budget) -> Option<String> {
    let mut same = before.iter().rev().filter_map(|other| {
        let is_same = other.case.series == case.series && other.case.also == case.also;
        let median = other.point.as_ref()?.time.median_ms?;
        is_same.then_some(median * case.effort / other.case.effort)
    });
    let seconds = 1e-3 * same.next()?;
    let longest = budget.longest_step.as_secs_f64();
    (seconds > longest).then(|| {
        format!(
            "a step may take {seconds:.1} s, by the one before it in its series; no more than {longest:.1} s are measured"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use myxo::scene::Settings;

    fn case(x: f64) -> Case {
        Case {
            series: "a".to_owned(),
            x,
            also: Default::default(),
            settings: Settings::default(),
            effort: x,
        }
    }

    #[test]
    fn a_whole_interval_is_measured_if_that_does_not_take_much_longer() {
        let time = Duration::from_millis(100);
        let continues =
            |done, elapsed: u64| should_continue(done, 16, Duration::from_millis(elapsed), time);
        assert!(continues(2, 100_000), "too few to compare");
        assert!(continues(20, 99) && !continues(20, 100));
        assert!(continues(15, 399) && !continues(15, 400) && !continues(16, 399));
    }

    #[test]
    fn cases_that_would_take_too_long_are_left_out_by_the_case_before() {
        let mut before = Measured::new(case(10.0));
        let budget = Budget::of(true, 34);
        let next = |x| case(x);
        assert_eq!(would_take_too_long(&[], &next(1e9), &budget), None);
        before.point = Some(Point {
            time: Times {
                median_ms: Some(100.0),
                ..Times::default()
            },
            ..Point::default()
        });
        let before = [before];
        assert_eq!(would_take_too_long(&before, &next(99.0), &budget), None);
        let why = would_take_too_long(&before, &next(500.0), &budget);
        let why = why.expect("5 s are too long");
        assert!(
            why.starts_with("a step may take 5.0 s") && why.ends_with("1.0 s are measured"),
            "{why}"
        );
        let other = Case {
            series: "b".to_owned(),
            ..next(500.0)
        };
        assert_eq!(would_take_too_long(&before, &other, &budget), None);
    }
}
