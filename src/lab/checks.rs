//! Checks of the invariants while the window is open: now and then, because each one waits for the device and reads the
//! whole state.

use crate::lab::facts::Check;
use std::time::{Duration, Instant};

use myxo::Result;
use myxo::gpu::Frames;
use myxo::sim::Simulation;

/// From one check to the next.
const INTERVAL: Duration = Duration::from_secs(1);
/// The most of all time that checks take; of large scenes there are fewer.
const MOST_TIME: f64 = 0.1;

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

    /// Resets the checks for another scene, or for a restart.
    pub fn restart(&mut self) {
        *self = Self::new();
    }

    /// The problem that was found, if any.
    pub fn problem(&self) -> Option<&str> {
        self.last.as_ref()?.problem.as_deref()
    }

    /// Checks, if that is due and there was a step since the last time. All recorded work must have been submitted. Returns
    /// true if it has checked.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::on_device::{SMALL, context, run, scene};

    #[test]
    fn broken_invariants_are_found_and_stay_reported() {
        let Some(ctx) = context() else { return };
        let scene = scene("cube", &SMALL);
        let mut simulation = Simulation::new(&ctx, &scene).unwrap();
        let mut frames = Frames::new(&ctx, 2).unwrap();
        let mut checks = Checks::new();
        assert!(!checks.look(&mut frames, &simulation).unwrap(), "no step");
        run(&mut frames, &mut simulation, 1);
        assert!(checks.look(&mut frames, &simulation).unwrap());
        let last = checks.last.clone().unwrap();
        assert_eq!((last.step, last.problem), (1, None));
        assert!(last.share > 0.0 && last.share <= MOST_TIME + 1e-9);
        run(&mut frames, &mut simulation, 1);
        assert!(!checks.look(&mut frames, &simulation).unwrap(), "too soon");
        checks.due = Instant::now();
        assert!(checks.look(&mut frames, &simulation).unwrap());
        checks.due = Instant::now();
        assert!(!checks.look(&mut frames, &simulation).unwrap(), "no step");

        // One particle twice.
        let mut particles = ctx.download(&simulation.state().particles).unwrap();
        particles[7].id = 8;
        let state = simulation.state();
        ctx.upload(&state.particles, &particles).unwrap();
        for _ in 0..2 {
            run(&mut frames, &mut simulation, 1);
            checks.due = Instant::now();
            checks.look(&mut frames, &simulation).unwrap();
            let problem = checks.problem().expect("something is wrong");
            assert!(
                problem.starts_with("after step 3: 1 particles are lost and 1 doubled"),
                "{problem}"
            );
        }
        checks.restart();
        assert_eq!(checks.problem(), None);
        frames.wait_idle().unwrap();
        assert_eq!(ctx.messages(), [""; 0]);
    }
}
