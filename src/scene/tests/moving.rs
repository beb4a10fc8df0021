//! Tests of motion: objects have the right pose at every time, and senseless motion is refused.

use glam::{DAffine3, DQuat, DVec3};

use crate::mesh::Mesh;
use crate::scene::Scene;
use crate::scene::file::Reader;
use crate::scene::motion::{Keyframe, pose_at};
use crate::scene::settings::{ObjectSettings, Settings};

/// The settings of an object with these lines.
fn object(lines: &str) -> ObjectSettings {
    let settings = read(lines).unwrap_or_else(|problems| panic!("{problems:#?}"));
    settings.objects[0].clone()
}

fn read(lines: &str) -> Result<Settings, Vec<String>> {
    let mut reader = Reader::new(Settings::default());
    reader.text("", &format!("[[object]]\n{lines}"));
    reader
        .finish()
        .map_err(|problems| problems.iter().map(ToString::to_string).collect())
}

fn near(pose: DAffine3, expected: DAffine3, what: &str) {
    assert!(
        pose.abs_diff_eq(expected, 1e-9),
        "{what}: {pose:?} is not {expected:?}"
    );
}

fn turned(axis: DVec3, degrees: f64) -> DQuat {
    DQuat::from_axis_angle(axis, degrees.to_radians())
}

#[test]
fn a_spin_goes_about_the_objects_own_axis() {
    let gear =
        object("position = [1, 2, 3]\nrotation = [90, 0, 0]\nmotion = { spin = [0, 30, 0] }");
    let tilt = turned(DVec3::X, 90.0);
    for time in [0.0, 1.0, 2.5, 100.0] {
        let expected = DAffine3::from_rotation_translation(
            tilt * turned(DVec3::Y, 30.0 * time),
            DVec3::new(1.0, 2.0, 3.0),
        );
        near(pose_at(&gear, None, time), expected, "spin");
    }
    // After a year the precision is not lower.
    let year = 365.0 * 24.0 * 3600.0;
    near(
        pose_at(&gear, None, year),
        pose_at(&gear, None, 0.0),
        "a year",
    );
}

#[test]
fn an_orbit_carries_the_object_round_its_centre() {
    let moon = object(
        "position = [3, 0, 0]\nmotion = { orbit = [0, 90, 0], orbit_center = [1, 0, 0], spin = [0, -90, 0] }",
    );
    // A quarter round Y takes +X to -Z; the spin undoes the turning.
    let expected = DAffine3::from_translation(DVec3::new(1.0, 0.0, -2.0));
    near(pose_at(&moon, None, 1.0), expected, "a quarter");
    near(
        pose_at(&moon, None, 4.0),
        pose_at(&moon, None, 0.0),
        "a round",
    );
}

#[test]
fn swings_and_slides_go_there_and_back() {
    let bob = object(
        "motion = { swing = [0, 0, 40], swing_period = 2, pivot = [0, 1, 0], slide = [0, 0, 3], slide_period = 4, slide_phase = 0.25 }",
    );
    for (time, degrees, slid) in [
        (0.0, 0.0, 3.0),
        (0.5, 40.0, 3.0 * 0.5_f64.sqrt()),
        (1.5, -40.0, -3.0 * 0.5_f64.sqrt()),
        (4.0, 0.0, 3.0),
    ] {
        let pose = pose_at(&bob, None, time);
        let pivot = pose.transform_point3(DVec3::Y);
        assert!(
            pivot.distance(DVec3::new(0.0, 1.0, slid)) < 1e-9,
            "{time}: {pivot}"
        );
        let expected = turned(DVec3::Z, degrees) * DVec3::X;
        assert!(
            pose.transform_vector3(DVec3::X).distance(expected) < 1e-9,
            "{time}"
        );
    }
}

