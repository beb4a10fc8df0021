//! Looks that are kept, applied from cards, text and dropped files, and removed; scenes with unsaved changes.

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::process::Command;

use myxo::scene::parameters::PARAMETERS;
use myxo::scene::presets::{is_look, is_preset};

use myxo::scene::settings::Settings;
use myxo::scene::{Overrides, Scene};
use serde_json::Value;

use crate::input::Gesture;
use crate::out::{arrived, hear_once_loaded};
use crate::program::{Folder, path, program};
use crate::{Lab, SMALL, can_open, said};

/// Drops a file, and waits for a notice that contains `part`.
#[track_caller]
pub fn drop_and_hear(lab: &Lab, file: &Path, part: &str) {
    lab.drop_files(&[file]);
    hear_once_loaded(lab, part);
}

#[track_caller]
fn assert_same_look(found: &Settings, wanted: &Settings) {
    for parameter in PARAMETERS.iter().filter(|parameter| is_look(parameter)) {
        let [found, wanted] = [found, wanted].map(|settings| parameter.value(settings));
        assert_eq!(found, wanted, "{}", parameter.key);
    }
}

/// Types the name of a look. Return would keep it at once.
#[track_caller]
fn name_look(lab: &Lab, name: &str) {
    let act = || {
        lab.point("preset.name", 0.5);
        lab.press();
        lab.wait("it is typed", |seen| seen["state"]["typing"] == true);
        lab.key("ctrl+a");
        lab.write(name);
    };
    lab.again_until(name, act, |seen| seen["values"]["preset.name"] == name);
}

