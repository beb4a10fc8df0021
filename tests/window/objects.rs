//! Whole objects: scaled by the box beside the middle one, added, removed, and each undone. The simulation continues each time.

use myxo::mesh::builtin::BUILTINS;

use serde_json::Value;

use crate::program::{Folder, path};
use crate::tools::SCENE;
use crate::{Lab, can_open, views, with_scene};

/// Waits until so many objects run and nothing is being loaded; the simulation has not restarted.
#[track_caller]
fn there_are(lab: &Lab, count: &str, since: u64) {
    lab.wait(count, |seen| {
        seen["values"]["objects"] == count
            && seen["state"]["loading"] == false
            && seen["state"]["pending"] == false
    });
    assert_eq!(lab.step(), since, "it has not restarted");
}

/// Adds one by the menu.
#[track_caller]
fn add(lab: &Lab, name: &str) {
    lab.click("add");
    lab.click(&format!("add={name}"));
    lab.wait(name, |seen: &Value| {
        seen["state"]["loading"] == true || seen["values"]["objects"] == "3"
    });
}

#[test]
fn objects_are_duplicated() {
    if !can_open() {
        return;
    }
    let folder = Folder::new();
    let ball = "icosphere?subdivisions=3\"\n";
    let turning = SCENE.replace(
        ball,
        &format!("{ball}motion = {{ spin = [0.0, 40.0, 0.0] }}\n"),
    );
    let file = folder.with("pair.toml", &turning);
    let lab = Lab::open(&[path(&file)]);
    lab.grows_beyond(20);
    lab.hold();
    let grown = lab.step();
    there_are(&lab, "2", grown);
    let start = lab.save("pair");
    lab.pick("ball");
    lab.click("duplicate");
    there_are(&lab, "3", grown);
    lab.wait("it is picked", |seen| seen["values"]["picked"] == "ball 2");
    let twice = lab.save("pair");
    assert_eq!(twice.objects[..2], start.objects);
    let [ball, _, copy] = &twice.objects[..] else {
        panic!("{:?}", twice.objects)
    };
    assert_eq!((&copy.mesh, copy.scale), (&ball.mesh, ball.scale));
    assert_eq!(copy.motion.spin, [0.0, 40.0, 0.0]);
    let way = (copy.position.iter())
        .zip(ball.position)
        .map(|(a, b)| a - b);
    let away = way.map(|x| x * x).sum::<f64>().sqrt();
    // Balls of radius 1.
    assert!(away > 2.0, "{away}: one is in the other");

    // The copy is removed by its key.
    lab.key("ctrl+d");
    there_are(&lab, "4", grown);
    lab.wait("it is picked", |seen| seen["values"]["picked"] == "ball 3");
    let thrice = lab.save("pair");
    assert_eq!(thrice.objects[..3], twice.objects);
    // Both are undone one after the other, and redone.
    for (key, wanted) in [
        ("ctrl+z", &twice),
        ("ctrl+z", &start),
        ("ctrl+shift+z", &twice),
    ] {
        lab.key(key);
        there_are(&lab, &wanted.objects.len().to_string(), grown);
        assert_eq!(lab.save("pair").objects, wanted.objects);
    }
    // Duplicated twice at once, and the second is undone before it is there.
    lab.pick("ball");
    for key in ["ctrl+d", "ctrl+d", "Delete"] {
        lab.key(key);
    }
    // The count is briefly the same before the second one comes.
    there_are(&lab, "4", grown);
    lab.look_at(60);
    there_are(&lab, "4", grown);
    let rest = lab.save("pair");
    assert_eq!(rest.objects[..3], twice.objects);
    assert_eq!(rest.objects[3].name, "ball 3");
    lab.key_until("space", "it runs", "playing", true);
    lab.wait("the simulation continues", |seen| {
        seen["state"]["step"].as_u64() > Some(grown)
    });
    lab.quit();
}

/// The list of objects: each of its controls does what it says, and what runs goes on.
#[test]
fn the_list_hides_locks_and_renames_objects() {
    let Some((_folder, lab)) = with_scene("pair.toml", SCENE) else {
        return;
    };
    lab.grows_beyond(20);
    lab.hold();
    let grown = lab.step();
    lab.pick("ball");
    lab.find("outliner");
    let listed = |list: &str| {
        lab.wait(list, |seen| seen["values"]["objects.list"] == list);
    };
    let start = lab.save("pair");
    let [ball, other] = [0, 1].map(|i| start.objects[i].name.clone());
    listed(&format!("{ball} {other}"));
    let picked = |name: &str| lab.wait(name, |seen| seen["values"]["picked"] == name);

    lab.click("objects.name=1");
    picked(&other);
    lab.click("objects.name=0");
    picked(&ball);
    // Hidden, it is picked no longer, and what is behind it is.
    lab.click("objects.eye=0");
    listed(&format!("({ball}) {other}"));
    lab.point("picture", 0.5);
    lab.press();
    lab.look_at(3);
    let seen = lab.seen().expect("a frame was reported");
    assert_ne!(seen["values"]["picked"], ball.as_str());
    lab.click("objects.alone=0");
    listed(&format!("{ball} ({other})"));
    lab.click("objects.alone=0");
    listed(&format!("{ball} {other}"));
    // By keys.
    lab.pick(&ball);
    lab.key("ctrl+h");
    listed(&format!("({ball}) {other}"));
    lab.key("ctrl+shift+h");
    listed(&format!("{ball} {other}"));
    // Locked, no click picks it.
    lab.click("objects.lock=0");
    listed(&format!("{ball}! {other}"));
    lab.point("picture", 0.5);
    lab.press();
    lab.look_at(3);
    let seen = lab.seen().expect("a frame was reported");
    assert_ne!(seen["values"]["picked"], ball.as_str());
    lab.click("objects.lock=0");
    listed(&format!("{ball} {other}"));
    lab.pick(&ball);
    // Nothing of that is a change.
    assert_eq!(lab.save("pair"), start);

    lab.click("objects.rename=0");
    lab.wait("it is typed", |seen| seen["state"]["typing"] == true);
    lab.click("objects.typed");
    lab.key("ctrl+a");
    lab.write("sun");
    lab.key("Return");
    listed(&format!("sun {other}"));
    there_are(&lab, "2", grown);
    assert_eq!(lab.save("pair").objects[0].name, "sun");
    lab.key("ctrl+z");
    listed(&format!("{ball} {other}"));
    assert_eq!(lab.save("pair"), start);
    views::look_for_nothing(&lab);
    lab.quit();
}

