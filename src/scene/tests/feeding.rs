//! Food and markers in scene files.

use std::path::Path;

use crate::scene::file::Reader;
use crate::scene::settings::{Settings, Start};
use crate::scene::{Overrides, Scene, foods};

fn read(text: &str, assignments: &[&str]) -> Result<Settings, String> {
    let mut reader = Reader::new(Settings::default());
    reader.text("", text);
    for assignment in assignments {
        reader.assignment(assignment);
    }
    reader.finish().map_err(|problems| {
        let problems: Vec<String> = problems.iter().map(ToString::to_string).collect();
        problems.join("\n")
    })
}

fn load(settings: Settings) -> Result<Scene, String> {
    Scene::from_settings("test".to_owned(), settings, ".".into()).map_err(|e| e.to_string())
}

const TWO: &str = r#"
[[object]]
name = "ball"
mesh = "builtin:icosphere?subdivisions=1"

[[object]]
name = "box"
mesh = "builtin:cube"
position = [3.0, 0.0, 0.0]

[[food]]
object = "ball"
at = [0.0, 1.0, 0.0]
amount = 1000

[[food]]
object = "box"
at = [0.0, 1.0, 0.0]
strength = -4.5
size = 0
"#;

#[test]
fn foods_are_read_changed_and_written() {
    let settings = read(TWO, &["food.1.radius=0.75", "food.0.at.2=0.5"]).unwrap();
    let [food, marker] = &settings.foods[..] else {
        panic!("{:?}", settings.foods)
    };
    assert_eq!((food.amount, food.at), (1000, [0.0, 1.0, 0.5]));
    assert!(marker.is_marker() && !food.is_marker());
    assert_eq!((marker.strength, marker.radius), (-4.5, 0.75));
    // A written file reads back equally.
    assert_eq!(read(&settings.to_toml(), &[]).unwrap(), settings);
    assert!(!Settings::default().to_toml().contains("[[food]]"));
    let scene = load(settings).unwrap();
    assert_eq!(scene.settings.food_count(), 2);
}

/// The name is filled in, so that it stays right when objects are added.
#[test]
fn the_only_object_gets_the_food_that_names_none() {
    let settings = read("[[food]]\nat = [1, 0, 0]\n", &[]).unwrap();
    let scene = load(settings).unwrap();
    assert_eq!(
        scene.settings.foods[0].object,
        scene.settings.objects[0].name
    );
}

#[test]
fn wrong_food_is_refused() {
    for (text, words) in [
        (
            "[[food]]\nradius = 0\n",
            "food.0.radius = 0 is out of range",
        ),
        (
            "[[food]]\nstrength = nan\n",
            "food.0.strength = nan is out of range",
        ),
        ("[[food]]\nat = [0, inf, 0]\n", "food.0.at"),
        (
            "[[food]]\nat = [0, 1]\n",
            "a list of three numbers is expected",
        ),
        (
            "[[food]]\namount = -1\n",
            "food.0.amount = -1 is out of range",
        ),
        ("[[food]]\namount = 0.5\n", "a whole number is expected"),
        (
            "[[food]]\nprojection = -1\n",
            "food.0.projection = -1 is out of range",
        ),
        (
            "[[food]]\nprojection = nan\n",
            "food.0.projection = nan is out of range",
        ),
        (
            "[[food]]\nprojection = 2000000\n",
            "food.0.projection = 2000000 is out of range",
        ),
        (
            "[feeding]\nscent_across = 1.01\n",
            "feeding.scent_across = 1.01 is out of range",
        ),
        (
            "[feeding]\nprojection = -0.5\n",
            "feeding.projection = -0.5 is out of range",
        ),
        (
            "[feeding]\nprojection_covered = 1.5\n",
            "feeding.projection_covered = 1.5 is out of range",
        ),
        ("[[food]]\nstrenght = 1\n", "did you mean food.0.strength?"),
        ("food = 3\n", "[[food]] is expected"),
        ("[foood]\nat = 1\n", "did you mean [[food]]?"),
        (
            "[feeding]\nscattered = 257\n",
            "feeding.scattered = 257 is out of range",
        ),
        (
            "[feeding]\nfed_deposit = 0\n",
            "feeding.fed_deposit = 0 is out of range",
        ),
    ] {
        let problem = read(text, &[]).expect_err(text);
        assert!(problem.contains(words), "{problem}");
        // One value, one message.
        let is_single = !text.contains("projection") || problem.lines().count() == 1;
        assert!(is_single, "{problem}");
    }
    let problem = read("", &["food.0.radius=1"]).unwrap_err();
    assert!(problem.contains("the scene has no food"), "{problem}");
    let problem = read(TWO, &["food.2.radius=1"]).unwrap_err();
    assert!(problem.contains("has 2 foods"), "{problem}");

    for (change, words) in [
        (
            (|s| s.foods[0].object = "moon".to_owned()) as fn(&mut Settings),
            "no object \"moon\"; there is ball, box",
        ),
        (|s| s.foods[1].object.clear(), "food.1.object is empty"),
        (
            |s| s.foods = vec![s.foods[0].clone(); 257],
            "257 foods and markers",
        ),
        (
            |s| s.feeding.scattered = 255,
            "the scene has 257 foods and markers, and there may be 256",
        ),
        (
            |s| {
                s.particles.start = Start::Food;
                s.particles.start_food = 2;
            },
            "particles.start_food = 2",
        ),
        (
            |s| {
                s.foods.clear();
                s.particles.start = Start::Food;
            },
            "the scene has no food",
        ),
        (
            |s| {
                s.particles.count = 1 << 30;
                s.feeding.fed_deposit = 4;
            },
            "more than a texel can count",
        ),
    ] {
        let mut settings = read(TWO, &[]).unwrap();
        change(&mut settings);
        let problem = load(settings).map(|_| ()).unwrap_err();
        assert!(problem.contains(words), "{problem}");
    }
    assert!(foods::problems(&Settings::default()).is_empty());
}

#[test]
fn every_scene_can_have_scattered_food() {
    let overrides = Overrides {
        set: vec!["feeding.scattered=12".to_owned()],
        ..Overrides::default()
    };
    let (_, settings, _) = Scene::read(Path::new("trio"), &overrides).unwrap();
    assert_eq!(settings.food_count(), 12);
}
