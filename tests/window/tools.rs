//! Tools: brushes, the probe, food, and objects that are picked, moved and turned.

use glam::{DQuat, EulerRot};
use myxo::scene::settings::{FoodSettings, ObjectSettings, Settings, Show};

use serde_json::Value;

use crate::input::Gesture;
use crate::troubles::hear;
use crate::{Lab, step, with_scene};

/// Two objects beside each other; the first is in the middle of the picture.
pub const SCENE: &str = r#"
[particles]
count = 3000

[atlas]
size = 128

[[object]]
name = "ball"
mesh = "builtin:icosphere?subdivisions=3"

[[object]]
name = "box"
mesh = "builtin:cube"
scale = 0.3
position = [1.5, 0.0, 0.0]
"#;

impl Lab {
    /// The trail that the probe shows under the pointer.
    #[track_caller]
    pub fn probed(&self, what: &str) -> f64 {
        let key = format!("probe.{what}");
        let number = |seen: &Value| seen["values"][&key].as_str()?.parse::<f64>().ok();
        // A value that was read before the last change may still arrive.
        self.look_at(4);
        let seen = self.wait(&key, |seen| number(seen).is_some());
        number(&seen).expect("it is a number")
    }

    /// Draws a little to and fro, so that the pointer ends where it was.
    fn stroke(&self) {
        self.perform(Gesture::Down(1));
        for right in [6, -6, 6, -6] {
            self.perform(Gesture::MoveBy(right, 0));
        }
        self.perform(Gesture::Up(1));
    }

    /// Draws with a tool in the middle of the picture.
    #[track_caller]
    pub fn paint_with(&self, tool: &str) {
        self.click(&format!("tool={tool}"));
        self.wait(tool, |seen| seen["values"]["tool"] == tool);
        self.point("picture", 0.5);
        self.stroke();
    }

    /// Drags a handle.
    #[track_caller]
    pub fn pull(&self, handle: &str, way: [i32; 2]) {
        // A handle follows its object a frame later.
        self.look_at(2);
        self.point(handle, 0.5);
        self.drag(1, 5, (way[0], way[1]));
    }
}

#[test]
fn brushes_paint_what_they_touch() {
    let Some((_folder, lab)) = with_scene("pair.toml", SCENE) else {
        return;
    };
    lab.hold();
    lab.point("picture", 0.5);
    lab.key("i");
    let before = lab.probed("trail");
    let held = lab.step();

    // Trail comes and goes while the simulation is held.
    lab.paint_with("trail");
    let painted = lab.probed("trail");
    assert!(painted > before + 1.0, "{painted}, and {before} before");
    lab.paint_with("erase");
    lab.stroke();
    let erased = lab.probed("trail");
    assert!(erased < 0.5 * painted, "{erased}, and {painted} before");
    assert_eq!(lab.step(), held, "it is held");

    // Particles come, and deposit in the next step.
    lab.paint_with("particles");
    lab.stroke();
    lab.key("period");
    let visited = lab.probed("trail");
    assert!(visited > erased, "{visited}, and {erased} before");

    // Attraction, which stays.
    lab.paint_with("attract");
    let attracted = lab.probed("painted");
    assert!(attracted > 0.0, "{attracted}");
    lab.paint_with("repel");
    assert!(lab.probed("painted") < attracted);
    let painted = |words: &str| {
        let words = words.to_owned();
        lab.wait(&words, |seen| seen["values"]["probe.painted"] == words);
    };
    lab.paint_with("no-go");
    painted("no-go");
    lab.key("ctrl+s");
    lab.wait("the notice of the saved map", |seen| {
        let notice = seen["state"]["notice"].as_str();
        notice.is_some_and(|text| text.contains("with painted areas in"))
    });
    lab.paint_with("erase");
    painted("nothing");

    // The brush itself.
    lab.type_until("brush.radius", 0.9, "0.2", "brush.radius", "0.200");
    lab.type_until("brush.strength", 0.9, "5", "brush.strength", "5.0");
    lab.point("picture", 0.5);
    lab.perform(Gesture::KeyDown("shift"));
    lab.perform(Gesture::Wheel(true));
    lab.perform(Gesture::Wheel(true));
    lab.perform(Gesture::KeyUp("shift"));
    lab.wait("it grows", |seen| {
        let radius = seen["values"]["brush.radius"].as_str();
        radius.and_then(|radius| radius.parse().ok()) > Some(0.201)
    });
    lab.key("Escape");
    lab.wait("the tool is put down", |seen| {
        seen["values"]["tool"] == "look"
    });
    lab.key("b");
    lab.wait("it is taken again", |seen| {
        seen["values"]["tool"] == "erase"
    });
    assert_eq!(lab.step(), held + 1);

    // The simulation continues from what was painted.
    lab.paint_with("trail");
    let painted = lab.probed("trail");
    lab.key_until("space", "it runs", "playing", true);
    lab.wait("the simulation continues", |seen| step(seen) > held + 30);
    assert_ne!(lab.probed("trail"), painted);

    // The probe's button, and the camera's tool.
    let has_value = |seen: &Value| seen["values"]["probe.trail"].is_string();
    lab.click("probe");
    lab.point("picture", 0.5);
    lab.wait("it says nothing", |seen| !has_value(seen));
    lab.click("probe");
    lab.point("picture", 0.5);
    let seen = lab.wait("it says it again", has_value);
    let says = |what: &str| seen["values"][format!("probe.{what}")].as_str();
    assert_eq!(says("object"), Some("ball"));
    let triangle = says("triangle").map(|words| words.replace(',', ""));
    let triangle = triangle.and_then(|words| words.parse::<u32>().ok());
    assert!(triangle < Some(1280), "{triangle:?}");
    let uv = says("uv").unwrap_or_default().split_whitespace();
    let uv: Vec<f32> = uv.map(|words| words.parse().expect("numbers")).collect();
    assert_eq!(uv.len(), 2);
    assert!(uv.iter().all(|u| *u >= 0.0) && uv.iter().sum::<f32>() < 1.001);
    assert!(says("to others").is_some_and(|words| words.ends_with("radii")));
    lab.click("tool=look");
    lab.wait("the tool is put down", |seen| {
        seen["values"]["tool"] == "look"
    });
    lab.quit();
}

