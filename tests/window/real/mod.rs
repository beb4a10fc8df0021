//! What can only be tested in a window on a display: pointer, keys, text, files and the clipboard, and what happens when the window is
//! resized, hidden, closed or killed. These tests are few and short; the other tests check what each control does.
//!
//! They need `xdotool`, `xclip` and an X display, which `make test` brings; without these they fail, unless MYXO_ALLOW_NO_DEVICE=1
//! lets them skip.

pub mod display;
mod input;
mod messages;
mod network;
mod opening;
mod troubles;
mod window_times;

use std::process::{Command, Stdio};

use crate::worked;

/// Are there a display, `xdotool` and `xclip`?
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