#[test]
fn keyframes_loop_stop_or_turn_back() {
    let at = |more: &str, time: f64| {
        let text = format!(
            "position = [0, 5, 0]\n[object.motion]\n{more}\nkeyframes = [{{ time = 1, position = [1, 0, 0] }}, \
             {{ time = 3, position = [3, 0, 0], rotation = [0, 90, 0] }}]"
        );
        let pose = pose_at(&object(&text), None, time);
        assert!((pose.translation.y - 5.0).abs() < 1e-12);
        let turned = pose.transform_vector3(DVec3::X);
        (pose.translation.x, turned.z.atan2(turned.x).to_degrees())
    };
    let check = |more: &str, expected: &[(f64, f64, f64)]| {
        for &(time, x, degrees) in expected {
            let (is_x, is_degrees) = at(more, time);
            assert!(
                (is_x - x).abs() < 1e-9 && (is_degrees + degrees).abs() < 1e-9,
                "{more} at {time}: {is_x}, {is_degrees}"
            );
        }
    };
    check(
        "repeat = \"once\"",
        &[
            (0.0, 1.0, 0.0),
            (2.0, 2.0, 45.0),
            (3.0, 3.0, 90.0),
            (99.0, 3.0, 90.0),
        ],
    );
    // From 3 s to 4 s, which is 1 s of the next round, it goes back.
    check(
        "repeat = \"loop\"",
        &[
            (1.0, 1.0, 0.0),
            (2.5, 2.5, 67.5),
            (3.0, 3.0, 90.0),
            (3.5, 2.0, 45.0),
            (0.5, 2.0, 45.0),
            (4.0, 1.0, 0.0),
            (302.0, 2.0, 45.0),
        ],
    );
    check(
        "period = 5",
        &[
            (3.0, 3.0, 90.0),
            (4.5, 2.0, 45.0),
            (6.0, 1.0, 0.0),
            (5.0, 5.0 / 3.0, 30.0),
        ],
    );
    check(
        "repeat = \"mirror\"",
        &[
            (0.5, 1.0, 0.0),
            (3.0, 3.0, 90.0),
            (4.0, 2.0, 45.0),
            (5.5, 1.0, 0.0),
            (8.0, 2.0, 45.0),
        ],
    );
    check(
        "repeat = \"once\"\neasing = \"smooth\"",
        &[(1.5, 1.0 + 2.0 * 0.15625, 90.0 * 0.15625), (2.0, 2.0, 45.0)],
    );
    // One keyframe is a place.
    let one = object("motion = { keyframes = [{ time = 0, position = [7, 0, 0] }] }");
    for time in [0.0, 1.0, 50.0] {
        assert_eq!(pose_at(&one, None, time).translation.x, 7.0);
    }
}

/// No motion jumps from a time to one slightly later, not even across the ends of loops.
#[test]
fn motion_is_continuous() {
    let all = object(
        "[object.motion]\nspin = [10, 20, 30]\norbit = [5, -40, 0]\nswing = [0, 50, 0]\nslide = [1, 0, 0]\nperiod = 7\n\
         keyframes = [{ time = 0 }, { time = 2, rotation = [0, 170, 0] }, { time = 4, position = [0, 2, 0], rotation = [0, 190, 0] }]",
    );
    for i in 0..40_000 {
        let time = f64::from(i) * 1e-3;
        let (a, b) = (pose_at(&all, None, time), pose_at(&all, None, time + 1e-3));
        let moved = a
            .transform_point3(DVec3::ONE)
            .distance(b.transform_point3(DVec3::ONE));
        assert!(moved < 0.02, "at {time} it jumps by {moved}");
        let turn = a.matrix3.transpose() * a.matrix3;
        assert!(
            turn.abs_diff_eq(glam::DMat3::IDENTITY, 1e-12),
            "it is rigid at {time}"
        );
    }
}