#[test]
fn strokes_that_stay_are_undone_and_redone() {
    let Some((_folder, lab)) = with_scene("pair.toml", SCENE) else {
        return;
    };
    lab.hold();
    lab.point("picture", 0.5);
    lab.key("i");
    lab.probed("trail");
    let is = |words: &str| {
        let words = words.to_owned();
        lab.wait(&words, |seen| seen["values"]["probe.painted"] == words);
    };
    let is_none = || {
        lab.wait("nothing is painted", |seen| {
            seen["values"]["probe.trail"].is_string() && seen["values"]["probe.painted"].is_null()
        });
    };
    // Does the notice of a saved scene mention a map of areas?
    let says_areas = |part: bool| {
        lab.save("pair");
        lab.wait("a notice", |seen| {
            let notice = seen["state"]["notice"].as_str().unwrap_or_default();
            notice.contains("pair_000001.toml") && notice.contains("with painted areas in") == part
        });
    };
    is_none();

    // No-go areas: painted, undone and redone.
    lab.paint_with("no-go");
    is("no-go");
    says_areas(true);
    lab.key("ctrl+z");
    is_none();
    says_areas(false);
    lab.key("ctrl+shift+z");
    is("no-go");
    says_areas(true);

    // Undo takes strokes one by one, in order with other changes; it brings erased areas back, too.
    lab.paint_with("erase");
    is("nothing");
    lab.find("trail.decay");
    lab.type_until("trail.decay", 0.9, "0.5", "trail.decay", "0.5");
    lab.paint_with("attract");
    let attracted = lab.probed("painted");
    lab.paint_with("repel");
    // As much as it attracted may be left as nothing, which is no number.
    assert!(attracted > 0.0, "{attracted}");
    lab.wait(
        "it attracts less",
        |seen| match seen["values"]["probe.painted"].as_str() {
            Some("nothing") => true,
            painted => painted
                .is_some_and(|text| text.parse::<f64>().is_ok_and(|painted| painted < attracted)),
        },
    );
    lab.key("ctrl+z");
    assert_eq!(lab.probed("painted"), attracted);
    lab.key("ctrl+z");
    is("nothing");
    assert_eq!(lab.value("trail.decay"), "0.5");
    lab.key("ctrl+z");
    lab.wait("the parameter", |seen| {
        seen["values"]["trail.decay"] != "0.5"
    });
    is("nothing");
    lab.key("ctrl+z");
    is("no-go");
    for (key, words) in [("ctrl+shift+z", "nothing"), ("ctrl+z", "no-go")] {
        lab.key(key);
        is(words);
    }
    lab.key("ctrl+z");
    is_none();

    // Undo does not change the trail.
    let before = lab.probed("trail");
    lab.paint_with("trail");
    let painted = lab.probed("trail");
    assert!(painted > before + 1.0, "{painted}, and {before} before");
    lab.key("ctrl+z");
    assert_eq!(lab.probed("trail"), painted);
    lab.quit();
}

