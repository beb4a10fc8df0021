//! Ctrl-C and termination signals: the first sets a flag that long work checks between steps, so that files are finished; the second ends
//! the program at once. Those that the program's parent ignores, as `nohup` does, stay ignored.

use std::sync::atomic::{AtomicBool, Ordering};

use myxo::render::output::Output;
use myxo::whole_file::remove_unfinished;
use myxo::{Error, Result, signals};

use crate::console;

/// What an interrupted run exits with, as shells expect of Ctrl-C.
pub const EXIT_CODE: u8 = 130;

static REQUESTED: AtomicBool = AtomicBool::new(false);

/// Handles Ctrl-C; call it once, before long work.
pub fn install() -> Result<()> {
    install_with("finishing the files", || {})
}

/// The same for code that does not check the flag: prints `doing`, and calls `notify` on another thread.
pub fn install_with(doing: &'static str, notify: impl Fn() + Send + 'static) -> Result<()> {
    let handler = move || {
        if REQUESTED.swap(true, Ordering::Relaxed) {
            Output::end_encoders();
            remove_unfinished();
            std::process::exit(i32::from(EXIT_CODE));
        }
        // The terminal has printed `^C` into the line of the progress bar: the message replaces both.
        console::message_over_line(&format!("interrupted: {doing}; once more to quit at once"));
        notify();
    };
    signals::keeping_ignored(|| ctrlc::set_handler(handler))
        .map_err(|error| Error::Invalid(format!("cannot listen for Ctrl-C: {error}")))
}

/// The flag that Ctrl-C sets.
pub fn flag() -> &'static AtomicBool {
    &REQUESTED
}

/// Was the run asked to stop?
pub fn requested() -> bool {
    REQUESTED.load(Ordering::Relaxed)
}
