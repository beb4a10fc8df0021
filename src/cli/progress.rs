//! Progress of long work: a bar if the standard error is a terminal, otherwise a line now and then.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressState, ProgressStyle};
use myxo::gpu::default_cache_folder;
use myxo::mesh::atlas::Control;
use myxo::plain_text::escaped;
use myxo::sim::food::MEASURING;
use myxo::sim::{LOOKING, STARTING};

use super::interrupt;
use crate::console;

/// The interval between the lines of a log. Shorter work logs none.
const LINE_EVERY: Duration = Duration::from_secs(20);

/// Steps done and steps to do.
pub struct Progress {
    /// Draws nothing without a terminal.
    bar: ProgressBar,
    what: String,
    /// What is counted.
    unit: &'static str,
    begun: Instant,
    last_line: Instant,
    /// Neither bar nor lines.
    is_silent: bool,
}

impl Progress {
    /// Begins `steps` steps of `what`.
    pub fn new(steps: u64, what: &str) -> Self {
        Self::counting(steps, what, "steps")
    }

    /// Begins work that is counted in other units than steps.
    pub fn counting(count: u64, what: &str, unit: &'static str) -> Self {
        let rate = |state: &ProgressState, text: &mut dyn std::fmt::Write| {
            let _ = write!(text, "{:.1}", state.per_sec());
        };
        let style = ProgressStyle::with_template(&format!(
            "{{msg}} {{wide_bar}} {{pos}}/{{len}} {unit}, {{rate}} {unit}/s, {{eta}} left"
        ))
        .expect("the template is well formed")
        .with_key("rate", rate);
        let now = Instant::now();
        let what = escaped(what);
        Self {
            bar: ProgressBar::new(count)
                .with_style(style)
                .with_message(what.clone().into_owned()),
            what: what.into_owned(),
            unit,
            begun: now,
            last_line: now,
            is_silent: false,
        }
    }

    /// Shows no progress any more, for work that is reported in other ways; [`Self::say`] still prints.
    pub fn silence(&mut self) {
        self.is_silent = true;
        self.bar.finish_and_clear();
    }

    /// Shows what is being done.
    pub fn doing(&self, what: &str) {
        self.bar
            .set_message(format!("{}: {}", self.what, escaped(what)));
    }

    /// Shows that steps are being done again.
    pub fn doing_steps(&self) {
        self.bar.set_message(self.what.clone());
    }

    /// One more step is done.
    pub fn step(&mut self) {
        if self.is_silent {
            return;
        }
        self.bar.inc(1);
        log::debug!(
            "{}: {} of {} {}",
            self.what,
            self.bar.position(),
            self.bar.length().unwrap_or_default(),
            self.unit
        );
        if self.bar.is_hidden() && self.last_line.elapsed() >= LINE_EVERY {
            self.last_line = Instant::now();
            let (done, all) = (self.bar.position(), self.bar.length().unwrap_or_default());
            let line = log_line(
                &self.bar.message(),
                self.unit,
                done,
                all,
                self.begun.elapsed(),
            );
            console::message(&line);
        }
    }