#[test]
fn tools_work_in_every_view() {
    let Some((_folder, lab)) = with_scene("pair.toml", SCENE) else {
        return;
    };
    lab.hold();
    // Taking a brush leaves the probe on.
    lab.key("i");
    lab.click("tool=trail");
    let on_surface = Show::ALL.iter().filter(|show| !show.is_flat());
    for show in on_surface.map(|show| show.word()) {
        lab.click_until(&format!("show={show}"), "show", show);
        lab.point("picture", 0.5);
        let before = lab.probed("trail");
        let camera = lab.value("camera");
        lab.stroke();
        let painted = lab.probed("trail");
        assert!(painted > before + 1.0, "{show}: {painted}, {before} before");
        assert_eq!(lab.value("camera"), camera, "{show}");
    }
    // Objects are picked only without a tool.
    lab.click("tool=look");
    // The panel shows the picked object and no views then, so views are chosen by keys.
    for (key, show) in [("2", "relief"), ("9", "nearest")] {
        lab.key_until(key, show, "show", show);
        lab.pick("ball");
        lab.key("Escape");
        lab.wait("nothing is picked", |seen| seen["values"]["picked"] == "");
    }
    // The atlas is flat.
    lab.key_until("0", "the atlas", "show", "atlas");
    lab.key("b");
    lab.wait("a notice", |seen| {
        let notice = seen["state"]["notice"].as_str();
        notice.is_some_and(|text| text.contains("the atlas is flat"))
    });
    lab.wait("the bar makes room", |seen| {
        seen["places"]["tool=erase"].is_null()
    });
    lab.key_until("1", "the surface", "show", "surface");
    lab.place("tool=erase");
    lab.quit();
}

/// How an object is turned: about X, then Y, then Z.
fn rotation(object: &ObjectSettings) -> DQuat {
    let [x, y, z] = object
        .rotation
        .map(|degrees| f64::from(degrees).to_radians());
    DQuat::from_euler(EulerRot::ZYX, z, y, x)
}

#[test]
fn handles_move_and_turn_objects() {
    let Some((_folder, lab)) = with_scene("pair.toml", SCENE) else {
        return;
    };
    let start = lab.save("pair");
    lab.pick("ball");

    // Moved, turned, and undone.
    lab.pull("gizmo=plane", [-8, 4]);
    let moved = lab.save("pair");
    let way = |settings: &Settings, other: &Settings| {
        let both = (settings.objects[0].position.iter()).zip(other.objects[0].position);
        both.map(|(a, b)| (a - b).abs()).sum::<f64>()
    };
    assert!(way(&moved, &start) > 0.05, "{:?}", moved.objects[0]);
    assert_eq!(moved.objects[1], start.objects[1], "the other one stays");
    lab.pull("gizmo=y", [0, -8]);
    let higher = lab.save("pair").objects[0].position;
    assert!(
        higher[1] > moved.objects[0].position[1] + 0.05,
        "{higher:?}"
    );
    lab.key("ctrl+z");
    assert_eq!(lab.save("pair").objects[0], moved.objects[0]);
    // The object moves along the arrow only.
    let mut before = moved.objects[0].position;
    for (axis, handle) in [(0, "gizmo=x"), (2, "gizmo=z")] {
        let [middle, end] = ["gizmo=plane", handle].map(|name| lab.place(name));
        let way = [0, 1].map(|i| (0.1 * (end[i] - middle[i])).round() as i32);
        lab.pull(handle, way);
        let after = lab.save("pair").objects[0].position;
        for i in 0..3 {
            let moved = after[i] - before[i];
            let is_right = if i == axis {
                moved > 0.05
            } else {
                moved.abs() < 1e-4
            };
            assert!(is_right, "{handle}: {after:?}, and {before:?} before");
        }
        before = after;
    }
    for _ in 0..2 {
        lab.key("ctrl+z");
        // Within one slow frame two changes would be merged into one.
        lab.save("pair");
    }
    // The object turns about the ring's axis only.
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let handle = format!("gizmo=turn.{name}");
        // Along the ring, wherever its handle is.
        let [middle, at] = ["gizmo=plane", &handle].map(|name| {
            let [left, above, right, below] = lab.place(name);
            [0.5 * (left + right), 0.5 * (above + below)]
        });
        let [right, down] = [at[0] - middle[0], at[1] - middle[1]];
        let scale = 11.0 / right.hypot(down);
        let way = [-down * scale, right * scale].map(|pixels| pixels.round() as i32);
        lab.pull(&handle, way);
        let turned = lab.save("pair");
        let before = &moved.objects[0];
        assert_eq!(turned.objects[0].position, before.position, "{name}");
        let rotations = [before, &turned.objects[0]].map(rotation);
        let (about, angle) = (rotations[1] * rotations[0].inverse()).to_axis_angle();
        let along = about.as_ref()[axis].abs();
        assert!(angle > 0.01 && along > 0.999, "{name}: {angle}, {about}");
        lab.key("ctrl+z");
        assert_eq!(lab.save("pair").objects[0], *before, "{name}");
    }
    lab.quit();
}

