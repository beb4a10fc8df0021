//! The window opens, draws, and closes, without a word from the validation layers.

use std::process::Command;

use super::can_open_a_window;
use super::display::only_one;
use crate::worked;

fn lab(arguments: &[&str]) -> std::process::Output {
    Command::new(env!("CARGO_BIN_EXE_myxo"))
        .arg("lab")
        .args(arguments)
        .output()
        .unwrap()
}

#[test]
fn the_lab_draws_and_closes() {
    if !can_open_a_window() {
        return;
    }
    let _guard = only_one();
    for show in ["surface", "particles", "atlas"] {
        let show = format!("picture.show={show}");
        let output = lab(&[
            "cube",
            "--validate",
            "--frames=8",
            "--size=640x480",
            "--set=particles.count=3000",
            "--set=atlas.size=128",
            "--set",
            &show,
        ]);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{show}: {errors}");
        assert!(!errors.contains("validation"), "{show}: {errors}");
    }
}

#[test]
fn without_a_display_the_lab_says_what_to_do() {
    worked::begins();
    let output = Command::new(env!("CARGO_BIN_EXE_myxo"))
        .args(["lab", "cube"])
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .output()
        .unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success());
    assert!(
        errors.contains("myxo render") && !errors.contains("panicked"),
        "{errors}"
    );
    assert_eq!(errors.lines().count(), 1, "{errors}");
}

/// A variable names a compositor that is gone: X11 opens the window, and without X11 the error names the variable.
#[test]
fn a_compositor_that_is_gone_is_named_and_x11_takes_its_place() {
    if !can_open_a_window() {
        return;
    }
    let _guard = only_one();
    let begin = || {
        let mut lab = Command::new(env!("CARGO_BIN_EXE_myxo"));
        lab.args(["lab", "cube", "--no-preferences", "--frames=2"]);
        lab.args([
            "--size=480x320",
            "--set=particles.count=500",
            "--set=atlas.size=64",
        ]);
        lab.env("WAYLAND_DISPLAY", "/nowhere/wayland-7");
        lab.env_remove("WAYLAND_SOCKET");
        lab
    };
    let output = begin().output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    assert!(errors.contains("/nowhere/wayland-7"), "{errors}");
    let output = begin().env_remove("DISPLAY").output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success());
    assert!(
        errors.contains("WAYLAND_DISPLAY names /nowhere/wayland-7"),
        "{errors}"
    );
}
