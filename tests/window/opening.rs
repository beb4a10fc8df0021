//! The dialog that opens files: by its key, from the gallery and from the menu of objects.

use std::path::Path;

use image::GrayImage;
use myxo::scene::{Overrides, Scene};
use serde_json::Value;

use crate::input::Gesture;
use crate::out::hear_once_loaded;
use crate::program::{Folder, path, program};
use crate::{Lab, SMALL, can_open};

const MESH: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
const SCENE: &str =
    "[particles]\ncount = 2500\n[atlas]\nsize = 128\n[[object]]\nmesh = \"builtin:icosphere\"\n";

/// Types a path into the dialog that is open, in place of the one that it begins with or behind it, until the lab accepts it.
#[track_caller]
pub fn type_path(lab: &Lab, path: &str, is_behind: bool) {
    lab.wait("the dialog is there", |seen| {
        seen["state"]["opening"] == true
    });
    let act = || {
        lab.key("slash");
        lab.wait("it is typed", |seen| seen["state"]["typing"] == true);
        if !is_behind {
            lab.key("ctrl+a");
        }
        lab.write(path);
        lab.key("Return");
    };
    lab.again_until(path, act, |seen| seen["state"]["opening"] == false);
}

/// Types the path of a mesh, and waits for the question whether to add or open it.
#[track_caller]
fn type_path_and_ask(lab: &Lab, path: &str) {
    let act = || {
        lab.key("slash");
        lab.wait("it is typed", |seen| seen["state"]["typing"] == true);
        lab.key("ctrl+a");
        lab.write(path);
        lab.key("Return");
    };
    lab.again_until(path, act, |seen| seen["places"]["mesh.alone"].is_array());
}

