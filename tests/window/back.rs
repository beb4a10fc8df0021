//! Going back to the state before a reset or before another scene was opened.

use crate::out::arrived;
use crate::program::{Folder, program, shown_of};
use crate::troubles::hear;
use crate::{Lab, SMALL, can_open};

/// Waits until this scene is at this step, with nothing being loaded.
#[track_caller]
fn stands(lab: &Lab, scene: &str, step: u64) {
    lab.wait(&format!("{scene} at step {step}"), |seen| {
        let state = &seen["state"];
        state["scene"] == scene && state["step"] == step && state["loading"] == false
    });
}

/// What the probe shows in the middle of the picture.
#[track_caller]
fn probed(lab: &Lab) -> [String; 2] {
    lab.point("picture", 0.5);
    // A value that was read before the last change may still arrive.
    lab.look_at(4);
    lab.wait("it is probed", |seen| {
        seen["values"]["probe.trail"].is_string()
    });
    let seen = lab.seen().expect("the lab has reported");
    ["probe.trail", "probe.painted"].map(|key| seen["values"][key].to_string())
}

#[test]
fn what_had_grown_comes_back() {
    if !can_open() {
        return;
    }
    let lab = Lab::open(&SMALL);
    lab.key("i");
    lab.grows_beyond(110);
    lab.hold();
    assert!(lab.seen().expect("the lab has reported")["places"]["back"].is_null());
    let saved = lab.save("cube");
    lab.find("trail.decay");
    lab.type_until("trail.decay", 0.9, "0.5", "trail.decay", "0.5");
    // Areas are part of the state.
    lab.paint_with("attract");
    lab.probed("painted");
    lab.click("tool=look");
    let grown = lab.step();
    let was = probed(&lab);
    assert_ne!(was[1], "null", "something attracts");

    // Reset by mistake, and painted over.
    lab.key_until("r", "it restarts", "step", 0);
    lab.paint_with("erase");
    lab.click("tool=look");
    let young = probed(&lab);
    for (young, was) in young.iter().zip(&was) {
        assert_ne!(young, was, "trail and areas are others");
    }
    lab.click("back");
    stands(&lab, "cube", grown);
    assert_eq!(
        probed(&lab),
        was,
        "trail and areas are those that there were"
    );
    // The earlier changes can still be undone.
    for key in ["ctrl+z", "ctrl+z"] {
        lab.key(key);
        lab.look_at(2);
    }
    let undone = lab.save("cube");
    assert_eq!(undone.trail.decay, saved.trail.decay);
    // There and back again.
    lab.click("back");
    stands(&lab, "cube", 0);
    lab.click("back");
    stands(&lab, "cube", grown);
    // Two resets: a state of few steps does not replace the kept one.
    lab.key_until("r", "it restarts", "step", 0);
    lab.key("period");
    stands(&lab, "cube", 1);
    lab.key_until("r", "it restarts again", "step", 0);
    lab.click("back");
    stands(&lab, "cube", grown);

    // From another scene, which has done few steps, and back to it.
    lab.click_until("gallery", "gallery", true);
    lab.click("gallery=scenes");
    lab.click("card=plane");
    stands(&lab, "plane", 0);
    lab.click("gallery=files");
    lab.click("left.grown");
    stands(&lab, "cube", grown);
    // The picture is as large as before.
    lab.key_until("g", "the gallery closes", "gallery", false);
    lab.look_at(2);
    assert_eq!(probed(&lab), was, "it has come back, as it was");
    let is_unsaved = || lab.seen().expect("the lab has reported")["state"]["unsaved"].clone();
    assert_eq!(is_unsaved(), false, "the last change is in a file");
    lab.find("trail.decay");
    lab.type_until("trail.decay", 0.9, "0.6", "trail.decay", "0.6");
    lab.click("back");
    stands(&lab, "plane", 0);
    assert_eq!(is_unsaved(), false);
    lab.click("back");
    stands(&lab, "cube", grown);
    assert_eq!(is_unsaved(), true, "no file has the last change");
    lab.key("period");
    stands(&lab, "cube", grown + 1);
    lab.quit();
}