/// Takes long: every mesh that can be added is laid out and joins.
#[test]
fn objects_are_scaled_added_and_removed() {
    let Some((_folder, lab)) = with_scene("pair.toml", SCENE) else {
        return;
    };
    lab.grows_beyond(20);
    lab.hold();
    let grown = lab.step();
    there_are(&lab, "2", grown);
    let start = lab.save("pair");

    // Scaled, and undone.
    lab.pick("ball");
    lab.pull("gizmo=scale", [6, -6]);
    lab.wait("it has grown", |seen| {
        let scale = seen["values"]["picked.scale"].as_str();
        scale.and_then(|scale| scale.parse().ok()) > Some(1.2)
    });
    there_are(&lab, "2", grown);
    let scaled = lab.save("pair");
    assert!(scaled.objects[0].scale > 1.2, "{:?}", scaled.objects[0]);
    assert_eq!(scaled.objects[0].position, start.objects[0].position);
    assert_eq!(scaled.objects[1], start.objects[1], "the other one stays");
    lab.key("ctrl+z");
    lab.wait("it is as it was", |seen| {
        seen["values"]["picked.scale"] == "1" && seen["values"]["picked"] == "ball"
    });
    there_are(&lab, "2", grown);
    assert_eq!(lab.save("pair").objects, start.objects);
    lab.key("ctrl+shift+z");
    lab.wait("it is larger again", |seen| {
        seen["values"]["picked.scale"] != "1"
    });
    there_are(&lab, "2", grown);
    assert_eq!(lab.save("pair").objects, scaled.objects);

    // An added object has its section in the panel.
    add(&lab, "capsule");
    there_are(&lab, "3", grown);
    lab.wait("it is picked", |seen| seen["values"]["picked"] == "capsule");
    let added = lab.save("pair");
    assert_eq!(added.objects[2].mesh, "builtin:capsule");
    assert_eq!(added.objects[..2], scaled.objects);
    lab.find("position");
    let place = "object.2.position";
    let before = lab.place(&format!("{place}.y"));
    assert!(before[2] > before[0], "it has a row");
    lab.type_into(&format!("{place}.y"), 0.6, "0.75");
    lab.wait("it is moved", |seen| {
        let words = seen["values"][place].as_str();
        words.is_some_and(|words| words.contains("0.75"))
    });
    let moved = lab.save("pair");
    assert_eq!(moved.objects[2].position[1], 0.75);

    // Removed by the key and by the button, and undone one after the other.
    lab.key("Delete");
    there_are(&lab, "2", grown);
    assert_eq!(lab.save("pair").objects, scaled.objects);
    lab.key("ctrl+z");
    there_are(&lab, "3", grown);
    assert_eq!(lab.save("pair").objects, moved.objects);
    lab.pick("ball");
    lab.click("remove");
    there_are(&lab, "2", grown);
    assert_eq!(lab.save("pair").objects, moved.objects[1..]);
    lab.key("ctrl+z");
    there_are(&lab, "3", grown);
    assert_eq!(lab.save("pair").objects, moved.objects);
    for before in [&added, &scaled] {
        lab.key("ctrl+z");
        there_are(&lab, &before.objects.len().to_string(), grown);
        assert_eq!(lab.save("pair").objects, before.objects);
    }
    // Every other mesh of the menu, too.
    for (name, _) in BUILTINS.iter().filter(|(name, _)| *name != "capsule") {
        add(&lab, name);
        there_are(&lab, "3", grown);
        let mesh = lab.save("pair").objects.pop().map(|object| object.mesh);
        assert_eq!(mesh, Some(format!("builtin:{name}")));
        lab.key("ctrl+z");
        there_are(&lab, "2", grown);
    }
    lab.key_until("space", "it runs", "playing", true);
    lab.wait("the simulation continues", |seen| {
        seen["state"]["step"].as_u64() > Some(grown)
    });
    lab.quit();
}