#[test]
fn files_are_opened_by_a_dialog() {
    if !can_open() {
        return;
    }
    let lab = Lab::open(&SMALL);
    let scene = lab.folder.with("ball.toml", SCENE);
    lab.folder.with("tip.obj", MESH);
    let wrong = lab.folder.with("wrong.toml", "[trail]\ndecay = 7\n");
    let look = (lab.folder).with("fern.toml", "# Fern.\n[trail]\ndecay = 0.375\n");

    // The list of keys mentions the dialog. While it is open, it gets all keys and the pointer.
    lab.key_until("h", "the list of keys", "help", true);
    let keys = lab.value("help.keys");
    assert!(keys.contains("Ctrl O"), "{keys}");
    lab.key_until("h", "it goes", "help", false);
    lab.key("b");
    lab.wait("a brush", |seen| seen["values"]["tool"] == "trail");
    lab.key_until("ctrl+o", "the dialog", "opening", true);
    lab.key("F10");
    lab.key("ctrl+s");
    let camera = lab.value("camera");
    lab.point("picture", 0.1);
    lab.press();
    lab.perform(Gesture::Wheel(true));
    lab.key_until("Escape", "the dialog goes", "opening", false);
    let seen = lab.seen().expect("the lab has reported");
    assert_eq!(seen["values"]["tool"], "trail", "and nothing else");
    assert_eq!(seen["state"]["performing"], false);
    assert_eq!(lab.value("camera"), camera);
    assert!(!lab.folder.file("cube_000001.toml").exists());
    lab.key("Escape");
    lab.wait("the brush is put down", |seen| {
        seen["values"]["tool"] == "look"
    });

    // A scene, from the gallery, which stays.
    lab.click_until("gallery", "gallery", true);
    lab.click("gallery=files");
    lab.click_until("open", "opening", true);
    type_path(&lab, path(&scene), false);
    lab.wait("it is there", |seen| {
        seen["state"]["scene"] == "ball" && seen["state"]["loading"] == false
    });
    lab.key_until("Escape", "the gallery goes", "gallery", false);
    assert_eq!(lab.save("ball").particles.count, 2500);

    // A mesh, from the menu of objects; the dialog begins where the last file was.
    lab.click("add");
    lab.click_until("add.file", "opening", true);
    type_path(&lab, "/tip.obj", true);
    lab.wait("it joins", |seen| {
        seen["values"]["objects"] == "2" && seen["state"]["loading"] == false
    });
    let objects = lab.save("ball").objects;
    assert!(objects[1].mesh.ends_with("tip.obj"), "{objects:?}");

    // The notices are those of dropped files.
    for (file, part) in [
        (&wrong, "trail.decay = 7 is out of range"),
        (&look, "The look of fern"),
    ] {
        lab.key_until("ctrl+o", "the dialog", "opening", true);
        type_path(&lab, path(file), false);
        hear_once_loaded(&lab, part);
    }
    assert_eq!(lab.save("ball").trail.decay, 0.375);
    // Saving under a name of one's own, which becomes the scene's.
    lab.key_until("ctrl+shift+s", "the dialog", "opening", true);
    lab.wait("its name can be typed", |seen| {
        seen["state"]["typing"] == true
    });
    lab.key("ctrl+a");
    lab.write("mine");
    lab.key("Return");
    lab.wait("it is saved", |seen| {
        seen["state"]["opening"] == false && seen["state"]["scene"] == "mine"
    });
    let mine = Scene::read(&lab.folder.file("mine.toml"), &Overrides::default());
    let (_, mine, _) = mine.expect("it is a scene");
    assert_eq!(mine.trail.decay, 0.375);
    // From now on the scene is saved there; the opened file does not change.
    let decay = |name: &str| {
        let scene = Scene::read(&lab.folder.file(name), &Overrides::default());
        scene.expect("it is a scene").1.trail.decay
    };
    let opened = decay("ball.toml");
    lab.find("trail.decay");
    lab.type_until("trail.decay", 0.9, "0.75", "trail.decay", "0.75");
    lab.wait("it is changed", |seen| seen["state"]["unsaved"] == true);
    lab.key_until("ctrl+s", "a file has it", "unsaved", false);
    assert_eq!(decay("mine.toml"), 0.75);
    assert_eq!(decay("ball.toml"), opened);
    assert!(!lab.folder.file("mine_000001.toml").exists());
    // The recent files: this one first, then the one saved before.
    lab.click_until("gallery", "gallery", true);
    lab.click("gallery=files");
    lab.click("recent=1");
    lab.wait("it is there", |seen| {
        seen["state"]["scene"] == "ball_000001" && seen["state"]["loading"] == false
    });
    lab.click("recent=1");
    lab.wait("it is there again", |seen| {
        seen["state"]["scene"] == "mine" && seen["state"]["loading"] == false
    });
    assert_eq!(lab.value("trail.decay"), "0.75");
    lab.key_until("g", "the gallery goes", "gallery", false);
    // Errors are shown until they are clicked away.
    let is_told = |seen: &Value| {
        let notice = seen["state"]["notice"].as_str();
        notice.is_some_and(|text| text.contains("trail.decay = 7"))
    };
    assert!(is_told(&lab.seen().expect("the lab has reported")));
    lab.click("error.0:copy");
    let copied = lab.clipboard("is out of range");
    assert!(copied.contains("trail.decay = 7"), "{copied}");
    assert!(
        is_told(&lab.seen().expect("the lab has reported")),
        "it stays"
    );
    lab.click("error.0");
    lab.wait("it is gone", |seen| !is_told(seen));

    // The folder for exports, typed by hand.
    let folder = lab.folder.file("my exports");
    std::fs::create_dir(&folder).expect("it is new");
    lab.click_until("out", "out", true);
    lab.click_until("out.folder:choose", "opening", true);
    lab.key("slash");
    lab.wait("it is typed", |seen| seen["state"]["typing"] == true);
    lab.key("ctrl+a");
    lab.write(path(&folder));
    lab.key("Return");
    lab.wait("it is read", |seen| seen["state"]["typing"] == false);
    lab.key("Return");
    lab.wait("it is chosen", |seen| {
        seen["state"]["opening"] == false && seen["values"]["out.folder"] == path(&folder)
    });
    lab.click("out.picture");
    lab.wait("it is there", |_| {
        folder.join("screenshot_000001.png").exists()
    });
    // Opening a mesh asks whether to add it.
    let objects = lab.value("objects");
    let own = lab.seen().expect("the lab has reported")["state"]["scene"].clone();
    let own = own.as_str().expect("it has a name").to_owned();
    for (answer, scene) in [
        ("mesh.cancel", own.as_str()),
        ("mesh.alone", "tip"),
        ("mesh.add", "tip"),
    ] {
        lab.key_until("ctrl+o", "the dialog", "opening", true);
        type_path_and_ask(&lab, path(&lab.folder.file("tip.obj")));
        lab.click_until(answer, "opening", false);
        lab.wait(answer, |seen| {
            seen["state"]["scene"] == scene && seen["state"]["loading"] == false
        });
        match answer {
            "mesh.cancel" => assert_eq!(lab.value("objects"), objects),
            "mesh.alone" => assert_eq!(lab.value("objects"), "1"),
            _ => {
                lab.wait("it joins", |seen| seen["values"]["objects"] == "2");
            }
        }
    }
    lab.quit();
}

/// Changes made between a restart and the loaded scene are kept.
#[test]
fn what_is_changed_while_a_scene_loads_is_kept() {
    if !can_open() {
        return;
    }
    let folder = Folder::new();
    let ball = "[particles]\ncount = 2500\n[atlas]\nsize = 512\n[[object]]\nmesh = \"builtin:icosphere?subdivisions=6\"\n";
    let file = folder.with("ball.toml", ball);
    let mut program = program();
    // A cached layout loads at once.
    program.env("XDG_CACHE_HOME", folder.path());
    let lab = Lab::start(program, &[path(&file)]);
    lab.find("atlas.size");
    lab.type_until("atlas.size", 0.9, "600", "atlas.size", "600");
    lab.find("decay");
    lab.click_until("restart", "loading", true);
    lab.type_into("trail.decay", 0.9, "0.5");
    let seen = lab.seen().expect("the lab has reported");
    assert_eq!(seen["state"]["loading"], true, "it is changed meanwhile");
    lab.wait("it is there", |seen| seen["state"]["loading"] == false);
    assert_eq!(lab.value("trail.decay"), "0.5");
    lab.wait("all of it runs", |seen| seen["state"]["pending"] == false);
    let saved = lab.save("ball");
    assert_eq!((saved.atlas.size, saved.trail.decay), (600, 0.5));
    lab.quit();
}