/// Would catch: work that is gone with another scene, because no file of it can be written and it has hardly grown.
#[test]
fn what_no_file_can_have_comes_back() {
    if !can_open() {
        return;
    }
    let folder = Folder::new();
    let text =
        "[particles]\ncount = 2000\n[atlas]\nsize = 128\n[[object]]\nmesh = \"builtin:cube\"\n";
    let ball = folder.with("ball.toml", text);
    // Below a file there is no folder for scenes that are left.
    let file = folder.with("file", "");
    let mut program = program();
    program
        .current_dir(folder.path())
        .env("XDG_DATA_HOME", &file);
    let lab = Lab::start(program, &SMALL);
    lab.hold();
    let young = lab.step();
    assert!(young < 100, "{young}");
    lab.find("trail.decay");
    lab.type_until("trail.decay", 0.9, "0.5", "trail.decay", "0.5");
    lab.drop_files(&[&ball]);
    stands(&lab, "ball", 0);
    hear(&lab, "cube as you left it is in memory only");
    lab.click("back");
    stands(&lab, "cube", young);
    lab.wait("its change, too", |seen| {
        seen["values"]["trail.decay"] == "0.5"
    });
    lab.quit();
}

/// Would catch: a kept state that comes back in part, or as another one after a reset; an undo that leads to the settings alone; a film
/// that goes on in another state; and a strip that cannot be folded.
#[test]
fn a_kept_state_comes_back_and_undo_leads_away_from_it_again() {
    if !can_open() {
        return;
    }
    let lab = Lab::open(&SMALL);
    lab.key("i");
    lab.grows_beyond(20);
    lab.hold();
    lab.find("trail.decay");
    let kept = || -> usize { lab.value("kept").parse().expect("it is a number") };
    lab.click("timeline");
    lab.place("timeline.keep");
    let before = kept();
    let grown = lab.step();
    let was = probed(&lab);
    let decay = lab.value("trail.decay");
    lab.click("timeline.keep");
    let one_more = (before + 1).to_string();
    lab.wait("it is kept", |seen| {
        seen["values"]["kept"] == one_more.as_str()
    });
    let card = format!("kept={before}");
    lab.type_until("trail.decay", 0.9, "0.5", "trail.decay", "0.5");
    for more in 1..=3 {
        lab.key("period");
        stands(&lab, "cube", grown + more);
    }
    let other = probed(&lab);
    assert_ne!(other, was);
    let is_there = |step: u64, value: &str, probe: &[String; 2]| {
        stands(&lab, "cube", step);
        lab.wait(value, |seen| seen["values"]["trail.decay"] == value);
        assert_eq!(probed(&lab), *probe);
    };
    lab.click(&card);
    is_there(grown, &decay, &was);
    lab.key("ctrl+z");
    is_there(grown + 3, "0.5", &other);
    lab.key("ctrl+shift+z");
    is_there(grown, &decay, &was);
    // Also after the scene has begun again.
    lab.key_until("r", "it restarts", "step", 0);
    lab.wait("it is there", |seen| seen["state"]["loading"] == false);
    lab.click(&card);
    is_there(grown, &decay, &was);
    // What follows is what would have followed.
    lab.key("period");
    stands(&lab, "cube", grown + 1);
    lab.click("timeline");
    lab.wait("it is folded", |seen| {
        seen["places"]["timeline.keep"].is_null()
    });
    // A film ends with the frames that it has.
    lab.click_until("out", "out", true);
    lab.click("out.kind=GIF");
    lab.click("out.film_size=window");
    lab.click("out.film");
    lab.place("out.finish");
    lab.key_until("Escape", "the card goes", "out", false);
    lab.click("timeline");
    lab.click(&card);
    let (_, frames) = shown_of(&arrived(&lab, "film_000001.gif"));
    assert!(frames < 200, "{frames} of 300");
    stands(&lab, "cube", grown);
    lab.quit();
}
