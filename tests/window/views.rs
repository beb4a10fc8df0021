//! What the picture shows, the light, and the camera.

use myxo::scene::settings::{Legend, Show};
use serde_json::Value;

use crate::input::Gesture;
use crate::{Lab, SMALL, can_open, with_scene};

/// Drags until something has changed.
#[track_caller]
pub fn drag_until(lab: &Lab, name: &str, (right, down): (i32, i32), value: &str) {
    let shown = |seen: &Value| seen["values"][value].clone();
    let before = shown(&lab.seen().expect("the lab has reported"));
    let act = || {
        lab.point(name, 0.5);
        lab.drag(1, 6, (right / 6, down / 6));
    };
    lab.again_until(value, act, |seen| shown(seen) != before);
}

/// Empties the field that parameters are looked for in, so that the panel shows everything.
#[track_caller]
pub fn look_for_nothing(lab: &Lab) {
    let act = || {
        lab.click("filter");
        lab.key("ctrl+a");
        lab.key("BackSpace");
        lab.key("Return");
    };
    lab.again_until("the field is empty", act, |seen| {
        seen["values"]["filter"] == ""
    });
}

/// Clicks until a value of the report is as wanted.
#[track_caller]
fn click_for(lab: &Lab, name: &str, value: &str, wanted: &str) {
    let what = format!("{value} is {wanted}");
    lab.again_until(
        &what,
        || lab.click(name),
        |seen| seen["values"][value] == wanted,
    );
}

/// Two objects that touch, so that there is a distance to show.
const PAIR: &str = r#"
[particles]
count = 2000

[atlas]
size = 128

[[object]]
name = "ball"
mesh = "builtin:icosphere?subdivisions=2"

[[object]]
name = "other"
mesh = "builtin:icosphere?subdivisions=2"
position = [1.9, 0, 0]
"#;

#[test]
fn every_view_can_be_chosen_and_is_reported() {
    let Some((_folder, lab)) = with_scene("touching.toml", PAIR) else {
        return;
    };
    for show in Show::ALL.iter().rev() {
        let word = show.word();
        lab.click_until(&format!("show={word}"), "show", word);
        // The legend, in views with the trail's colours.
        let is_of_trail = show.legend() == Legend::Trail;
        lab.wait("the legend", |seen| {
            let brightest = seen["values"]["brightest"].as_str();
            let value = brightest.and_then(|value| value.parse::<f32>().ok());
            if is_of_trail {
                value > Some(0.0)
            } else {
                value.is_none()
            }
        });
    }
    for show in Show::ALL {
        if let Some((key, _)) = show.key() {
            lab.key_until(&key.to_lowercase(), show.word(), "show", show.word());
        }
    }
    lab.key_until("9", "nearest", "show", "nearest");
    assert_eq!(lab.save("touching").picture.show.word(), "nearest");
    // The texture beside the picture.
    lab.key_until("u", "it is split", "split", true);
    lab.place("beside");
    let camera = lab.save("touching").camera;
    drag_until(&lab, "beside", (60, 30), "atlas");
    assert_eq!(
        lab.save("touching").camera,
        camera,
        "it is the atlas that moved"
    );
    lab.click_until("split", "split", false);
    // The view is copied as text and pasted.
    lab.key("ctrl+c");
    lab.wait("it is in the clipboard", |seen| {
        let notice = seen["state"]["notice"].as_str();
        notice.is_some_and(|text| text.contains("clipboard"))
    });
    lab.key_until("2", "relief", "show", "relief");
    lab.find("trail.decay");
    lab.place("trail.decay");
    let decay = lab.value("trail.decay");
    lab.type_until("trail.decay", 0.9, "0.5", "trail.decay", "0.5");
    let before = lab.seen().expect("the lab has reported")["state"]["step"].as_u64();
    lab.key("ctrl+v");
    let seen = lab.wait("the view is back", |seen| {
        seen["state"]["show"] == "nearest" && seen["values"]["trail.decay"] == decay.as_str()
    });
    // Values that can change while it runs do not restart the scene.
    assert_eq!(seen["state"]["loading"], false);
    assert!(seen["state"]["step"].as_u64() >= before, "{seen}");
    lab.wait("the simulation continues", |seen| {
        seen["state"]["step"].as_u64() > before
    });
    lab.key("ctrl+z");
    lab.wait("it can be undone", |seen| {
        seen["values"]["trail.decay"] == "0.5"
    });
    lab.quit();
}