#[test]
fn looks_are_kept_taken_copied_dropped_and_removed() {
    if !can_open() {
        return;
    }
    let lab = Lab::open(&SMALL);
    lab.perform(Gesture::Resize(1200, 960));
    lab.find("trail.decay");
    lab.type_until("trail.decay", 0.9, "0.625", "trail.decay", "0.625");
    let mine = lab.save("cube");

    // Kept, with a picture.
    lab.click_until("gallery", "gallery", true);
    name_look(&lab, "cells");
    lab.click("preset.keep");
    let name = "Moss 2";
    name_look(&lab, name);
    lab.click("preset.keep");
    lab.wait("it is kept", |seen| {
        seen["state"]["own"] == serde_json::json!([name])
    });
    assert_eq!(
        lab.seen().expect("the lab has reported")["state"]["preset"],
        name
    );
    let folder = lab.folder.file("myxo/presets");
    let text = std::fs::read_to_string(folder.join("Moss 2.toml")).expect("it is there");
    assert!(is_preset(&text) && text.contains("decay = 0.625"), "{text}");
    let picture = image::open(folder.join("Moss 2.png")).expect("it is a picture");
    let picture = picture.into_rgb8();
    assert_eq!(picture.dimensions(), (300, 200));
    let lit = picture.pixels().filter(|p| p.0.iter().max() > Some(&60));
    assert!(lit.count() > 500, "something is seen");

    // Copied by its button, and applied over another look.
    lab.click("preset.copy");
    lab.wait("it is copied", |seen| {
        let notice = seen["state"]["notice"].as_str();
        notice.is_some_and(|text| text.contains("clipboard"))
    });
    lab.click_until("card=cells", "preset", "cells");
    lab.key_until("ctrl+v", "it is taken", "preset", "clipboard");
    lab.click_until("card=Moss 2", "preset", name);

    // Applied from its card, and as the preset after the last built-in one.
    lab.click_until("card=cells", "preset", "cells");
    assert_ne!(lab.save("cube").trail, mine.trail);
    lab.click_until("card=Moss 2", "preset", name);
    lab.key_until("Escape", "the gallery goes", "gallery", false);
    assert_same_look(&lab.save("cube"), &mine);
    lab.key_until("bracketright", "the first", "preset", "network");
    lab.key_until("bracketleft", "the last", "preset", name);

    // As text.
    lab.key("ctrl+shift+c");
    lab.wait("it is copied", |seen| {
        let notice = seen["state"]["notice"].as_str();
        notice.is_some_and(|text| text.contains("clipboard"))
    });
    lab.key_until("bracketright", "another", "preset", "network");
    lab.key_until("ctrl+v", "it is taken", "preset", "clipboard");
    assert_same_look(&lab.save("cube"), &mine);

    // Dropped: a look, and files that are none.
    let preset = lab
        .folder
        .with("fern.toml", "# Fern.\n[trail]\ndecay = 0.375\n");
    drop_and_hear(&lab, &preset, "The look of fern");
    assert_eq!(lab.save("cube").trail.decay, 0.375);
    for (name, text, part) in [
        (
            "wrong.toml",
            "[trail]\ndecay = 7\n",
            "trail.decay = 7 is out of range",
        ),
        ("torn.toml", "[trail\ndecay", "not valid TOML"),
        ("empty.obj", "", "empty.obj"),
        ("torn.glb", "glTF but not really", "torn.glb"),
        ("letter.txt", "Dear reader", "neither a scene nor a model"),
    ] {
        let file = lab.folder.with(name, text);
        drop_and_hear(&lab, &file, part);
    }
    let before = lab.seen().expect("the lab has reported")["state"]["step"].as_u64();
    lab.wait("the simulation continues", |seen| {
        seen["state"]["step"].as_u64() > before
    });
    assert_eq!(lab.save("cube").trail.decay, 0.375, "nothing has changed");

    // Another scene, with the look that is here.
    let look = lab.save("cube");
    lab.click_until("gallery", "gallery", true);
    lab.click("gallery=scenes");
    lab.click("scenes.look");
    lab.click("card=plane");
    lab.wait("it is there", |seen| {
        seen["state"]["scene"] == "plane" && seen["state"]["loading"] == false
    });
    assert_same_look(&lab.save("plane"), &look);

    // A scene and a mesh.
    let scene = "[particles]\ncount = 2500\n[atlas]\nsize = 128\n[[object]]\nmesh = \"builtin:icosphere\"\n";
    let scene = lab.folder.with("ball.toml", scene);
    lab.drop_files(&[&scene]);
    lab.wait("it is there", |seen| seen["state"]["scene"] == "ball");
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    let mesh = lab.folder.with("tip.obj", mesh);
    lab.drop_files(&[&mesh]);
    lab.wait("it joins", |seen| seen["state"]["loading"] == false);
    lab.wait("it is there", |seen| seen["values"]["objects"] == "2");
    assert_eq!(lab.save("ball").objects.len(), 2);

    // Removing takes two clicks. The gallery is still there.
    lab.click("gallery=looks");
    lab.click("remove=Moss 2");
    lab.click("remove=Moss 2:no");
    lab.click("remove=Moss 2");
    assert!(folder.join("Moss 2.toml").exists());
    lab.click("remove=Moss 2:yes");
    lab.wait("it is gone", |seen| {
        seen["state"]["own"] == serde_json::json!([])
    });
    assert_eq!(std::fs::read_dir(&folder).expect("it is there").count(), 0);
    lab.quit();
}

/// Points at the card of a look, and returns the report of the first frame in which the look is previewed. Answers within steps, which show
/// the picture that is there, are no frames.
#[track_caller]
fn first_frame_of(lab: &Lab, name: &str) -> Value {
    let answers = |seen: &Value| seen["state"]["answers_within_steps"].clone();
    let before = lab.seen().expect("the lab has reported");
    let before = RefCell::new(answers(&before));
    lab.point(&format!("card={name}"), 0.5);
    lab.until(name, || {
        let seen = lab.seen()?;
        let is_answer = before.replace(answers(&seen)) != answers(&seen);
        (seen["state"]["previewed"] == name && !is_answer).then_some(seen)
    })
}

