//! Keys, drags and clicks that are other ways to something, or have no control of their own.

use myxo::scene::settings::{CameraSettings, Settings};
use serde_json::Value;

use crate::input::Gesture;
use crate::{Lab, SMALL, can_open, step, views};

/// The saved settings of the cube.
struct Saved<'a> {
    lab: &'a Lab,
}

impl Saved<'_> {
    #[track_caller]
    fn next(&self) -> Settings {
        self.lab.save("cube")
    }

    #[track_caller]
    fn camera(&self) -> CameraSettings {
        self.next().camera
    }

    /// The camera after a gesture.
    #[track_caller]
    fn camera_after(&self, what: &str, gesture: impl Fn(&Lab)) -> CameraSettings {
        let before = self.camera();
        gesture(self.lab);
        let after = self.camera();
        assert_ne!(after, before, "{what}");
        after
    }
}

/// Drags the middle of the picture with one of the pointer's buttons.
fn drag_picture(lab: &Lab, button: u8) {
    lab.point("picture", 0.5);
    lab.drag(button, 6, (10, 5));
}

fn far(some: &CameraSettings, other: &CameraSettings) -> f32 {
    let both = some.target.iter().zip(other.target);
    both.map(|(a, b)| (a - b).abs()).sum()
}

#[test]
fn every_gesture_and_every_other_key_has_its_effect() {
    if !can_open() {
        return;
    }
    let lab = Lab::open(&SMALL);
    let saved = Saved { lab: &lab };
    lab.hold();
    let home = saved.camera();

    // The camera: panned by the other buttons and by Shift, brought back by keys.
    for (what, key) in [("right", "f"), ("middle", "Home"), ("shift", "f")] {
        let moved = saved.camera_after(what, |lab| match what {
            "right" => drag_picture(lab, 3),
            "middle" => drag_picture(lab, 2),
            _ => {
                lab.perform(Gesture::KeyDown("shift"));
                drag_picture(lab, 1);
                lab.perform(Gesture::KeyUp("shift"));
            }
        });
        assert!(far(&moved, &home) > 0.02, "{what} pans: {moved:?}");
        assert_eq!(
            (moved.azimuth, moved.elevation),
            (home.azimuth, home.elevation),
            "{what} does not turn"
        );
        let back = saved.camera_after(key, |lab| lab.key(key));
        assert!(
            far(&back, &home) < 1e-4,
            "{key}: {back:?}, and not {home:?}"
        );
    }
    // A double click looks at the point.
    let moved = saved.camera_after("double click", |lab| {
        lab.point("picture", 0.6);
        lab.perform(Gesture::DoubleClick);
    });
    assert!(far(&moved, &home) > 0.02, "{moved:?}");
    lab.key("Escape");

    // Keys that have buttons too, and alternative keys.
    let before = lab.step();
    lab.key("s");
    lab.wait("one step", |seen| step(seen) == before + 1);
    lab.key("r");
    lab.wait("from the beginning", |seen| step(seen) == 0);
    for charts in [0.5, 1.0, 0.0] {
        lab.key("x");
        assert_eq!(saved.next().picture.charts, charts);
    }
    lab.key_until("F1", "the list of keys", "help", true);
    lab.key_until("Escape", "it goes", "help", false);
    lab.key_until("ctrl+e", "what is there to take out", "out", true);
    lab.key_until("ctrl+e", "it goes", "out", false);

    // Larger and smaller letters.
    let width = |lab: &Lab| {
        let [left, _, right, _] = lab.place("run");
        right - left
    };
    let usual = width(&lab);
    for (key, range) in [
        ("ctrl+plus", 1.05..2.0),
        ("ctrl+0", 0.99..1.01),
        ("ctrl+minus", 0.5..0.95),
        ("ctrl+0", 0.99..1.01),
    ] {
        lab.key(key);
        lab.wait(key, |seen| {
            let place = &seen["places"]["run"];
            let ends = (place[0].as_f64(), place[2].as_f64());
            matches!(ends, (Some(left), Some(right)) if range.contains(&((right - left) / usual)))
        });
    }

    // Sliders and numbers are dragged, too.
    let decay = saved.next().trail.decay;
    lab.find("trail.decay");
    views::drag_until(&lab, "trail.decay", (-48, 0), "trail.decay");
    let dragged = saved.next().trail.decay;
    assert!(dragged < decay - 0.05, "{dragged}, and {decay} before");
    // The menu of a row has two ways back.
    let usual = Settings::default().trail.decay;
    for (way, wanted) in [("default", usual), ("scene", decay)] {
        lab.point("trail.decay:name", 0.5);
        lab.perform(Gesture::Click(3));
        lab.click(&format!("trail.decay:{way}"));
        let wanted = wanted.to_string();
        lab.wait(way, |seen| seen["values"]["trail.decay"] == wanted.as_str());
    }
    assert_ne!(usual, decay, "there are two");
    lab.find("position");
    let position = "object.0.position";
    views::drag_until(&lab, &format!("{position}.x"), (48, 0), position);
    assert!(saved.next().objects[0].position[0] > 0.1);
    for way in ["Escape", "filter.clear"] {
        lab.find("position");
        if way == "Escape" {
            lab.click("filter");
            lab.key(way);
        } else {
            lab.click(way);
        }
        lab.wait(way, |seen| seen["values"]["filter"] == "");
    }

    // Sections close and open.
    let row = |seen: &Value| seen["places"]["physarum.speed"].is_array();
    lab.click("section=Picture");
    lab.wait("it is closed", |seen| {
        seen["places"]["colors"].is_null() && row(seen)
    });
    lab.click("section=Physarum");
    lab.wait("it is closed, too", |seen| !row(seen));
    lab.click("section=Physarum");
    lab.wait("it is open again", row);
    lab.quit();
}

#[test]
fn a_scene_on_its_way_can_be_given_up() {
    if !can_open() {
        return;
    }
    let lab = Lab::open(&SMALL);
    let given_up = |seen: &Value| {
        let notice = seen["state"]["notice"].as_str();
        seen["state"]["loading"] == false
            && notice.is_some_and(|text| text.contains("was not loaded"))
    };
    let count = "particles.count";
    for way in ["cancel", "Escape"] {
        let before = lab.step();
        lab.find(count);
        lab.type_until(count, 0.9, "60000000", count, "60000000");
        lab.click("restart");
        if way == "cancel" {
            lab.click("cancel");
        } else {
            lab.place("cancel");
            lab.key(way);
        }
        lab.wait("it is given up", given_up);
        lab.wait("the simulation continues", |seen| step(seen) > before);
        lab.click_until("discard", "pending", false);
        // The notice of the first is not that of the second.
        lab.key("F12");
        lab.wait("something else is said", |seen| !given_up(seen));
    }
    assert_eq!(lab.save("cube").particles.count, 3000);
    lab.quit();
}
