//! Ctrl-C (and being asked to terminate): the first time a flag that long work looks at between steps, so that files
//! get finished; the second time the program quits at once.

use std::sync::atomic::{AtomicBool, Ordering};

use myxo::render::output::Output;
use myxo::whole_file::remove_unfinished;
use myxo::{Error, Result};

use crate::console;

/// What an interrupted run exits with, as shells expect of Ctrl-C.
pub const EXIT_CODE: u8 = 130;

static REQUESTED: AtomicBool = AtomicBool::new(false);

/// Takes over Ctrl-C; to be called once, before long work.
pub fn install() -> Result<()> {
    install_with("finishing the files", || {})
}

/// The same for who does not look at the flag: says that it does this, and calls `tell`, on a thread of its own.
pub fn install_with(doing: &'static str, tell: impl Fn() + Send + 'static) -> Result<()> {
    let handler = move || {
        if REQUESTED.swap(true, Ordering::Relaxed) {
            Output::end_encoders();
            remove_unfinished();
            std::process::exit(i32::from(EXIT_CODE));
        }
        // What the terminal shows of Ctrl-C stands in the line of the bar: both go.
        console::message_over_line(&format!("interrupted: {doing}; once more to quit at once"));
        tell();
    };
    ctrlc::set_handler(handler)
        .map_err(|error| Error::Invalid(format!("cannot listen for Ctrl-C: {error}")))
}

/// What becomes true when somebody has asked to stop.
pub fn flag() -> &'static AtomicBool {
    &REQUESTED
}

/// Has somebody asked to stop?
pub fn requested() -> bool {
    REQUESTED.load(Ordering::Relaxed)
}