/// Would catch: a frame in which a look is previewed in other colours than its own; steps of a preview that count, or steps of the scene
/// that do not; a look that a file gets because it was previewed; a preview of a paused scene that steps; and a preview that a restart or
/// the end of the window meets unprepared.
#[test]
fn a_preview_leaves_the_scene_as_it_is() {
    if !can_open() {
        return;
    }
    let lab = Lab::open(&SMALL);
    lab.key_until("g", "the gallery", "gallery", true);
    let scene = lab.save("cube");
    let is_previewed = |name: &str| {
        lab.wait(name, |seen| {
            seen["state"]["previewed"] == name && seen["state"]["previewed_steps"] == true
        });
        lab.until("its steps do not count", || {
            let before = lab.step();
            lab.look_at(8);
            (lab.step() == before).then_some(before)
        })
    };
    let has_ended = || {
        lab.point("picture", 0.5);
        let seen = lab.wait("it ends", |seen| seen["state"]["previewed"].is_null());
        lab.wait("its colours go", |seen| {
            seen["state"]["drawn_colors"] == "viridis"
        });
        seen
    };
    let seen = first_frame_of(&lab, "ribbons");
    assert_eq!(seen["state"]["drawn_colors"], "inferno");
    let stood = is_previewed("ribbons");
    assert_eq!(lab.save("cube"), scene, "the look is not the scene's");
    // Over others to the next one, which comes at once.
    for passed in ["cells", "ribbons"] {
        lab.point(&format!("card={passed}"), 0.5);
    }
    let seen = first_frame_of(&lab, "spots");
    assert_eq!(seen["state"]["drawn_colors"], "moss");
    assert!(is_previewed("spots") >= stood);
    lab.grows_beyond(crate::step(&has_ended()));
    // The scene runs by the rules of this look: it continues, in other colours.
    let seen = first_frame_of(&lab, "network");
    assert_eq!(seen["state"]["drawn_colors"], "myxo");
    lab.grows_beyond(crate::step(&seen) + 8);
    let seen = lab.seen().expect("the lab has reported");
    assert_eq!(seen["state"]["previewed"], "network");
    has_ended();
    // A paused one is only seen in other colours.
    lab.hold();
    // Steps that had begun come to their end.
    lab.look_at(4);
    let stood = lab.step();
    let seen = first_frame_of(&lab, "ribbons");
    assert_eq!(seen["state"]["drawn_colors"], "inferno");
    lab.look_at(8);
    let seen = lab.seen().expect("the lab has reported");
    assert_eq!(seen["state"]["previewed_steps"], false);
    has_ended();
    assert_eq!(lab.step(), stood);
    lab.key_until("space", "it runs", "playing", true);
    // The scene begins again under the pointer.
    lab.point("card=cells", 0.5);
    is_previewed("cells");
    lab.key("r");
    lab.wait("it begins again", |seen| {
        seen["state"]["loading"] == false && crate::step(seen) < 40
    });
    assert_eq!(lab.save("cube"), scene);
    is_previewed("cells");
    lab.click_until("card=cells", "preset", "cells");
    lab.wait("it is taken", |seen| {
        seen["state"]["morphing"] == false && seen["state"]["previewed"].is_null()
    });
    assert_ne!(lab.save("cube").physarum, scene.physarum);
    lab.point("card=network", 0.5);
    is_previewed("network");
    lab.quit();
}

