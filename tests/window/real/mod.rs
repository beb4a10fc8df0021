//! What only a window on a display shows: that pointer, keys, text, files and the clipboard reach it and come from it, and what
//! becomes of it when it is resized, hidden, closed or killed. Few and short: what each control does is for the other tests.
//!
//! They need `xdotool`, `xclip` and an X display, which `make test` brings; without these they fail, unless MYXO_ALLOW_NO_DEVICE=1
//! lets them skip.

pub mod display;
mod hands;
mod messages;
mod opening;
mod troubles;
mod window_times;

use std::process::{Command, Stdio};

use crate::worked;

/// Are there a display and a hand to be had?
fn can_open_a_window() -> bool {
    worked::begins();
    let has = |tool: &str| {
        let mut version = Command::new(tool);
        version.arg("-version").stdin(Stdio::null());
        version.stdout(Stdio::null()).stderr(Stdio::null());
        version.status().is_ok()
    };
    if std::env::var_os("DISPLAY").is_some() && has("xdotool") && has("xclip") {
        return true;
    }
    assert!(
        std::env::var_os("MYXO_ALLOW_NO_DEVICE").is_some(),
        "no X display, xdotool or xclip: run `make test` (MYXO_ALLOW_NO_DEVICE=1 skips this)"
    );
    eprintln!("skipped: no X display, xdotool or xclip");
    false
}