#[test]
fn motion_that_makes_no_sense_is_refused() {
    for (lines, words) in [
        (
            "motion = { spins = [0, 1, 0] }",
            "object.0.motion.spins: no such key; did you mean object.0.motion.spin?",
        ),
        (
            "motion = { spin = 3 }",
            "object.0.motion.spin: a list of three numbers is expected, not 3",
        ),
        (
            "motion = { swing_period = 0 }",
            "object.0.motion.swing_period = 0 is out of range",
        ),
        ("motion = { repeat = \"lop\" }", "did you mean loop?"),
        (
            "motion = 5",
            "object.0.motion: a table of keys is expected, not 5",
        ),
        ("motion = { keyframes = 5 }", "a list of keyframes such as"),
        (
            "motion = { keyframes = [5] }",
            "object.0.motion.keyframes.0: a keyframe such as",
        ),
        (
            "motion = { keyframes = [{ position = [0, 0, 0] }] }",
            "needs a time",
        ),
        (
            "motion = { keyframes = [{ time = 2 }, { time = 1 }] }",
            "object.0.motion.keyframes.1 is at 1 s and the keyframe before it at 2 s: their times must ascend",
        ),
        (
            "motion = { keyframes = [{ time = 1 }, { time = 1 }] }",
            "their times must ascend",
        ),
        (
            "motion = { keyframes = [{ time = -1 }] }",
            "out of range: 0 to 1,000,000 seconds",
        ),
        (
            "motion = { keyframes = [{ time = 0, scale = 2 }] }",
            "cannot change its size while it runs",
        ),
        (
            "motion = { keyframes = [{ time = 0, postion = [0, 0, 0] }] }",
            "did you mean position?",
        ),
        ("scale = 0", "object.0.scale = 0 is out of range"),
        ("scale = -1", "object.0.scale = -1 is out of range"),
        (
            "physarum = { speed = -1 }",
            "object.0.physarum.speed = -1 is out of range: 0 to 10 scene radii per step",
        ),
        ("physarum = { sped = 1 }", "did you mean"),
    ] {
        let problems = read(lines).expect_err(lines);
        assert!(problems[0].contains(words), "{lines}: {problems:?}");
    }
}

#[test]
fn an_objects_own_values_stand_over_the_scenes() {
    let settings = read("physarum = { speed = 0.006, gravity_weight = 0 }").unwrap();
    let own = settings.objects[0].physarum.over(&settings.physarum);
    assert_eq!((own.speed, own.gravity_weight), (0.006, 0.0));
    assert_eq!(own.sensor_angle, settings.physarum.sensor_angle);
}

#[test]
fn scenes_made_in_code_are_checked_as_files_are() {
    let frame = |time: f32| Keyframe {
        time,
        position: [0.0; 3],
        rotation: [0.0; 3],
    };
    let refused = |change: fn(&mut Settings)| {
        let mut settings = Settings::default();
        settings.objects[0].motion.keyframes = [1.0, 2.0, 3.0].map(frame).to_vec();
        let mesh = Mesh::open("builtin:cube", ".".as_ref()).unwrap();
        let made = |settings: Settings| {
            let meshes = vec![mesh.clone()];
            Scene::from_meshes("made".to_owned(), settings, meshes, ".".into())
        };
        assert!(made(settings.clone()).is_ok());
        change(&mut settings);
        made(settings).unwrap_err().to_string()
    };
    let keyframes = |settings: &mut Settings| settings.objects[0].motion.keyframes.swap(0, 2);
    let said = refused(keyframes);
    for wanted in ["object.0.motion.keyframes.1.time = 2", "more than 3"] {
        assert!(said.contains(wanted), "{said}");
    }
    let said = refused(|settings| settings.objects[0].motion.keyframes[1].time = f32::NAN);
    assert!(said.contains("keyframes.1.time = NaN"), "{said}");
    let said =
        refused(|settings| settings.objects[0].motion.keyframes[2].position[1] = f32::INFINITY);
    assert!(
        said.contains("keyframes.2.position = [0.0, inf, 0.0]"),
        "{said}"
    );
    let said = refused(|settings| settings.objects[0].scale = 0.0);
    assert!(said.contains("object.0.scale = 0"), "{said}");
    let said = refused(|settings| settings.transfer.threshold = f32::NAN);
    assert!(said.contains("transfer.threshold = NaN"), "{said}");
}