#[test]
fn the_light_and_the_camera_can_be_moved() {
    if !can_open() {
        return;
    }
    let lab = Lab::open(&SMALL);
    lab.hold();
    let before = lab.save("cube");
    // A single object has no distances, and a notice says so.
    lab.key("8");
    lab.wait("a notice", |seen| {
        let notice = seen["state"]["notice"].as_str();
        notice.is_some_and(|text| text.contains("needs a second object"))
    });

    lab.find("light");
    for (name, share, number) in [
        ("picture.light_azimuth", 0.9, "60"),
        ("picture.light_elevation", 0.9, "-20"),
        ("picture.occlusion", 0.9, "0.25"),
    ] {
        lab.type_until(name, share, number, name, number);
    }
    let lit = lab.save("cube").picture;
    assert_eq!((lit.light_azimuth, lit.light_elevation), (60.0, -20.0));
    assert_eq!(lit.occlusion, 0.25);
    drag_until(&lab, "light", (-12, -12), "light");
    let dragged = lab.save("cube").picture;
    assert!(
        dragged.light_azimuth < 0.0 && dragged.light_elevation > 5.0,
        "{dragged:?}"
    );
    look_for_nothing(&lab);
    lab.perform(Gesture::KeyDown("l"));
    drag_until(&lab, "picture", (90, 0), "light");
    lab.perform(Gesture::KeyUp("l"));
    let moved = lab.save("cube");
    assert!(
        moved.picture.light_azimuth > dragged.light_azimuth + 5.0,
        "{:?}",
        moved.picture
    );
    assert_eq!(moved.camera, before.camera);
    let light = format!(
        "{:.0} {:.0}",
        dragged.light_azimuth, dragged.light_elevation
    );
    click_for(&lab, "undo", "light", &light);

    // A colour from the square that opens below the button.
    lab.find("picture.background");
    let color = |seen: &Value| seen["values"]["picture.background"].clone();
    let first = color(&lab.seen().expect("the lab has reported"));
    lab.click("picture.background=color");
    lab.perform(Gesture::MoveBy(120, 150));
    lab.press();
    lab.wait("another background", |seen| color(seen) != first);
    lab.key("Escape");
    let background = lab.save("cube").picture.background;
    assert_ne!(background, moved.picture.background);

    lab.find("camera");
    for (side, camera) in [
        ("front", "0 0"),
        ("back", "180 0"),
        ("left", "270 0"),
        ("right", "90 0"),
        ("top", "0 88"),
        ("bottom", "0 -88"),
    ] {
        click_for(&lab, &format!("view={side}"), "camera", camera);
    }
    let top = lab.save("cube").camera;
    assert!((top.elevation + 88.0).abs() < 1.0, "{top:?}");
    let home = &before.camera;
    let home = format!("{:.0} {:.0}", home.azimuth, home.elevation);
    click_for(&lab, "view=home", "camera", &home);
    let home = lab.save("cube").camera;
    // The axes in the corner of the picture.
    for (axis, camera) in [
        ("x", "90 0"),
        ("z", "0 0"),
        ("-x", "270 0"),
        ("-z", "180 0"),
        ("y", "0 88"),
    ] {
        click_for(&lab, &format!("axis={axis}"), "camera", camera);
    }
    lab.click("view=home");
    click_for(&lab, "axis=-y", "camera", "0 -88");
    lab.click("view=home");
    drag_until(&lab, "axes", (24, 0), "camera");
    lab.click("view=home");
    for glides in ["false", "true"] {
        lab.click("glides");
        lab.wait("it is another", |seen| seen["values"]["glides"] == glides);
    }
    assert_eq!(lab.save("cube").camera, home);
    let key = "camera.field_of_view";
    lab.type_until(key, 0.9, "75", key, "75");
    let wide = lab.save("cube").camera;
    assert!((wide.field_of_view - 75.0).abs() < 0.1 && wide.distance < 0.8 * home.distance);

    lab.key_until("v", "it flies", "flying", true);
    let target = lab.seen().expect("the lab has reported")["values"]["camera.target"].clone();
    lab.perform(Gesture::KeyDown("w"));
    lab.wait("it goes forward", |seen| {
        seen["values"]["camera.target"] != target
    });
    lab.perform(Gesture::KeyUp("w"));
    let gone = lab.save("cube").camera;
    assert_ne!(gone.target, wide.target, "forward");
    assert_eq!(
        (gone.azimuth, gone.elevation),
        (wide.azimuth, wide.elevation)
    );
    drag_until(&lab, "picture", (60, 0), "camera");
    let looked = lab.save("cube").camera;
    assert!((looked.azimuth - gone.azimuth).abs() > 1.0, "{looked:?}");
    // Each direction and back, and the wheel for the speed.
    let mut at = looked.target;
    let mut go = |key: &str| {
        let before = lab.seen().expect("the lab has reported")["values"]["camera.target"].clone();
        lab.perform(Gesture::KeyDown(key));
        lab.wait(key, |seen| seen["values"]["camera.target"] != before);
        lab.perform(Gesture::KeyUp(key));
        let target = lab.save("cube").camera.target;
        let way: [f32; 3] = std::array::from_fn(|i| target[i] - at[i]);
        at = target;
        way
    };
    for (there, back) in [("w", "s"), ("d", "a"), ("e", "q")] {
        let [there, back] = [there, back].map(&mut go);
        let along: f32 = there.iter().zip(back).map(|(a, b)| a * b).sum();
        assert!(along < 0.0, "{there:?} and {back:?}");
    }
    let speed = |seen: &Value| seen["values"]["fly.speed"].as_str()?.parse::<f32>().ok();
    let before = speed(&lab.seen().expect("the lab has reported"));
    lab.point("picture", 0.5);
    lab.perform(Gesture::Wheel(true));
    lab.wait("it is quicker", |seen| speed(seen) > before);
    let quicker = lab.seen().expect("the lab has reported");
    lab.perform(Gesture::KeyDown("Shift_L"));
    let four_times = speed(&quicker).map(|speed| 4.0 * speed);
    lab.wait("Shift hurries", |seen| speed(seen) == four_times);
    lab.perform(Gesture::KeyUp("Shift_L"));
    lab.wait("no longer", |seen| speed(seen) == speed(&quicker));
    lab.click_until("fly", "flying", false);
    lab.quit();
}
