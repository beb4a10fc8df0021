//! Measurements while the lab runs: frames and steps a second, GPU times and memory, collected in [`Facts`].

use std::time::{Duration, Instant};

use myxo::gpu::{Context, Frames, Span, SpanKind};

use crate::lab::facts::{Facts, KernelTime, Times};
use crate::lab::pacing::Pacer;
use crate::lab::stage::Stage;
use crate::measured::recent::RecentTimes;

/// How often figures change: often enough to follow, seldom enough to read.
const INTERVAL: Duration = Duration::from_millis(500);
/// On slow devices a step comes every few frames; their figures are shown only after a step, or after this much time.
const WITHOUT_STEPS: Duration = Duration::from_secs(3);
/// A longer pause between two frames is no slow frame: nothing had to be drawn.
const PAUSE: Duration = Duration::from_millis(700);
/// How much one frame weighs in the pace that is shown.
const NEW_FRAME: f64 = 0.1;
/// Frames with steps in them that times are averaged over, however many without steps have come since.
const FRAMES_AVERAGED: usize = 64;

/// Counts frames and steps, and reads the GPU's timers.
pub struct Clocks {
    last_frame: Instant,
    /// Until when `since_presented` counts.
    counted_until: Instant,
    /// The time of frames since the last one that was presented, without pauses.
    since_presented: Duration,
    interval_began: Instant,
    /// Since when `steps` counts.
    steps_began: Instant,
    /// Mean time from one frame that was presented to the next, seconds; 0 before the first.
    frame_seconds: f64,
    steps: u32,
    /// The measurements of the times that are frozen, for files.
    frozen: Option<RecentTimes>,
    /// The figures as they are shown.
    pub facts: Facts,
}

impl Clocks {
    /// Begins to count.
    pub fn new(ctx: &Context, frames: &mut Frames) -> Self {
        let timings = frames.timings_mut();
        timings.set_capacity_of("step", FRAMES_AVERAGED);
        let info = ctx.info();
        Self {
            last_frame: Instant::now(),
            counted_until: Instant::now(),
            since_presented: Duration::ZERO,
            interval_began: Instant::now(),
            steps_began: Instant::now(),
            frame_seconds: 0.0,
            steps: 0,
            frozen: None,
            facts: Facts {
                device: format!("{}, {} {}", info.name, info.driver, info.driver_version),
                has_timestamps: info.has_timestamps(),
                ..Facts::default()
            },
        }
    }

    /// Counts again on another device. The scene is the same, and frozen times stay.
    pub fn on(self, ctx: &Context, frames: &mut Frames) -> Self {
        let mut clocks = Self::new(ctx, frames);
        clocks.frozen = self.frozen;
        clocks.facts.frozen = self.facts.frozen;
        clocks.facts.scene = self.facts.scene;
        clocks
    }

    /// A frame begins: how long after the last one?
    pub fn tick(&mut self) -> Duration {
        self.catch_up();
        let since = self.counted_until - self.last_frame;
        self.last_frame = self.counted_until;
        since
    }

    /// Something is shown within a frame.
    pub fn catch_up(&mut self) {
        let now = Instant::now();
        let since = now - self.counted_until;
        self.counted_until = now;
        if since < PAUSE {
            self.since_presented += since;
        }
    }

    /// The window shows a new frame.
    pub fn presented(&mut self) {
        let seconds = std::mem::take(&mut self.since_presented).as_secs_f64();
        let weight = if self.frame_seconds == 0.0 {
            1.0
        } else {
            NEW_FRAME
        };
        self.frame_seconds += weight * (seconds - self.frame_seconds);
    }

