//! How far long work has come: a bar where the standard error is a terminal, a line now and then where it is not.

use std::fmt::Write as _;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressState, ProgressStyle};

use super::console;

/// Between the lines of a log. Work that is shorter logs none.
const LINE_EVERY: Duration = Duration::from_secs(20);

/// Steps done and steps to do.
pub struct Progress {
    /// Draws nothing where there is no terminal.
    bar: ProgressBar,
    begun: Instant,
    last_line: Instant,
}

impl Progress {
    /// Begins `steps` steps of `what`.
    pub fn new(steps: u64, what: &str) -> Self {
        let rate = |state: &ProgressState, text: &mut dyn std::fmt::Write| {
            let _ = write!(text, "{:.1}", state.per_sec());
        };
        let style = ProgressStyle::with_template(
            "{msg} {wide_bar} {pos}/{len} steps, {rate} steps/s, {eta} left",
        )
        .expect("the template is well formed")
        .with_key("rate", rate);
        let now = Instant::now();
        Self {
            bar: ProgressBar::new(steps)
                .with_style(style)
                .with_message(what.to_owned()),
            begun: now,
            last_line: now,
        }
    }

    /// One more step is done.
    pub fn step(&mut self) {
        self.bar.inc(1);
        if self.bar.is_hidden() && self.last_line.elapsed() >= LINE_EVERY {
            self.last_line = Instant::now();
            let (done, all) = (self.bar.position(), self.bar.length().unwrap_or_default());
            let line = log_line(&self.bar.message(), done, all, self.begun.elapsed());
            console::message(&line);
        }
    }

    /// Tells something, above the bar.
    pub fn say(&self, text: &str) {
        self.bar.suspend(|| console::message(text));
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// Shows on a terminal that something is being done whose end is not known; to be finished and cleared.
pub fn working(what: &str) -> ProgressBar {
    let style =
        ProgressStyle::with_template("{msg} {spinner}").expect("the template is well formed");
    let bar = ProgressBar::new_spinner()
        .with_style(style)
        .with_message(what.to_owned());
    bar.enable_steady_tick(Duration::from_millis(150));
    bar
}

/// `torus: step 120 of 400, 6.3 steps/s, 44 s left`
fn log_line(what: &str, done: u64, all: u64, elapsed: Duration) -> String {
    let rate = done as f64 / elapsed.as_secs_f64().max(1e-9);
    let mut line = format!("{what}: step {done} of {all}, {rate:.1} steps/s");
    if done > 0 {
        let _ = write!(
            line,
            ", {:.0} s left",
            all.saturating_sub(done) as f64 / rate
        );
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_line_tells_steps_speed_and_time_left() {
        assert_eq!(
            log_line("torus", 120, 400, Duration::from_secs(60)),
            "torus: step 120 of 400, 2.0 steps/s, 140 s left"
        );
        assert_eq!(
            log_line("torus", 0, 400, Duration::from_secs(60)),
            "torus: step 0 of 400, 0.0 steps/s"
        );
    }
}