#[test]
fn what_was_chosen_is_there_the_next_time() {
    if !can_open() {
        return;
    }
    let kept = Folder::new();
    let ball = "[particles]\ncount = 2500\n[atlas]\nsize = 128\n[[object]]\nmesh = \"builtin:icosphere\"\n";
    let file = kept.with("ball.toml", ball);
    let open = |scene: &str| {
        let mut program = program();
        program.env("XDG_CONFIG_HOME", kept.path());
        Lab::start(program, &[scene])
    };
    let lab = open(path(&file));
    lab.click_until("out", "out", true);
    lab.type_until("out.turns", 0.5, "0.5", "out.turns", "0.5");
    lab.type_until("out.seconds", 0.5, "3", "out.seconds", "3");
    lab.quit();

    let lab = open("cube");
    lab.click_until("out", "out", true);
    assert_eq!(lab.value("out.turns"), "0.5");
    assert_eq!(lab.value("out.seconds"), "3");
    lab.key_until("Escape", "the card goes", "out", false);
    lab.click_until("gallery", "gallery", true);
    lab.click("gallery=files");
    lab.click("recent=0");
    lab.wait("it is there", |seen| {
        seen["state"]["scene"] == "ball" && seen["state"]["loading"] == false
    });
    lab.quit();
}

/// A scene with a half-finished change that waits for a restart is saved so that it can be opened.
#[test]
fn what_is_saved_can_be_opened() {
    if !can_open() {
        return;
    }
    let lab = Lab::open(&SMALL);
    lab.find("particles.start");
    lab.click("particles.start=mask");
    lab.wait("it waits", |seen| seen["state"]["pending"] == true);
    let saved = lab.save("cube");
    hear_once_loaded(&lab, "which would not work");
    assert_ne!(saved.particles.start.word(), "mask");
    assert_eq!(
        lab.seen().expect("the lab has reported")["state"]["unsaved"],
        true
    );
    lab.click("particles.start=ring");
    lab.wait("it waits", |seen| {
        seen["values"]["particles.start"] == "ring"
    });
    assert_eq!(lab.save("cube").particles.start.word(), "ring");
    // It is saved into the same file. After it is opened again, saving takes the next number, and that file does not change.
    assert!(!lab.folder.file("cube_000002.toml").exists());
    let file = lab.folder.file("cube_000001.toml");
    lab.key_until("ctrl+o", "the dialog", "opening", true);
    type_path(&lab, path(&file), false);
    lab.wait("it is there", |seen| {
        seen["state"]["scene"] == "cube_000001" && seen["state"]["loading"] == false
    });
    lab.find("particles.start");
    lab.click("particles.start=mask");
    lab.wait("it waits", |seen| seen["state"]["pending"] == true);
    assert_eq!(lab.save("cube").particles.start.word(), "ring");
    assert!(lab.folder.file("cube_000002.toml").exists());
    lab.quit();
}

/// The dialog beside the path's field chooses a start mask, for the scene and for one of its objects.
#[test]
fn masks_are_chosen_by_the_dialog() {
    if !can_open() {
        return;
    }
    let folder = Folder::new();
    let file = folder.with("ball.toml", SCENE);
    let white = GrayImage::from_pixel(16, 16, image::Luma([255]));
    let beside = folder.file("mask.png");
    white.save(&beside).expect("it can be written");
    let lab = Lab::open(&[path(&file)]);
    let elsewhere = lab.folder.file("other.png");
    white.save(&elsewhere).expect("it can be written");

    let choose = |rows: &str, word: &str, mask: &str, file: &Path, wanted: &str| {
        lab.find(rows);
        lab.click(word);
        // The line about a restart appears above the rows and moves them down.
        lab.wait("it waits for a restart", |seen| {
            seen["places"].get("discard").is_some()
        });
        lab.click_until(&format!("{mask}:open"), "opening", true);
        type_path(&lab, path(file), false);
        lab.wait("the path is in its row", |seen| {
            seen["values"][mask] == wanted
        });
    };
    let mask = "particles.start_mask";
    let word = "particles.start=mask";
    choose("particles.start", word, mask, &beside, "mask.png");
    let mask = "object.0.start.mask";
    let word = "object.0.start.place=mask";
    choose("start.", word, mask, &elsewhere, path(&elsewhere));
    lab.grows_beyond(0);
    lab.hold();
    lab.click_until("restart", "step", 0);
    let saved = lab.save("ball");
    assert!(saved.particles.start_mask.ends_with("mask.png"));
    assert!(saved.objects[0].start.mask.ends_with("other.png"));

    // The key opens the dialog for scenes as before.
    lab.key_until("ctrl+o", "the dialog", "opening", true);
    lab.key_until("Escape", "it goes", "opening", false);
    lab.quit();
}