    /// A frame with this many steps was submitted. Teaches the pacer what steps cost.
    pub fn submitted(
        &mut self,
        steps: u32,
        ctx: &Context,
        frames: &Frames,
        stage: &Stage,
        pacer: &mut Pacer,
    ) {
        self.steps += steps;
        self.facts.step = stage.simulation.step();
        self.facts.seconds = stage.seconds();
        self.facts.particles_drawn = stage.particles_drawn;
        self.facts.brightest = stage.brightest;
        self.facts.flow = stage.flow;
        self.facts.population = stage.population;
        self.facts.flaws = stage.flaws;
        self.facts.is_plain = stage.is_plain;
        self.facts.undeveloped = stage.undeveloped();
        if let Some(spans) = frames.timings().frames().last() {
            self.facts.times.history.push(spans);
            // Of frames without steps only the newest is kept, so the mean runs along. Pictures at rest take longer, and do not count.
            let times = &mut self.facts.times;
            let counts = stage.drew_moving || times.draw_ms.is_none();
            if let Some(ms) = draw_ms(spans).filter(|_| counts) {
                let before = times.draw_ms.unwrap_or(ms);
                times.draw_ms = Some(before + NEW_FRAME * (ms - before));
            }
        }
        if let Some(step) = latest_step(frames) {
            pacer.measured(step);
        } else if steps > 0 && !ctx.info().has_timestamps() {
            // Without timestamps the frame's own length has to do.
            pacer.measured(self.last_frame.elapsed() / steps);
        }
        if self.interval_began.elapsed() >= INTERVAL {
            self.facts.frames_per_second = 1.0 / self.frame_seconds.max(1e-4);
            let counted = self.steps_began.elapsed();
            if self.steps > 0 || counted >= WITHOUT_STEPS {
                self.facts.steps_per_second = f64::from(self.steps) / counted.as_secs_f64();
                self.steps = 0;
                self.steps_began = Instant::now();
            }
            self.interval_began = Instant::now();
            self.read_timers(frames);
            self.facts.memory = memory(ctx);
        }
    }

    /// Drops old figures, for another scene or for a restart.
    pub fn restart(&mut self, frames: &mut Frames, stage: &Stage) {
        frames.timings_mut().clear();
        let setup = stage.simulation.setup();
        let facts = &mut self.facts;
        facts.scene = stage.scene.name.clone();
        facts.step = stage.simulation.step();
        facts.seconds = stage.seconds();
        facts.triangles = setup.surface.corners.len();
        facts.texels = setup.atlas.owned_count as usize;
        facts.times = Times::default();
        facts.check = None;
    }

    /// Restarts the measurement of times.
    pub fn clear_times(&mut self, frames: &mut Frames) {
        frames.timings_mut().clear();
        self.facts.times = Times::default();
        self.unfreeze_times();
    }

    /// Keeps the times as they are now, until [`Self::unfreeze_times`].
    pub fn freeze_times(&mut self, ctx: &Context, frames: &Frames, stage: &Stage) {
        // What is shown is then what files get.
        self.read_timers(frames);
        self.frozen = self.measured_now(ctx, frames, stage);
        self.facts.frozen = Some(self.facts.times.clone());
    }

    /// Shows the times that come again.
    pub fn unfreeze_times(&mut self) {
        self.frozen = None;
        self.facts.frozen = None;
    }

    /// The measurements of the times that are shown, for files; none if there are no steps among them.
    pub fn measured(&self, ctx: &Context, frames: &Frames, stage: &Stage) -> Option<RecentTimes> {
        match &self.facts.frozen {
            Some(_) => self.frozen.clone(),
            None => self.measured_now(ctx, frames, stage),
        }
    }

    fn measured_now(&self, ctx: &Context, frames: &Frames, stage: &Stage) -> Option<RecentTimes> {
        let pace = self.facts.steps_per_second;
        RecentTimes::new(ctx, &stage.scene, &stage.simulation, frames.timings(), pace)
    }

    /// Shows the times of steps, if there are any.
    fn read_timers(&mut self, frames: &Frames) {
        let report = frames.timings().report("step");
        if report.steps == 0 {
            return;
        }
        let times = &mut self.facts.times;
        times.step_ms = Some(report.step.mean_ms);
        let kernels: f64 = report.rows.iter().map(|row| row.time.mean_ms).sum();
        times.between_ms = (report.step.mean_ms - kernels).max(0.0);
        times.host_ms = times.draw_ms.map(|draw| {
            let steps = self.facts.steps_per_second * self.frame_seconds;
            (1e3 * self.frame_seconds - draw - steps * report.step.mean_ms).max(0.0)
        });
        self.facts.times.kernels = report
            .rows
            .iter()
            .map(|row| KernelTime {
                name: row.name.clone(),
                per_step: row.dispatches_per_step,
                mean_ms: row.time.mean_ms,
                p95_ms: row.time.p95_ms,
                share: row.share,
            })
            .collect();
    }
}

/// The mean time of the steps in the last frame that was measured, if it had any.
fn latest_step(frames: &Frames) -> Option<Duration> {
    let spans = frames.timings().frames().last()?;
    let steps: Vec<f64> = spans
        .iter()
        .filter(|span| span.kind == SpanKind::Scope && span.name == "step")
        .map(Span::ms)
        .collect();
    let mean = steps.iter().sum::<f64>() / steps.len().max(1) as f64;
    (mean > 0.0).then(|| Duration::from_secs_f64(1e-3 * mean))
}