/// A click sends a pulse, with what was typed for it; it ends by itself.
///
/// Would catch: a click that turns the picture instead, values that do not reach the simulation, and a count that stays.
#[test]
fn pulses_are_sent_and_end() {
    let Some((_folder, lab)) = with_scene("pair.toml", SCENE) else {
        return;
    };
    lab.hold();
    lab.key("m");
    lab.wait("the tool is taken", |seen| {
        seen["values"]["tool"] == "pulse"
    });
    lab.key("m");
    lab.wait("it is put down", |seen| seen["values"]["tool"] == "look");
    lab.click("tool=pulse");
    lab.type_until("pulse.strength", 0.9, "7", "pulse.strength", "1");
    lab.type_until("pulse.speed", 0.9, "0.02", "pulse.speed", "0.02");
    lab.type_until("pulse.width", 0.9, "0.4", "pulse.width", "0.4");
    lab.type_until("pulse.reach", 0.9, "0.05", "pulse.reach", "0.05");
    let pulses = |count: &str| {
        let count = count.to_owned();
        lab.wait("pulses", |seen| seen["values"]["pulses"] == count);
    };
    pulses("0");
    lab.point("picture", 0.5);
    lab.press();
    pulses("1");
    lab.press();
    pulses("2");
    // Three steps of 0.02 are beyond 0.05.
    for _ in 0..3 {
        pulses("2");
        lab.key("period");
    }
    pulses("0");
    lab.quit();
}

/// The brush takes a second look, another one is chosen from its list, a stroke is undone and comes again, and the scene is saved with it.
///
/// Would catch: a brush that paints a look that there is not, and strokes of it that undo passes over.
#[test]
fn a_second_look_is_chosen_painted_and_undone() {
    let Some((_folder, lab)) = with_scene("pair.toml", SCENE) else {
        return;
    };
    lab.hold();
    let value = |key: &str, words: &str| {
        let (key, words) = (key.to_owned(), words.to_owned());
        lab.wait(&key.clone(), |seen| seen["values"][&key] == words);
    };
    lab.click("tool=blend");
    value("second", "felt");
    value("second.painted", "false");
    lab.click("second");
    lab.click("second=cells");
    value("second", "cells");
    lab.paint_with("blend");
    value("second.painted", "true");
    lab.key("ctrl+z");
    value("second.painted", "false");
    lab.key("ctrl+shift+z");
    value("second.painted", "true");
    lab.key("period");
    assert_eq!(lab.save("pair").second_look.preset, "cells");
    // No scene file has what was painted, and each says so.
    let lacks = "without the second look that was painted: checkpoints have it";
    hear(&lab, &format!("pair_000001.toml, {lacks}"));
    lab.key("ctrl+c");
    hear(&lab, &format!("The scene is in the clipboard, {lacks}"));
    lab.click_until("out", "out", true);
    lab.click("out.export=Scene");
    hear(&lab, &format!("kB), {lacks}"));
    let seen = lab.seen().expect("the lab has reported");
    assert_eq!(seen["state"]["unsaved"], true);
    lab.quit();
}