    /// Prints a text above the bar.
    pub fn say(&self, text: &str) {
        self.bar.suspend(|| console::message(text));
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// Shorter work gets no bar.
const BAR_AFTER: Duration = Duration::from_secs(1);
/// A bar's whole length.
const WHOLE: u64 = 1000;

/// The set-up of a scene, most of which is making its atlas or measuring the distances to food. Ctrl-C stops it.
pub struct SettingUp {
    what: String,
    /// A spinner at first, because its length is not known yet; draws nothing without a terminal.
    bar: ProgressBar,
    begun: Instant,
    cache: Option<PathBuf>,
    /// The phases so far, and when each began.
    phases: Mutex<Vec<(&'static str, Instant)>>,
    last_line: Mutex<Instant>,
}

impl SettingUp {
    /// Begins `what`. Layouts of charts are cached in the folder, if there is one.
    pub fn new(what: &str, cache: Option<PathBuf>) -> Self {
        let style = ProgressStyle::with_template("{msg} {spinner}");
        let now = Instant::now();
        let what = escaped(what).into_owned();
        let setting_up = Self {
            what: what.clone(),
            bar: ProgressBar::new_spinner()
                .with_style(style.expect("the template is well formed"))
                .with_message(format!("{what}: setting up")),
            begun: now,
            cache,
            phases: Mutex::default(),
            last_line: Mutex::new(now),
        };
        setting_up
            .bar
            .enable_steady_tick(Duration::from_millis(150));
        setting_up
    }

    /// Does the work, then removes the bar.
    pub fn run<R>(&self, work: impl FnOnce(&Control<'_>) -> R) -> R {
        let done = work(&Control {
            progress: Some(&|doing, done| self.show(doing, done)),
            cancelled: Some(interrupt::flag()),
            cache: self.cache.as_deref(),
        });
        self.bar.finish_and_clear();
        done
    }

    fn show(&self, doing: &'static str, done: f32) {
        let now = Instant::now();
        let mut phases = unpoisoned(&self.phases);
        if phases.last().is_none_or(|(last, _)| *last != doing) {
            phases.push((doing, now));
            log::info!("{}: {doing}", self.what);
        }
        drop(phases);
        if self.begun.elapsed() < BAR_AFTER {
            return;
        }
        if self.bar.length().is_none() {
            let style = ProgressStyle::with_template("{msg} {wide_bar} {percent} %");
            self.bar
                .set_style(style.expect("the template is well formed"));
            self.bar.set_length(WHOLE);
        }
        let doing = match doing {
            MEASURING | STARTING | LOOKING => doing.to_owned(),
            part => format!("making the atlas, {part}"),
        };
        self.bar.set_message(format!("{}: {doing}", self.what));
        self.bar.set_position((done * WHOLE as f32) as u64);
        let mut last_line = unpoisoned(&self.last_line);
        if self.bar.is_hidden() && last_line.elapsed() >= LINE_EVERY {
            *last_line = now;
            let line = format!("{}: {doing}, {:.0} % done", self.what, 100.0 * done);
            console::message(&line);
        }
    }

    /// How long each phase took, in seconds; the last one until now.
    pub fn seconds(&self) -> Vec<(&'static str, f64)> {
        let phases = unpoisoned(&self.phases);
        let ends = phases.iter().skip(1).map(|(_, begun)| *begun);
        let ends = ends.chain([Instant::now()]);
        phases
            .iter()
            .zip(ends)
            .map(|((doing, begun), end)| (*doing, (end - *begun).as_secs_f64()))
            .collect()
    }
}

/// Ignores poisoning: after a panic elsewhere the value can still be read.
fn unpoisoned<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The folder of cached layouts, beside the compiled pipelines.
pub fn atlas_cache() -> Option<PathBuf> {
    default_cache_folder().map(|folder: PathBuf| Path::join(&folder, "atlases"))
}

/// `torus: step 120 of 400, 6.3 steps/s, 44 s left`
fn log_line(what: &str, unit: &str, done: u64, all: u64, elapsed: Duration) -> String {
    let rate = done as f64 / elapsed.as_secs_f64().max(1e-9);
    let one = unit.trim_end_matches('s');
    let mut line = format!("{what}: {one} {done} of {all}, {rate:.1} {unit}/s");
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
    fn a_log_line_has_steps_speed_and_time_left() {
        assert_eq!(
            log_line("torus", "steps", 120, 400, Duration::from_secs(60)),
            "torus: step 120 of 400, 2.0 steps/s, 140 s left"
        );
        assert_eq!(
            log_line("torus", "steps", 0, 400, Duration::from_secs(60)),
            "torus: step 0 of 400, 0.0 steps/s"
        );
    }
}
