//! Every button and every key of the window: what runs, what is shown, what is undone, looks, the camera, scenes.

use serde_json::Value;

use crate::input::Gesture;
use crate::{Lab, SMALL, can_open, out, step, views};

/// Takes long: it works every control, one after the other.
#[test]
fn every_button_and_key_has_its_effect() {
    if !can_open() {
        return;
    }
    let lab = Lab::open(&SMALL);

    // Run, hold, step, reset.
    lab.click_until("run", "playing", false);
    let before = lab.step();
    lab.click("step");
    lab.wait("one step", |seen| step(seen) == before + 1);
    lab.key("period");
    lab.wait("one more", |seen| step(seen) == before + 2);
    lab.click("reset");
    lab.wait("from the beginning", |seen| step(seen) == 0);
    lab.key_until("space", "it runs", "playing", true);
    lab.wait("the simulation continues", |seen| step(seen) > 3);
    lab.hold();

    // What the picture shows.
    for show in ["particles", "atlas", "surface"] {
        lab.click_until(&format!("show={show}"), "show", show);
    }
    for (key, show) in [("4", "particles"), ("0", "atlas"), ("1", "surface")] {
        lab.key_until(key, show, "show", show);
    }
    lab.click("colors");
    lab.click_until("colors=ice", "color_map", "ice");
    lab.key_until("c", "the next colours", "color_map", "moss");
    lab.find("picture.charts");
    lab.type_into("picture.charts", 0.9, "0.5");
    lab.find("picture.brightest");
    lab.click("auto");
    lab.type_into("picture.brightest", 0.9, "33");
    lab.key("4");
    lab.find("particle_size");
    lab.type_into("picture.particle_size", 0.9, "4");
    let saved = lab.save("cube");
    let picture = &saved.picture;
    assert_eq!((picture.charts, picture.brightest), (0.5, 33.0));
    assert_eq!(picture.particle_size, 4.0);
    lab.key("1");

    // Undo and redo, by button and by key.
    lab.find("trail.decay");
    lab.type_until("trail.decay", 0.9, "0.5", "trail.decay", "0.5");
    lab.click("undo");
    assert_eq!(lab.save("cube").trail.decay, saved.trail.decay);
    lab.click("redo");
    assert_eq!(lab.save("cube").trail.decay, 0.5);
    for key in ["ctrl+shift+z", "ctrl+y"] {
        lab.key("ctrl+z");
        lab.wait("undone", |seen| seen["values"]["trail.decay"] != "0.5");
        lab.key(key);
        lab.wait(key, |seen| seen["values"]["trail.decay"] == "0.5");
        assert_eq!(lab.save("cube").trail.decay, 0.5, "{key}");
    }
    lab.click("trail.decay:reset");
    assert_eq!(lab.save("cube").trail.decay, saved.trail.decay);

    // Changes that need a restart wait, and are discarded or applied.
    lab.find("particles.count");
    let count = "particles.count";
    lab.type_until(count, 0.9, "4000", count, "4000");
    lab.wait("it waits", |seen| seen["state"]["pending"] == true);
    lab.click_until("discard", "pending", false);
    lab.find(count);
    lab.type_until(count, 0.9, "4000", count, "4000");
    lab.wait("it waits", |seen| seen["state"]["pending"] == true);
    lab.click_until("restart", "pending", false);
    assert_eq!(lab.save("cube").particles.count, 4000);

    // Looks.
    lab.type_into("morph", 0.5, "0.5");
    lab.click("preset");
    lab.click_until("preset=waves", "preset", "waves");
    assert!(lab.save("cube").physarum.rotation_angle < 0.0);
    lab.key_until("bracketright", "the next preset", "preset", "mist");
    lab.key_until("bracketleft", "the preset before", "preset", "waves");
    lab.click_until("chance", "preset", Value::Null);
    let by_chance = lab.save("cube");
    lab.key("d");
    let next = lab.save("cube").physarum;
    assert_ne!(next, by_chance.physarum);
    // Every look made up by chance is kept.
    let goes = |to: &str| {
        lab.wait(to, |seen| {
            seen["values"]["chance"] == to && seen["state"]["morphing"] == false
        });
        lab.save("cube").physarum
    };
    assert_eq!(goes("2 of 2"), next);
    lab.click("chance.earlier");
    assert_eq!(goes("1 of 2"), by_chance.physarum);
    lab.click("chance.later");
    assert_eq!(goes("2 of 2"), next);
    lab.key("j");
    assert_eq!(goes("1 of 2"), by_chance.physarum);
    lab.key("k");
    assert_eq!(goes("2 of 2"), next);
    lab.key("bracketright");
    lab.wait("the look changes, or has changed", |seen| {
        seen["state"]["preset"] == "network"
    });
    lab.wait("it is there", |seen| seen["state"]["morphing"] == false);
    assert_eq!(lab.save("cube").physarum.sensor_offset, 0.03);

    // The window itself.
    lab.click_until("theme", "light", true);
    lab.key_until("t", "it is dark", "light", false);
    lab.key_until("p", "the panel goes", "panel", false);
    lab.key_until("p", "the panel comes", "panel", true);
    lab.key_until("F10", "the picture alone", "performing", true);
    lab.key_until("Escape", "and not alone", "performing", false);
    lab.click_until("help", "help", true);
    lab.key_until("h", "it goes again", "help", false);
    // The crosses of floating windows.
    for (window, cross) in [
        ("help", "help.close"),
        ("gallery", "gallery.close"),
        ("out", "out.close"),
    ] {
        lab.click_until(window, window, true);
        lab.click_until(cross, window, false);
    }
    lab.key_until("F11", "it fills the screen", "full_screen", true);
    lab.key_until("F11", "it is a window again", "full_screen", false);
    lab.click("screenshot");
    lab.wait("a notice", |seen| {
        let notice = seen["state"]["notice"].as_str();
        notice.is_some_and(|text| text.contains("screenshot_000001.png"))
    });
    let picture = image::open(lab.folder.file("screenshot_000001.png"));
    let picture = picture.expect("it is a picture").into_rgb8();
    let lit = picture
        .pixels()
        .filter(|pixel| pixel.0.iter().max() > Some(&60));
    assert!(lit.count() > 5000, "something is seen");

    // The camera: drag, wheel, double click, and back.
    let camera = lab.save("cube").camera;
    lab.point("picture", 0.4);
    lab.drag(1, 6, (20, 5));
    let turned = lab.save("cube").camera;
    assert!((turned.azimuth - camera.azimuth).abs() > 5.0, "{turned:?}");
    for _ in 0..3 {
        lab.perform(Gesture::Wheel(true));
    }
    let near = lab.save("cube").camera;
    assert!(near.distance < 0.95 * turned.distance, "{near:?}");
    views::look_for_nothing(&lab);
    lab.click("fit");
    let fitted = lab.save("cube").camera;
    assert!(fitted.distance > 1.05 * near.distance, "{fitted:?}");

    // Commands are found as parameters are.
    lab.find("one step");
    let before = lab.step();
    lab.click("do=take one step");
    lab.wait("a step", |seen| step(seen) == before + 1);
    // The times: frozen, measured again, copied.
    lab.find("kernels");
    for frozen in ["true", "false"] {
        lab.click("times.freeze");
        lab.wait("it is frozen, or not", |seen| {
            seen["values"]["times.frozen"] == frozen
        });
    }
    lab.click("times.copy");
    let table = lab.clipboard("calls a step");
    assert!(table.contains("\nadvance\t1.000\t"), "{table}");
    lab.click("times.export");
    let report = std::fs::read(out::arrived(&lab, "times_000001.json")).expect("it can be read");
    let report: Value = serde_json::from_slice(&report).expect("it is JSON");
    let kernels = report["kernels"].as_array().expect("it is a list");
    assert!(
        kernels.iter().any(|one| one["name"] == "advance"),
        "{report}"
    );
    lab.click("times.freeze");
    lab.click("times.clear");
    lab.wait("nothing is kept", |seen| {
        seen["values"]["times.frozen"] != "true"
    });
    views::look_for_nothing(&lab);

    // Another scene, by its picture; and one whose loading is cancelled, if it is not loaded before the click.
    lab.click_until("gallery", "gallery", true);
    lab.click("gallery=scenes");
    lab.click("card=plane");
    lab.wait("the plane is there", |seen| {
        seen["state"]["scene"] == "plane" && seen["state"]["loading"] == false
    });
    // The gallery stays beside the picture, and its wheel does not turn the camera.
    let camera = lab.value("camera");
    lab.point("card=plane", 0.5);
    lab.perform(Gesture::Wheel(true));
    assert_eq!(lab.value("camera"), camera);
    lab.key_until("g", "the gallery goes", "gallery", false);
    lab.key_until("g", "the gallery comes", "gallery", true);
    lab.click("gallery=looks");
    lab.click("card=cells");
    lab.wait("the look is taken", |seen| {
        seen["state"]["preset"] == "cells"
    });
    lab.key_until("Escape", "the gallery goes", "gallery", false);

    // The autopilot, until something comes in.
    lab.click_until("autopilot", "autopilot", true);
    lab.perform(Gesture::MoveBy(60, 60));
    lab.wait("it ends, and the panel is there", |seen| {
        seen["state"]["autopilot"] == false && seen["state"]["performing"] == false
    });
    lab.key_until("a", "it begins", "autopilot", true);
    lab.key_until("Escape", "it ends", "autopilot", false);
    lab.quit();
}
