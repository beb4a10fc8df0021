//! How many steps a frame takes: as many as fit, so that the interface stays quick on every device.
//!
//! Time that passes earns credit, and a step spends what it costs. A fast device earns enough for many steps in a
//! frame; on a slow one a step is dearer than a frame earns, and a few frames without a step come before the next.

use std::time::Duration;

/// The share of the time that steps may take.
const SHARE: f64 = 0.75;
/// The share of the time that steps may take while the user drags.
const SHARE_WHILE_TOUCHED: f64 = 0.4;
/// Credit for longer than this is lost: after a stall nothing is made up for.
const LONGEST_FRAME: f64 = 0.1;
/// The most steps in one frame, so that one command buffer stays small.
const MOST_STEPS: u32 = 256;
/// The steps of one frame take no longer, except a single step: while they run, input has no answer.
const LONGEST_STEPS: f64 = 0.065;
/// While the user waits for each picture.
const LONGEST_STEPS_WHILE_TOUCHED: f64 = 0.03;
/// If steps take longer than this, their picture is drawn in a frame of its own.
const NOTABLE: f64 = 0.02;
/// How much one measurement weighs in the estimate of a step's cost.
const NEW_MEASUREMENT: f64 = 0.2;

/// Decides the number of steps of each frame.
#[derive(Clone, Debug)]
pub struct Pacer {
    /// The cost of a step, seconds; a cautious guess until the first measurement.
    step_seconds: f64,
    measured: bool,
    /// Seconds of work earned and not spent.
    credit: f64,
    /// Steps that the cap on steps a second allows and that were not taken.
    allowed: f64,
}

impl Default for Pacer {
    fn default() -> Self {
        Self {
            step_seconds: 0.02,
            measured: false,
            credit: 0.0,
            allowed: 0.0,
        }
    }
}

impl Pacer {
    /// Learns what a step has cost on the device.
    pub fn measured(&mut self, step: Duration) {
        let seconds = step.as_secs_f64();
        let weight = if self.measured { NEW_MEASUREMENT } else { 1.0 };
        self.step_seconds += weight * (seconds - self.step_seconds);
        self.measured = true;
    }

    /// The estimated cost of a step.
    #[cfg(test)]
    pub fn step_time(&self) -> Option<Duration> {
        self.measured
            .then(|| Duration::from_secs_f64(self.step_seconds))
    }

    /// The number of steps for a frame that begins `since_last` after the one before it.
    ///
    /// `steps_per_second` is the user's cap, 0 for none; `touched` says that the user is moving the camera, or is about to see a look.
    /// A frame that `waits` takes none, and saves up, within the same bounds.
    pub fn steps(
        &mut self,
        since_last: Duration,
        steps_per_second: f32,
        touched: bool,
        waits: bool,
    ) -> u32 {
        let cost = self.step_seconds.max(1e-6);
        let seconds = since_last.as_secs_f64().min(LONGEST_FRAME);
        let share = if touched { SHARE_WHILE_TOUCHED } else { SHARE };
        // At least one step can always be saved for, however dear it is.
        self.credit = (self.credit + share * seconds).min(cost.max(share * LONGEST_FRAME));
        if cost > LONGEST_FRAME && !touched {
            // Otherwise many equal pictures would be drawn between two steps.
            self.credit = cost;
        }
        let longest = if touched {
            LONGEST_STEPS_WHILE_TOUCHED
        } else {
            LONGEST_STEPS
        };
        let most = ((longest / cost) as u32).clamp(1, MOST_STEPS);
        let mut steps = ((self.credit / cost) as u32).min(if waits { 0 } else { most });
        if steps_per_second > 0.0 {
            let rate = f64::from(steps_per_second);
            self.allowed = (self.allowed + rate * seconds).min(1.0 + rate * LONGEST_FRAME);
            steps = steps.min(self.allowed as u32);
            self.allowed -= f64::from(steps);
        }
        self.credit -= f64::from(steps) * cost;
        steps
    }

    /// Do so many steps take long enough to be felt?
    pub fn are_notable(&self, steps: u32) -> bool {
        f64::from(steps) * self.step_seconds > NOTABLE
    }

    /// Do they take longer than a user should wait?
    pub fn are_long(&self, steps: u32) -> bool {
        f64::from(steps) * self.step_seconds > LONGEST_STEPS
    }