#[test]
fn files_that_are_dropped_together_all_come() {
    if !can_open() {
        return;
    }
    let lab = Lab::open(&SMALL);
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    let names = ["tip.obj", "top.obj", "torn.obj", "tap.obj"];
    let files = names.map(|name| {
        let is_torn = name == "torn.obj";
        lab.folder.with(name, if is_torn { "" } else { mesh })
    });
    let look = (lab.folder).with("fern.toml", "# Fern.\n[trail]\ndecay = 0.375\n");
    let all: Vec<&Path> = files.iter().chain([&look]).map(PathBuf::as_path).collect();
    lab.drop_files(&all);
    let seen = lab.wait("all are there", |seen| {
        let notice = seen["state"]["notice"].as_str();
        let is_last = notice.is_some_and(|text| text.contains("The look of fern"));
        seen["state"]["loading"] == false && is_last && seen["values"]["objects"] == "4"
    });
    let notice = seen["state"]["notice"].as_str().expect("a notice");
    assert!(
        notice.contains("torn.obj"),
        "the notice has its error, too: {notice}"
    );
    let saved = lab.save("cube");
    let meshes = saved.objects.iter().map(|object| object.mesh.as_str());
    let ends = ["cube", "tip.obj", "top.obj", "tap.obj"];
    for (mesh, end) in meshes.zip(ends) {
        assert!(mesh.ends_with(end), "{mesh}: {end}");
    }
    assert_eq!(saved.trail.decay, 0.375);
    // A notice says what is odd about a mesh.
    let odd = lab.folder.with("odd.obj", format!("{mesh}f 1 3 2\n"));
    let part = "odd: 1 triangle that is there already, dropped";
    drop_and_hear(&lab, &odd, part);
    lab.wait("it joins", |seen| seen["values"]["objects"] == "5");
    lab.quit();
}

#[test]
fn checkpoints_come_back() {
    if !can_open() {
        return;
    }
    let lab = Lab::open(&SMALL);
    lab.find("trail.decay");
    lab.type_until("trail.decay", 0.9, "0.5", "trail.decay", "0.5");
    lab.hold();
    let step = |lab: &Lab| lab.seen().expect("the lab has reported")["state"]["step"].as_u64();
    let then = step(&lab).expect("it has grown");
    lab.click_until("out", "out", true);
    lab.click("out.export=Checkpoint");
    let file = arrived(&lab, "cube_000001.ckpt");
    lab.key_until("Escape", "the panel goes", "out", false);

    // A dropped checkpoint continues from its step, with its settings.
    lab.type_until("trail.decay", 0.9, "0.75", "trail.decay", "0.75");
    lab.key_until("space", "it runs", "playing", true);
    lab.wait("the simulation continues", |seen| {
        seen["state"]["step"].as_u64() > Some(then + 10)
    });
    lab.hold();
    let part = format!("Continues from step {then}");
    drop_and_hear(&lab, &file, &part);
    lab.wait("it is there", |seen| {
        seen["state"]["scene"] == "cube_000001" && seen["state"]["step"] == then
    });
    assert_eq!(lab.save("cube").trail.decay, 0.5);
    lab.key("period");
    lab.wait("one step", |seen| seen["state"]["step"] == then + 1);
    let lab = lab.quit_and_keep();

    // The same from the command line, started in another folder.
    let kept = Folder::new();
    let again = kept.file("again.ckpt");
    std::fs::copy(&file, &again).expect("it is there");
    drop(lab);
    let lab = Lab::open(&["--resume", path(&again)]);
    lab.wait("a notice", |seen| {
        let notice = seen["state"]["notice"].as_str();
        seen["state"]["scene"] == "again" && notice.is_some_and(|text| text.contains(&part))
    });
    assert!(step(&lab) >= Some(then));
    assert_eq!(lab.save("again").trail.decay, 0.5);
    lab.quit();
}

