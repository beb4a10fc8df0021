//! A window on a display is resized, hidden, covered, asked to close or killed, its device is lost, its disk is full.

use std::process::{Command, Stdio};

use myxo::scene::{Overrides, Scene};

use super::can_open_a_window;
use crate::out::arrived;
use crate::program::{program, shown_of};
use crate::troubles::{TAKES_LONG, close_in_the_middle, goes_on, hear, program_with_little_room};
use crate::{Lab, SMALL, said};

#[test]
fn resizing_hiding_and_other_labs_do_not_harm_the_window() {
    if !can_open_a_window() {
        return;
    }
    let lab = Lab::open_on_display(&SMALL);
    let ask = |arguments: &[&str]| {
        lab.display(|display, _| {
            let window = display.window().to_owned();
            let words = arguments.iter().map(|word| match *word {
                "window" => window.as_str(),
                word => word,
            });
            display.ask(&words.collect::<Vec<_>>());
        });
    };
    let now = || lab.step();
    // A second lab that ends at once does not disturb it.
    let mut other = program()
        .current_dir(lab.folder.path())
        .args(["lab", "--no-preferences", "--size=480x320", "--frames=3"])
        .args(SMALL)
        .stderr(Stdio::null())
        .spawn()
        .expect("the program starts");
    // A tiny size, and back.
    for (width, height) in [("1", "1"), ("3000", "1"), ("900", "760")] {
        ask(&["windowsize", "--sync", "window", width, height]);
        goes_on(&lab);
    }
    lab.wait("it is as large as before", |seen| {
        let right = seen["places"]["picture"][2].as_f64();
        right.is_some_and(|right| (right - 900.0).abs() < 1.5)
    });
    // Minimised where there is a window manager, and hidden in any case. Afterwards the simulation is the same and the window answers keys.
    for _ in 0..3 {
        let before = now();
        ask(&["windowminimize", "window"]);
        ask(&["windowunmap", "--sync", "window"]);
        // The smallest size, while hidden.
        ask(&["windowsize", "window", "1", "1"]);
        ask(&["windowsize", "window", "900", "760"]);
        ask(&["windowmap", "--sync", "window"]);
        lab.display(|display, _| display.hold_again());
        goes_on(&lab);
        assert!(now() > before, "it has not restarted");
    }
    lab.key_until("space", "it answers", "playing", false);
    lab.key_until("space", "it continues", "playing", true);
    assert!(other.wait().expect("it ends").success());
    lab.display(|display, _| display.hold_again());
    lab.pick("cube");
    lab.quit();
}

/// Closed by the message of the close button, in the middle of an export.
#[test]
fn a_window_that_is_closed_in_the_middle_leaves_whole_files() {
    if !can_open_a_window() {
        return;
    }
    close_in_the_middle(&Lab::open_on_display(&TAKES_LONG), |lab| {
        lab.display(|display, _| display.ask_to_close());
    });
}

#[test]
fn a_window_that_is_killed_keeps_the_scene() {
    if !can_open_a_window() {
        return;
    }
    let lab = Lab::open_on_display(&SMALL);
    lab.find("trail.decay");
    lab.type_until("trail.decay", 0.9, "0.625", "trail.decay", "0.625");
    lab.wait("it is changed", |seen| seen["state"]["unsaved"] == true);
    let killed = Command::new("sh")
        .args(["-c", "kill \"$0\"", &lab.pid()])
        .status();
    assert!(killed.expect("it is there").success());
    assert_eq!(lab.ended().code(), Some(130));
    let said = said(&lab.said);
    assert!(said.contains("cube as you left it is kept"), "{said}");
    let left = lab.folder.file("myxo/left/cube_000001.toml");
    let read = Scene::read(&left, &Overrides::default());
    assert_eq!(read.expect("it can be read").1.trail.decay, 0.625);
}

/// The window continues with another device.
#[test]
fn a_device_that_is_lost_is_replaced_in_the_window() {
    if !can_open_a_window() {
        return;
    }
    let lab = Lab::open_on_display(&[&["--lose-device=40"], &SMALL[..]].concat());
    hear(&lab, "The device was lost");
    lab.wait("the scene is there", |seen| {
        seen["state"]["loading"] == false
    });
    goes_on(&lab);
    lab.key_until("4", "it answers", "show", "particles");
    lab.click_until("run", "playing", false);
    let lab = lab.quit_and_keep();
    let said = said(&lab.said);
    assert!(!said.contains("validation"), "{said}");
}

#[test]
fn a_window_on_a_full_disk_says_so_and_goes_on() {
    if !can_open_a_window() {
        return;
    }
    // Files end at 256 KiB.
    let lab = Lab::start_on_display(program_with_little_room(512), &SMALL);
    lab.click_until("out", "out", true);
    lab.wait("the card is there", |seen| {
        seen["places"]["out.record"].is_array()
    });
    lab.click("out.kind=GIF");
    lab.key_until("F9", "it is recorded", "recording", true);
    hear(
        &lab,
        "everything before it is complete: recording_000001.gif",
    );
    let (_, shown) = shown_of(&arrived(&lab, "recording_000001.gif"));
    assert!(shown >= 1, "{shown}");
    goes_on(&lab);
    lab.quit();
}