#[test]
fn food_is_placed_moved_and_removed() {
    let Some((_folder, lab)) = with_scene("pair.toml", SCENE) else {
        return;
    };
    lab.hold();
    let foods = |count: &str| {
        let count = count.to_owned();
        lab.wait("foods", |seen| seen["values"]["foods"] == count);
        // Food can be placed while the simulation is paused.
        lab.wait("it is there", |seen| seen["values"]["foods.there"] == "all");
    };
    lab.key("o");
    lab.wait("the tool is taken", |seen| seen["values"]["tool"] == "food");
    lab.key("o");
    lab.wait("the tool is put down", |seen| {
        seen["values"]["tool"] == "look"
    });
    lab.click("tool=food");
    lab.wait("it is taken again", |seen| seen["values"]["tool"] == "food");
    foods("0");
    lab.point("picture", 0.5);
    lab.press();
    foods("1");
    lab.wait("it is picked", |seen| seen["values"]["picked.food"] == "0");
    let saved = lab.save("pair");
    let [food] = &saved.foods[..] else {
        panic!("{:?}", saved.foods)
    };
    // In the middle of the picture is the ball, of radius 1.
    assert_eq!(food.object, "ball");
    let away = food.at.iter().map(|x| x * x).sum::<f64>().sqrt();
    assert!((away - 1.0).abs() < 0.02, "{food:?}");

    // Food is changed while the simulation runs on.
    lab.type_until("food.strength", 0.9, "-30", "food.strength", "-30");
    lab.type_until("food.amount", 0.9, "500", "food.amount", "500");
    lab.type_until("food.radius", 0.9, "0.5", "food.radius", "0.5");
    lab.type_until("food.size", 0.9, "0.25", "food.size", "0.25");
    let changed = lab.save("pair");
    let food = &changed.foods[0];
    assert_eq!((food.strength, food.amount), (-30.0, 500));
    assert_eq!((food.radius, food.size), (0.5, 0.25));
    lab.key("period");

    // The picture can show or hide it.
    let shown = |words: &str| {
        let words = words.to_owned();
        lab.wait("food", |seen| seen["values"]["shows_food"] == words);
    };
    shown("true");
    lab.find("picture.food");
    lab.click("picture.food=hidden");
    shown("false");
    lab.click("undo");
    shown("true");

    // A click elsewhere picks nothing; a click on the food picks it again.
    lab.key("Escape");
    lab.wait("the tool is put down", |seen| {
        seen["values"]["picked.food"] == ""
    });
    lab.point("picture", 0.5);
    lab.press();
    lab.wait("it is picked again", |seen| {
        seen["values"]["picked.food"] == "0" && seen["values"]["foods"] == "1"
    });
    lab.key("Delete");
    foods("0");
    lab.key("ctrl+z");
    foods("1");
    lab.point("picture", 0.5);
    lab.press();
    lab.wait("it is picked", |seen| seen["values"]["picked.food"] == "0");

    // Dragging it does not turn the picture, and one undo takes it back.
    let camera = lab.value("camera");
    let lay = lab.save("pair").foods;
    lab.pull("picture", [9, 5]);
    foods("1");
    let dragged = lab.save("pair").foods;
    let [food] = &dragged[..] else {
        panic!("{dragged:?}")
    };
    let way = |food: &FoodSettings, other: &FoodSettings| {
        let both = food.at.iter().zip(other.at);
        both.map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
    };
    assert!(way(food, &lay[0]) > 0.05, "{food:?}, and {lay:?} before");
    let away = food.at.iter().map(|x| x * x).sum::<f64>().sqrt();
    assert!((away - 1.0).abs() < 0.02, "{food:?} is not on the ball");
    assert_eq!(lab.value("camera"), camera);
    lab.key("ctrl+z");
    foods("1");
    assert_eq!(lab.save("pair").foods, lay);

    lab.point("picture", 0.5);
    lab.press();
    lab.wait("it is picked", |seen| seen["values"]["picked.food"] == "0");
    lab.click("food.remove");
    foods("0");
    assert_eq!(lab.save("pair").foods, []);
    // There is no food any more, so dragging turns the picture.
    lab.pull("picture", [9, 5]);
    lab.wait("it turns", |seen| seen["values"]["camera"] != camera);
    foods("0");
    // The turn is undone before the removal.
    lab.key("ctrl+z");
    lab.wait("it is back", |seen| seen["values"]["camera"] == camera);
    foods("0");
    lab.key("ctrl+z");
    foods("1");
    lab.key("ctrl+shift+z");
    foods("0");
    lab.key("Escape");
    lab.quit();
}