#[test]
fn scenes_with_unsaved_changes_are_kept() {
    if !can_open() {
        return;
    }
    let lab = Lab::open(&SMALL);
    lab.find("trail.decay");
    lab.type_until("trail.decay", 0.9, "0.625", "trail.decay", "0.625");
    let unsaved = |what: &str, is: bool| {
        lab.wait(what, |seen| seen["state"]["unsaved"] == is);
    };
    unsaved("no file has it", true);
    lab.save("cube");
    unsaved("now one has", false);
    lab.type_until("trail.decay", 0.9, "0.5", "trail.decay", "0.5");

    lab.click_until("gallery", "gallery", true);
    lab.click("gallery=scenes");
    lab.click("card=plane");
    lab.wait("another scene", |seen| {
        let notice = seen["state"]["notice"].as_str();
        let says = notice.is_some_and(|text| text.contains("cube as you left it"));
        seen["state"]["scene"] == "plane" && says
    });
    unsaved("nothing was changed in it", false);
    let folder = lab.folder.file("myxo/left");
    let text = std::fs::read_to_string(folder.join("cube_000001.toml")).expect("it is there");
    assert!(text.contains("decay = 0.5"), "{text}");

    // Once it is opened, the gallery has what was left.
    lab.key_until("g", "the gallery goes", "gallery", false);
    lab.click_until("gallery", "gallery", true);
    lab.click("gallery=files");
    lab.click("left=0");
    lab.wait("it is back", |seen| {
        seen["state"]["scene"] == "cube" && seen["state"]["loading"] == false
    });
    unsaved("as it was left", false);
    // Its first check puts a line into the panel.
    lab.grows_beyond(3);
    assert_eq!(lab.save("cube").trail.decay, 0.5);
    lab.type_until("trail.decay", 0.9, "0.75", "trail.decay", "0.75");
    let left = lab.quit_and_keep();
    let folder = left.folder.file("myxo/left");
    let text = std::fs::read_to_string(folder.join("cube_000002.toml")).expect("it is there");
    assert!(text.contains("decay = 0.75"), "{text}");
    let files = std::fs::read_dir(&folder).expect("it can be read");
    assert_eq!(files.count(), 4, "what was not changed is not kept");
    // What was seen last, once in the gallery and once at the end.
    for name in ["cube_000001.png", "cube_000002.png"] {
        let picture = image::open(folder.join(name)).expect("it is a picture");
        let picture = picture.into_rgb8();
        assert_eq!(picture.dimensions(), (300, 200));
        let lit = picture
            .pixels()
            .filter(|pixel| pixel.0.iter().max() > Some(&60));
        assert!(lit.count() > 2000, "{name}");
    }
}

#[test]
fn unsaved_changes_are_kept_however_the_lab_ends() {
    if !can_open() {
        return;
    }
    let lab = Lab::open(&SMALL);
    let unsaved = |what: &str, is: bool| {
        lab.wait(what, |seen| {
            seen["state"]["unsaved"] == is && seen["state"]["loading"] == false
        });
    };
    unsaved("it is built in", false);
    lab.copy(
        "[particles]\ncount = 2500\n[atlas]\nsize = 128\n[[object]]\nmesh = \"builtin:cube\"\n",
    );
    lab.key("ctrl+v");
    unsaved("it is in the clipboard only", true);

    // An exported scene file counts as saved.
    lab.click_until("out", "out", true);
    lab.click("out.export=Scene");
    unsaved("now a file has it", false);
    let scene = Scene::read(&lab.folder.file("cube_000001.toml"), &Overrides::default());
    assert_eq!(scene.expect("it is a scene").1.particles.count, 2500);
    lab.key_until("Escape", "the panel goes", "out", false);

    lab.find("trail.decay");
    lab.type_until("trail.decay", 0.9, "0.625", "trail.decay", "0.625");
    unsaved("it is changed", true);
    let killed = Command::new("sh")
        .args(["-c", "kill \"$0\"", &lab.pid()])
        .status();
    assert!(killed.expect("it is there").success());
    assert_eq!(lab.ended().code(), Some(130));
    let said = said(&lab.said);
    assert!(said.contains("cube as you left it is kept"), "{said}");
    let left = lab.folder.file("myxo/left/cube_000001.toml");
    let read = Scene::read(&left, &Overrides::default());
    let left_as = read.expect("it can be read").1;
    assert_eq!(
        (left_as.particles.count, left_as.trail.decay),
        (2500, 0.625)
    );

    // Opened again, the scene has its name.
    let mut again = program();
    let folder = lab.folder.path();
    again.current_dir(folder).env("XDG_DATA_HOME", folder);
    let again = Lab::begin(again, &["--size=640x480", "--lose-device=3,3", path(&left)]);
    again.ended();
    let said = crate::said(&again.said);
    assert!(said.contains("cube_000002.toml"), "{said}");
}
