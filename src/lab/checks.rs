//! Checks of the invariants while the window is open: now and then, because each one waits for the device and reads the
//! whole state.

use std::time::{Duration, Instant};

use myxo::Result;
use myxo::gpu::Frames;
use myxo::sim::Simulation;

/// From one check to the next.
const INTERVAL: Duration = Duration::from_secs(1);
/// The most of all time that checks take; of large scenes there are fewer.
const MOST_TIME: f64 = 0.1;

/// What a check has found.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// The steps that had been taken.
    pub step: u64,
    /// How long it took.
    pub took: Duration,
    /// What of all time that is until the next one.
    pub share: f64,
    /// What is wrong, if anything is. The first problem stays.
    pub problem: Option<String>,
}

/// When to check, and what was found last.
#[derive(Debug)]
pub struct Checks {
    due: Instant,
    /// The last one.
    pub last: Option<Check>,
}

impl Checks {
    /// Nothing has been checked.
    pub fn new() -> Self {
        Self {
            due: Instant::now(),
            last: None,
        }
    }

    /// Another scene, or the same from the beginning.
    pub fn restart(&mut self) {
        *self = Self::new();
    }

    /// What was found to be wrong, if anything was.
    pub fn problem(&self) -> Option<&str> {
        self.last.as_ref()?.problem.as_deref()
    }

    /// Checks, if that is due and there was a step since the last time. All that was recorded has been submitted. True if
    /// it was checked.
    pub fn look(&mut self, frames: &mut Frames, simulation: &Simulation) -> Result<bool> {
        let began = Instant::now();
        let step = simulation.step();
        let is_known = self.last.as_ref().is_some_and(|last| last.step == step);
        if began < self.due || step == 0 || is_known || self.problem().is_some() {
            return Ok(false);
        }
        frames.wait_idle()?;
        let found = simulation.snapshot()?.validate(simulation.setup());
        let took = began.elapsed();
        let pause = took.mul_f64(1.0 / MOST_TIME - 1.0).max(INTERVAL);
        self.due = Instant::now() + pause;
        self.last = Some(Check {
            step,
            took,
            share: took.as_secs_f64() / (took + pause).as_secs_f64(),
            problem: found
                .err()
                .map(|problem| format!("after step {step}: {problem}")),
        });
        Ok(true)
    }
}