/// The GPU time of a frame without its steps, milliseconds; none if it draws nothing.
fn draw_ms(spans: &[Span]) -> Option<f64> {
    let is_step = |span: &&Span| span.kind == SpanKind::Scope && span.name == "step";
    let steps: f64 = spans.iter().filter(is_step).map(Span::ms).sum();
    let draws = spans.iter().any(|span| span.kind == SpanKind::Draw);
    draws.then(|| (spans[0].ms() - steps).max(0.0))
}

/// Bytes of device memory in use by this program.
fn memory(ctx: &Context) -> u64 {
    ctx.allocated().values().sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::on_device::{SMALL, context, stage};

    /// A frame of one kernel.
    fn frame(kind: SpanKind, ms: f64) -> Vec<Span> {
        let span = |name: &str, kind, parent| Span {
            name: name.to_owned(),
            kind,
            parent,
            begin_ns: 0.0,
            end_ns: ms * 1e6,
        };
        vec![
            span("frame", SpanKind::Frame, None),
            span("step", kind, Some(0)),
            span("advance", SpanKind::Kernel, Some(1)),
        ]
    }

    #[test]
    fn times_stay_while_the_simulation_is_held() {
        let Some(ctx) = context() else { return };
        let mut frames = Frames::new(&ctx, 2).unwrap();
        let mut clocks = Clocks::new(&ctx, &mut frames);
        for ms in 1..=FRAMES_AVERAGED {
            let timings = frames.timings_mut();
            timings.push(frame(SpanKind::Scope, ms as f64));
        }
        clocks.read_timers(&frames);
        let before = clocks.facts.times.kernels.clone();
        assert_eq!(before[0].mean_ms, 0.5 * (1 + FRAMES_AVERAGED) as f64);
        for _ in 0..2 * FRAMES_AVERAGED {
            // No step, though something is drawn.
            frames.timings_mut().push(frame(SpanKind::Draw, 9.0));
            clocks.read_timers(&frames);
            assert_eq!(clocks.facts.times.kernels, before);
        }
    }

    #[test]
    fn frozen_times_are_measured_times_whatever_comes() {
        let Some(ctx) = context() else { return };
        let mut frames = Frames::new(&ctx, 2).unwrap();
        let mut clocks = Clocks::new(&ctx, &mut frames);
        let stage = stage(&ctx, "cube", &SMALL);
        let report = |clocks: &Clocks, frames: &Frames| {
            let measured = clocks.measured(&ctx, frames, &stage);
            // The host's load changes meanwhile.
            measured.map(|measured| {
                let report: serde_json::Value = serde_json::from_str(&measured.report()).unwrap();
                (report["gpu_ms_per_step"].clone(), report["kernels"].clone())
            })
        };
        assert_eq!(report(&clocks, &frames), None);
        frames.timings_mut().push(frame(SpanKind::Scope, 2.0));
        let first = report(&clocks, &frames);
        clocks.freeze_times(&ctx, &frames, &stage);
        assert_eq!(clocks.facts.shown_times().step_ms, Some(2.0));
        frames.timings_mut().push(frame(SpanKind::Scope, 4.0));
        clocks.read_timers(&frames);
        assert_eq!(clocks.facts.shown_times().step_ms, Some(2.0));
        assert!(first.is_some() && report(&clocks, &frames) == first);
        // Another device has measured nothing yet.
        let mut frames = Frames::new(&ctx, 2).unwrap();
        let mut clocks = clocks.on(&ctx, &mut frames);
        assert_eq!(report(&clocks, &frames), first);
        for ms in [2.0, 4.0] {
            frames.timings_mut().push(frame(SpanKind::Scope, ms));
        }
        clocks.read_timers(&frames);
        clocks.unfreeze_times();
        assert_eq!(clocks.facts.shown_times().step_ms, Some(3.0));
        assert_ne!(report(&clocks, &frames), first);
        // Frozen before there is a step, they stay without one.
        clocks.clear_times(&mut frames);
        clocks.freeze_times(&ctx, &frames, &stage);
        frames.timings_mut().push(frame(SpanKind::Scope, 4.0));
        clocks.read_timers(&frames);
        assert_eq!(
            (report(&clocks, &frames), clocks.facts.shown_times().step_ms),
            (None, None)
        );
        clocks.clear_times(&mut frames);
        assert!(clocks.facts.frozen.is_none(), "it shows what comes");
    }
}
