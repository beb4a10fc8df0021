//! Lost devices: the lab continues with another one in the same window, says so, and keeps what can be kept; where there is no other
//! device, it ends with an error.

use std::path::{Path, PathBuf};
use std::process::ExitStatus;

use myxo::scene::{Overrides, Scene};

use crate::input::Gesture;
use crate::out::arrived;
use crate::program::{Folder, program, shown_of};
use crate::troubles::{goes_on, hear};
use crate::{Lab, SMALL, can_open, said};

/// The device is lost after so many drawn pictures: more than are drawn before the window is paused.
const PICTURES: &str = "--lose-device=100";

/// Waits until the device is lost, checks the notice, and runs the restarted scene.
#[track_caller]
fn lose(lab: &Lab) {
    let before = lab.seen().expect("the lab has reported")["state"]["notice"].to_string();
    assert!(!before.contains("lost"), "too soon: {before}");
    let seen = lab.wait("the device is lost", |seen| {
        let notice = seen["state"]["notice"].as_str();
        notice.is_some_and(|text| text.starts_with("The device was lost (vk"))
    });
    let notice = seen["state"]["notice"].as_str().unwrap().to_owned();
    for part in [
        "what had grown is gone",
        "The scene restarts",
        "cube_000001.toml",
        "fewer particles",
    ] {
        assert!(notice.contains(part), "{part}: {notice}");
    }
    lab.wait("the scene is there from the beginning", |seen| {
        seen["state"]["loading"] == false && seen["state"]["step"] == 0
    });
    // It was paused before, so it still is.
    lab.key_until("space", "the simulation continues", "playing", true);
    goes_on(lab);
}

/// A paused lab with the export card open and GIF chosen.
#[track_caller]
fn held_with_gifs() -> Lab {
    let lab = Lab::open(&[&[PICTURES], &SMALL[..]].concat());
    lab.hold();
    lab.click_until("out", "out", true);
    lab.click("out.kind=GIF");
    lab
}

#[test]
fn after_a_lost_device_the_scene_restarts_as_it_was_set() {
    if !can_open() {
        return;
    }
    let lab = held_with_gifs();
    lab.key_until("Escape", "the card goes", "out", false);
    lab.find("trail.decay");
    lab.type_until("trail.decay", 0.9, "0.625", "trail.decay", "0.625");
    lab.key_until("4", "what is shown", "show", "particles");
    lab.point("picture", 0.4);
    for _ in 0..3 {
        lab.perform(Gesture::Wheel(true));
    }
    // The recording keeps the pictures it has. From here on, drawn pictures count.
    lab.key_until("F9", "it is recorded", "recording", true);
    lose(&lab);
    hear(&lab, "recording_000001.gif");
    // The first notice is still shown above the second.
    hear(&lab, "The device was lost");
    let (_, shown) = shown_of(&arrived(&lab, "recording_000001.gif"));
    assert!(shown >= 1, "{shown}");

    let kept = lab.folder.file("cube_000001.toml");
    let kept = Scene::read(&kept, &Overrides::default())
        .expect("it can be read")
        .1;
    assert_eq!(kept.trail.decay, 0.625);
    let state = &lab.seen().expect("the lab has reported")["state"];
    assert_eq!(state["show"], "particles");
    assert_eq!(state["unsaved"], false, "a file has it");
    assert_eq!(lab.save("cube"), kept, "all is as it was, the camera, too");

    // The gallery's pictures are there again, and other scenes can be opened.
    lab.click_until("gallery", "gallery", true);
    lab.click("gallery=scenes");
    lab.click("card=plane");
    lab.wait("the plane is there", |seen| {
        seen["state"]["scene"] == "plane" && seen["state"]["loading"] == false
    });
    goes_on(&lab);
    let lab = lab.quit_and_keep();
    let said = said(&lab.said);
    assert!(!said.contains("validation"), "{said}");
}

#[test]
fn a_film_keeps_the_pictures_that_it_had_when_the_device_was_lost() {
    if !can_open() {
        return;
    }
    let lab = held_with_gifs();
    lab.type_until("out.seconds", 0.5, "600", "out.seconds", "600");
    lab.click("out.film");
    lab.wait("it is begun", |seen| !seen["state"]["making"].is_null());
    lose(&lab);
    hear(&lab, "film_000001.gif");
    let (_, shown) = shown_of(&arrived(&lab, "film_000001.gif"));
    assert!(shown > 1, "{shown}");
    lab.quit();
}

/// Replacing it again and again would never end.
#[test]
fn a_device_that_is_lost_again_ends_the_lab_and_the_scene_is_kept() {
    if !can_open() {
        return;
    }
    let lab = Lab::begin(
        program(),
        &[
            &["--size=640x480", "--validate", "--lose-device=5,3"][..],
            &["--set=trail.decay=0.75"],
            &SMALL,
        ]
        .concat(),
    );
    let status = lab.ended();
    let folder = &lab.folder;
    ended_with(&said(&lab.said), status, folder.path(), &[]);
    let saved = Scene::read(&folder.file("cube_000001.toml"), &Overrides::default());
    assert_eq!(saved.expect("it can be read").1.trail.decay, 0.75);
}

/// Checks that one message says what was lost and where the scene is kept.
#[track_caller]
fn ended_with(message: &str, status: ExitStatus, folder: &Path, more: &[&str]) {
    assert_eq!(status.code(), Some(1), "{message}");
    let parts = [
        "the device was lost in vk",
        "cube_000001.toml",
        "is lost",
        "fewer particles",
    ];
    for part in parts.iter().chain(more) {
        assert!(message.contains(part), "{part}: {message}");
    }
    assert!(!message.contains("panicked"), "{message}");
    assert_eq!(message.trim().lines().count(), 1, "{message}");
    assert!(!folder.join("cube_000002.toml").exists(), "it is kept once");
}

/// Mesa's CPU driver, if it is in the usual folder.
fn driver() -> Option<PathBuf> {
    let files = std::fs::read_dir("/usr/share/vulkan/icd.d").ok()?;
    let mut files = files.flatten().map(|entry| entry.path());
    files.find(|file| file.to_string_lossy().contains("lvp"))
}

#[test]
fn where_no_other_device_is_found_the_lab_ends_and_the_scene_is_kept() {
    if !can_open() {
        return;
    }
    let Some(driver) = driver() else {
        return eprintln!("skipped: no lavapipe that could be taken away");
    };
    let folder = Folder::new();
    let here = folder.file("driver.json");
    std::fs::copy(driver, &here).expect("it can be read");
    let mut program = program();
    program
        .env("VK_DRIVER_FILES", &here)
        .env("VK_ICD_FILENAMES", &here);
    let lab = Lab::start(program, &[&["--lose-device=40"], &SMALL[..]].concat());
    std::fs::remove_file(&here).expect("it is there");
    let status = lab.ended();
    let more = ["no device takes its place", "no Vulkan"];
    ended_with(&said(&lab.said), status, lab.folder.path(), &more);
}
