//! A pointer, keys, text, files and a clipboard on a display, each of which has to arrive at the right place.

use std::path::Path;
use std::time::Duration;

use serde_json::Value;

use super::can_open_a_window;
use crate::input::Gesture;
use crate::opening::type_path;
use crate::out::hear_once_loaded;
use crate::program::{Folder, path, program, wait_until};
use crate::{Lab, SMALL};

const MESH: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

/// The width of a control, in pixels.
fn width(lab: &Lab, name: &str) -> f64 {
    let [left, _, right, _] = lab.place(name);
    right - left
}

#[test]
fn pointer_keys_and_text_arrive() {
    if !can_open_a_window() {
        return;
    }
    let lab = Lab::open_on_display(&SMALL);
    // Clicks and keys.
    lab.click_until("run", "playing", false);
    lab.click_until("show=atlas", "show", "atlas");
    lab.key_until("1", "the surface", "show", "surface");
    lab.key_until("bracketright", "a preset", "preset", "network");
    let usual = width(&lab, "run");
    for (key, larger) in [("ctrl+plus", true), ("ctrl+0", false)] {
        lab.key(key);
        lab.wait(key, |seen| {
            let place = &seen["places"]["run"];
            let ends = (place[0].as_f64(), place[2].as_f64());
            matches!(ends, (Some(left), Some(right)) if (right - left > 1.05 * usual) == larger)
        });
    }
    // Text, into the field that was clicked.
    lab.find("trail.decay");
    lab.type_until("trail.decay", 0.9, "0.625", "trail.decay", "0.625");
    lab.perform(Gesture::Resize(1200, 960));
    lab.click_until("gallery", "gallery", true);
    let act = || {
        lab.point("preset.name", 0.5);
        lab.press();
        lab.wait("it is typed", |seen| seen["state"]["typing"] == true);
        lab.key("ctrl+a");
        lab.write("Moss 2");
    };
    lab.again_until("its name", act, |seen| {
        seen["values"]["preset.name"] == "Moss 2"
    });
    lab.key_until("Return", "it is kept", "typing", false);
    lab.wait("it is kept", |seen| {
        seen["state"]["own"] == serde_json::json!(["Moss 2"])
    });
    lab.key_until("Escape", "the gallery goes", "gallery", false);

    // Drags, also with another button and with a key held, the wheel, and a double click.
    let camera = |seen: &Value| {
        let values = &seen["values"];
        [values["camera"].clone(), values["camera.target"].clone()]
    };
    let changes = |what: &str, act: &dyn Fn(), turns: bool| {
        // The camera goes on after a drag, so the one before has to come to rest.
        let before = camera(&lab.wait("the camera rests", |seen| seen["rests"] == true));
        lab.again_until(what, act, |seen| camera(seen) != before);
        let after = camera(&lab.seen().expect("the lab has reported"));
        assert_eq!(
            before[0] != after[0],
            turns,
            "{what}: {before:?}, {after:?}"
        );
    };
    lab.point("picture", 0.5);
    changes("it turns", &|| lab.drag(1, 4, (12, 5)), true);
    lab.point("picture", 0.5);
    changes("it moves", &|| lab.drag(3, 4, (12, 5)), false);
    lab.point("picture", 0.5);
    let with_shift = || {
        lab.perform(Gesture::KeyDown("shift"));
        lab.drag(1, 4, (-12, 5));
        lab.perform(Gesture::KeyUp("shift"));
    };
    changes("it moves with Shift", &with_shift, false);
    lab.point("picture", 0.6);
    changes(
        "a double click",
        &|| lab.perform(Gesture::DoubleClick),
        false,
    );
    let before = lab.save("cube").camera.distance;
    lab.point("picture", 0.5);
    lab.perform(Gesture::Wheel(true));
    lab.perform(Gesture::Wheel(true));
    lab.wait("the picture rests", |seen| seen["rests"] == true);
    assert!(lab.save("cube").camera.distance < before, "it comes nearer");
    lab.key_until("F11", "it fills the screen", "full_screen", true);
    lab.key_until("F11", "it is a window again", "full_screen", false);
    lab.quit();
}

/// On dense screens a point has several pixels.
#[test]
fn the_pointer_arrives_on_a_dense_display() {
    if !can_open_a_window() {
        return;
    }
    let lab = Lab::open_on_display(&SMALL);
    let usual = width(&lab, "run");
    lab.quit();
    let mut dense = program();
    dense.env("WINIT_X11_SCALE_FACTOR", "1.5");
    let lab = Lab::start_on_display(dense, &[&["--size=1200x960"], &SMALL[..]].concat());
    let dense = width(&lab, "run");
    assert!((1.4..1.6).contains(&(dense / usual)), "{dense}, {usual}");
    lab.click_until("run", "playing", false);
    lab.click_until("show=particles", "show", "particles");
    lab.find("trail.decay");
    lab.type_until("trail.decay", 0.9, "0.625", "trail.decay", "0.625");
    lab.pick("cube");
    assert_eq!(lab.save("cube").trail.decay, 0.625);
    lab.quit();
}

#[test]
fn files_are_dropped_onto_the_window() {
    if !can_open_a_window() {
        return;
    }
    let lab = Lab::open_on_display(&SMALL);
    let look = (lab.folder).with("fern.toml", "# Fern.\n[trail]\ndecay = 0.375\n");
    lab.drop_files(&[&look]);
    hear_once_loaded(&lab, "The look of fern");
    // Several at once all come.
    let files = ["tip.obj", "a top.obj"].map(|name| lab.folder.with(name, MESH));
    let files: Vec<&Path> = files.iter().map(|file| file.as_path()).collect();
    lab.drop_files(&files);
    lab.wait("all are there", |seen| {
        seen["state"]["loading"] == false && seen["values"]["objects"] == "3"
    });
    let saved = lab.save("cube");
    assert_eq!(saved.trail.decay, 0.375);
    assert!(saved.objects[2].mesh.ends_with("a top.obj"));
    lab.quit();
}

/// From other programs into the lab, and the other way round.
#[test]
fn the_clipboard_is_that_of_the_display() {
    if !can_open_a_window() {
        return;
    }
    let lab = Lab::open_on_display(&SMALL);
    lab.display(|display, _| {
        display.copy("# Fern.\n[trail]\ndecay = 0.375\n");
        // The program that copied serves the text only a moment later.
        wait_until("the clipboard has it", Duration::from_secs(20), || {
            display.clipboard().contains("0.375")
        });
    });
    lab.key_until("ctrl+v", "it is taken", "preset", "clipboard");
    lab.key("ctrl+c");
    let copied = lab.clipboard("builtin:cube");
    assert!(copied.contains("decay = 0.375"), "{copied}");
    lab.quit();
}

#[test]
fn a_file_is_opened_by_the_dialog() {
    if !can_open_a_window() {
        return;
    }
    let folder = Folder::new();
    let scene = "[particles]\ncount = 2500\n[atlas]\nsize = 128\n[[object]]\nmesh = \"builtin:icosphere\"\n";
    let scene = folder.with("ball.toml", scene);
    let lab = Lab::open_on_display(&SMALL);
    lab.key_until("ctrl+o", "the dialog", "opening", true);
    type_path(&lab, path(&scene), false);
    lab.wait("it is there", |seen| {
        seen["state"]["scene"] == "ball" && seen["state"]["loading"] == false
    });
    assert_eq!(lab.save("ball").particles.count, 2500);
    lab.quit();
}
