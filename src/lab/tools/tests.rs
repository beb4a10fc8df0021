//! Scenes with an object more or less, and the effects of brushes.

use super::*;
use crate::lab::objects::{
    begin_on_food_that_is, remove_food, with_copy, with_object, without_object,
};
use crate::lab::saving::is_mesh;
use myxo::scene::motion::pose_at;
use myxo::scene::settings::{ObjectSettings, Settings, Start};

fn two() -> Settings {
    let mut settings = with_object(&Settings::default(), "builtin:cube", 0.5, [1.0, 0.0, 0.0]);
    for (object, name) in settings.objects.iter_mut().zip(["ring", "box"]) {
        object.name = name.to_owned();
    }
    settings
}

#[test]
fn objects_come_and_go() {
    let mut settings = two();
    assert_eq!(settings.objects.len(), 2);
    let cube = &settings.objects[1];
    assert_eq!((cube.scale, cube.position), (0.5, [1.0, 0.0, 0.0]));
    settings.objects[0].distance_to = vec!["box".to_owned()];
    let left = without_object(&settings, 1);
    assert_eq!(left.objects.len(), 1);
    assert!(
        left.objects[0].distance_to.is_empty(),
        "it names no removed object"
    );
    assert!(is_mesh(std::path::Path::new("a/b.GLB")) && !is_mesh(std::path::Path::new("a.toml")));
}

#[test]
fn a_copy_has_all_of_its_original_but_the_name_and_the_place() {
    let mut settings = two();
    settings.objects[1].motion.spin = [0.0, 30.0, 0.0];
    settings.objects[1].motion.orbit = [0.0, 20.0, 0.0];
    settings.objects[1].motion.slide = [0.0, 0.5, 0.0];
    settings.objects[1].physarum.speed = Some(0.01);
    settings.foods.push(FoodSettings {
        object: "box".to_owned(),
        ..FoodSettings::default()
    });
    let (way, time) = (Vec3::new(0.0, 0.2, 1.5), 3.0);
    let copied = with_copy(&settings, 1, way, time);
    assert_eq!(copied.objects[..2], settings.objects);
    assert_eq!(copied.foods, settings.foods, "food stays where it lies");
    let [_, original, copy] = &copied.objects[..] else {
        panic!("{:?}", copied.objects)
    };
    assert_eq!(copy.name, "box 2");
    let alike = ObjectSettings {
        name: original.name.clone(),
        position: original.position,
        ..copy.clone()
    };
    assert_eq!(alike, *original);
    // It stands there now, and its distance stays equal at any time.
    let apart = |time: f64| {
        let [one, other] = [original, copy].map(|object| pose_at(object, None, time).translation);
        (other - one).as_vec3()
    };
    assert!(apart(time).distance(way) < 1e-4, "{}", apart(time));
    for later in [0.0, 4.5, 11.0] {
        let length = apart(later).length();
        assert!((length - way.length()).abs() < 1e-3, "{length}");
    }
    // Names that no other has, by number.
    let names = |settings: &Settings| settings.objects.last().map(|o| o.name.clone());
    let again = with_copy(&copied, 2, way, time);
    assert_eq!(names(&again).as_deref(), Some("box 3"));
    let again = with_copy(&without_object(&again, 2), 0, way, time);
    assert_eq!(names(&again).as_deref(), Some("ring 2"));
    let again = with_copy(&again, 2, way, time);
    assert_eq!(names(&again).as_deref(), Some("box 2"));
}

#[test]
fn particles_that_begin_on_a_removed_object_begin_elsewhere() {
    let mut settings = two();
    settings.particles.start_object = "box".to_owned();
    settings.particles.start = Start::Food;
    settings.particles.start_food = 2;
    for object in ["box", "ring", "ring"] {
        settings.foods.push(FoodSettings {
            object: object.to_owned(),
            ..FoodSettings::default()
        });
    }
    let left = without_object(&settings, 1);
    assert!(left.particles.start_object.is_empty());
    assert_eq!((left.foods.len(), left.particles.start_food), (2, 1));
    let left = without_object(&settings, 0);
    assert_eq!(left.particles.start_object, "box");
    // The particles begin on the one food that is left.
    assert_eq!((left.foods.len(), left.particles.start_food), (1, 0));
    let can_begin = |settings| {
        let scene = Scene::from_settings("left".to_owned(), settings, ".".into());
        scene.expect("it can begin");
    };
    can_begin(left.clone());
    // None is left.
    let mut none = left;
    remove_food(&mut none, 0);
    assert_eq!(none.particles.start, Start::default());
    can_begin(none);
    // Fewer are scattered than where it began.
    settings.foods.clear();
    settings.feeding.scattered = 1;
    begin_on_food_that_is(&mut settings);
    assert_eq!(
        (settings.particles.start, settings.particles.start_food),
        (Start::Food, 0)
    );
    can_begin(settings);
}

#[test]
fn brushes_do_as_much_in_a_second_at_any_frame_rate() {
    let mut tools = Tools::new();
    assert_eq!(tools.brush(0.1, 12.0), None);
    for tool in Tool::ALL.into_iter().filter(|tool| tool.is_brush()) {
        tools.take(tool);
        assert_eq!(tools.tool, tool);
        let (one, half) = (tools.brush(0.1, 12.0), tools.brush(0.05, 12.0));
        match (one.unwrap(), half.unwrap()) {
            (Brush::Trail { amount: a }, Brush::Trail { amount: b })
            | (Brush::Look { amount: a }, Brush::Look { amount: b })
            | (Brush::Attract { amount: a }, Brush::Attract { amount: b }) => {
                assert!((a - 2.0 * b).abs() < 1e-4 && (a > 0.0) == (tool != Tool::Repel));
            }
            (Brush::Erase { share: a }, Brush::Erase { share: b })
            | (Brush::Particles { share: a }, Brush::Particles { share: b }) => {
                assert!(((1.0 - a) - (1.0 - b) * (1.0 - b)).abs() < 1e-5 && a < 1.0);
            }
            (Brush::NoGo, Brush::NoGo) => {}
            others => panic!("{others:?}"),
        }
    }
    assert!(tools.back() && tools.tool == Tool::Look && !tools.back());
    tools.toggle_brush();
    assert_eq!(tools.tool, Tool::Particles, "the one used last");
    tools.selected = Some(0);
    tools.toggle_brush();
    assert!(tools.back() && tools.selected.is_none());
}