    /// Forgets what was earned, as after a pause.
    pub fn restart(&mut self) {
        self.credit = 0.0;
        self.allowed = 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten seconds of frames that take `frame` plus what their steps cost: (steps a second, longest frame).
    fn run(step: f64, frame: f64, cap: f32, touched: bool) -> (f64, f64) {
        let mut pacer = Pacer::default();
        pacer.measured(Duration::from_secs_f64(step));
        let (mut time, mut total, mut longest, mut last) = (0.0, 0, 0.0_f64, 0.0);
        while time < 10.0 {
            let steps = pacer.steps(Duration::from_secs_f64(last), cap, touched, false);
            last = frame + f64::from(steps) * step;
            longest = longest.max(last);
            time += last;
            total += steps;
        }
        (f64::from(total) / time, longest)
    }

    #[test]
    fn a_slow_device_steps_most_of_the_time_and_no_frame_has_two() {
        let (rate, longest) = run(0.08, 0.02, 0.0, false);
        assert!((0.6..0.8).contains(&(rate * 0.08)), "{rate} steps a second");
        assert!(longest < 0.101, "{longest}");
        let (touched, _) = run(0.08, 0.02, 0.0, true);
        assert!(
            (0.3..0.45).contains(&(touched * 0.08)),
            "{touched} steps a second"
        );
    }

    #[test]
    fn a_fast_device_takes_many_steps_in_short_frames() {
        let (rate, longest) = run(0.0005, 0.004, 0.0, false);
        assert!(rate > 1000.0, "{rate}");
        assert!(longest < 0.03, "{longest}");
    }

    #[test]
    fn steps_dearer_than_any_frame_are_still_taken() {
        let (rate, _) = run(0.9, 0.01, 0.0, true);
        assert!(rate > 0.2, "{rate}");
    }

    #[test]
    fn steps_longer_than_a_frame_come_with_every_picture() {
        for step in [0.11, 0.25, 0.5, 1.0] {
            let (rate, _) = run(step, 0.08, 0.0, false);
            assert!(rate > 0.95 / (step + 0.08), "{rate} steps a second");
            let (touched, _) = run(step, 0.08, 0.0, true);
            assert!(
                touched < 0.7 * rate,
                "more pictures come while the user turns the view"
            );
        }
    }

    #[test]
    fn the_cap_holds() {
        for cap in [1.0, 10.0, 60.0, 500.0] {
            let (rate, _) = run(0.0005, 0.004, cap, false);
            let cap = f64::from(cap);
            assert!(
                rate <= cap * 1.05 + 0.2 && rate > 0.88 * cap,
                "{rate} of {cap}"
            );
        }
    }

    #[test]
    fn nothing_is_made_up_for_after_a_stall() {
        let mut pacer = Pacer::default();
        pacer.measured(Duration::from_millis(10));
        assert!(pacer.steps(Duration::from_secs(60), 0.0, false, false) <= 8);
        // Only the rest of that frame's credit is left.
        assert!(pacer.steps(Duration::ZERO, 0.0, false, false) <= 1);
        assert_eq!(pacer.steps(Duration::ZERO, 0.0, false, false), 0);
    }

    #[test]
    fn frames_of_steps_are_short_and_those_that_wait_save_up() {
        let mut pacer = Pacer::default();
        pacer.measured(Duration::from_millis(20));
        let frame = Duration::from_millis(100);
        for _ in 0..3 {
            assert_eq!(pacer.steps(frame, 0.0, false, true), 0, "it waits");
            assert_eq!(pacer.steps(frame, 0.0, false, false), 3, "65 ms of 75");
        }
        assert!(pacer.are_notable(3) && !pacer.are_notable(1) && !pacer.are_notable(0));
        assert_eq!(pacer.steps(frame, 0.0, true, false), 1, "30 ms");
        pacer.measured(Duration::from_millis(900));
        assert!(pacer.are_notable(1));
    }

    #[test]
    fn the_estimate_follows_the_measurements() {
        let mut pacer = Pacer::default();
        assert_eq!(pacer.step_time(), None);
        pacer.measured(Duration::from_millis(4));
        assert_eq!(pacer.step_time(), Some(Duration::from_millis(4)));
        for _ in 0..40 {
            pacer.measured(Duration::from_millis(8));
        }
        let now = pacer.step_time().unwrap();
        assert!(
            now > Duration::from_micros(7_900) && now <= Duration::from_millis(8),
            "{now:?}"
        );
    }
}
