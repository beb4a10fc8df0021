//! The panel: each parameter is changed by its control, and the saved scene has the new value.

use crate::program::{Folder, path};
use crate::{Lab, SMALL, can_open, out};
use myxo::scene::parameters::{
    FOOD_PARAMETERS, Kind, OBJECT_PARAMETERS, Own, PARAMETERS, Parameter, why_idle,
};
use myxo::scene::settings::{AtlasMethod, DepthMapping, ObjectStart, Show, Start, Strategy};
use myxo::scene::{Overrides, Scene};

/// A number that the parameter may have and does not have now, as people type it.
fn other_number(range: (f64, f64), integer: bool, now: f64) -> String {
    let (low, high) = range;
    let share = if (now - low).abs() < 0.3 * (high - low) {
        0.5
    } else {
        0.125
    };
    let value = low + share * (high - low);
    if integer {
        format!("{}", value.round().max(low + 1.0))
    } else {
        format!("{}", (value * 1e4).round() / 1e4)
    }
}

/// Operates one parameter, whose controls' names begin with `prefix`, and returns the scene as it must be then. The new value differs from
/// the present one and, if there are enough words, from that of `first`.
#[track_caller]
fn turn<T: Clone>(lab: &Lab, parameter: &Parameter<T>, prefix: &str, scene: &T, first: &T) -> T {
    let name = format!("{prefix}{}", parameter.key);
    // Names of some food keys are part of other names, so they are found by the full key.
    let is_food = prefix.starts_with("food");
    lab.find(if is_food { &name } else { parameter.key });
    let mut after = scene.clone();
    match &parameter.kind {
        Kind::Number(number) => {
            let text = other_number(number.slider, number.integer, (number.get)(scene));
            (number.set)(&mut after, text.parse().expect("it is a number"));
            lab.type_until(&name, 0.9, &text, &name, &parameter.value(&after));
        }
        Kind::Own(Own {
            slider,
            integer,
            set,
            ..
        }) => {
            lab.click(&format!("{name}:own"));
            let text = other_number(*slider, *integer, f64::INFINITY);
            set(&mut after, Some(text.parse().expect("it is a number")));
            lab.type_until(&name, 0.9, &text, &name, &parameter.value(&after));
        }
        Kind::Choice { words, get, set } => {
            let count = words.len();
            let others = (1..count).map(|ahead| (get(scene) + ahead) % count);
            let next = others.clone().find(|&word| word != get(first));
            let next = next.or(others.clone().next()).expect("there are two words");
            lab.click(&format!("{name}={}", words[next]));
            set(&mut after, next);
        }
        Kind::Text { set, .. } if parameter.key.ends_with("object") => {
            set(&mut after, "ball".to_owned());
            lab.click(&name);
            lab.click(&format!("{name}=ball"));
            lab.wait("it is chosen", |seen| seen["values"][&name] == "ball");
        }
        Kind::Text { set, .. } => {
            set(&mut after, PICTURE.to_owned());
            lab.type_until(&name, 0.5, PICTURE, &name, PICTURE);
        }
        Kind::Vector {
            range,
            is_double,
            get,
            set,
        } => {
            let mut vector = get(scene);
            let axes = ["x", "y", "z"].into_iter().enumerate();
            for (component, (place, axis)) in vector.iter_mut().zip(axes) {
                let value = (*component + 0.25).min(range.1 - 0.25);
                let (value, typed) = match is_double {
                    true => (value, format!("{value}")),
                    false => (f64::from(value as f32), format!("{}", value as f32)),
                };
                *component = value;
                let box_of_axis = format!("{name}.{axis}");
                let mut so_far = after.clone();
                let mut known = get(&so_far);
                known[place] = value;
                set(&mut so_far, known);
                let all = parameter.value(&so_far);
                lab.type_until(&box_of_axis, 0.6, &typed, &name, &all);
                after = so_far;
            }
            assert_eq!(get(&after), vector);
        }
    }
    after
}

/// Two objects that move, so that everything has an effect, and food; small, so that frames are quick.
const SCENE: &str = r#"
[particles]
count = 2000
start = "ring"
start_heading = "aligned"

[atlas]
method = "grid"
size = 128

[areas]
map = "areas.png"

[distance]
method = "raster"

[feeding]
scattered = 3

[picture]
show = "particles"
brightest = 20

[[object]]
name = "ring"
mesh = "builtin:torus?major=24&minor=12"

[[food]]
object = "ring"
at = [1.4, 0, 0]

[[object]]
name = "ball"
mesh = "builtin:icosphere?subdivisions=2"
scale = 0.45
start = { place = "disc", heading = "aligned" }
motion = { spin = [0, 10, 0], orbit = [0, 5, 0], swing = [5, 0, 0], slide = [0, 0.1, 0], keyframes = [{ time = 0 }, { time = 5, position = [0.1, 0, 0] }] }
"#;

/// A map that is light enough for a start, and attracts.
const PICTURE: &str = "ball.png";

const MODEL: &str = "motion.model";
const SENSING: &str = "physarum.sensing";
const START_FOOD: &str = "particles.start_food";
const DEPTHS: [(&str, &str, DepthMapping); 2] = [
    ("distance.depth_near", "clip", DepthMapping::Clip),
    ("distance.depth_scale", "logistic", DepthMapping::Logistic),
];
/// Particles are drawn without the trail.
const OF_TRAIL: [&str; 2] = ["picture.brightest", "picture.darkest"];

/// Parameters with buttons or a list have no row; other tests operate them.
fn has_row(parameter: &Parameter) -> bool {
    !matches!(parameter.key, "picture.show" | "picture.color_map")
}

fn is_word<T>(parameter: &Parameter<T>) -> bool {
    matches!(parameter.kind, Kind::Choice { .. })
}

/// Takes long: it changes each of some 80 parameters.
#[test]
fn every_parameter_can_be_changed_in_the_panel() {
    if !can_open() {
        return;
    }
    let folder = Folder::new();
    let file = folder.with("lively.toml", SCENE);
    let green = image::RgbImage::from_pixel(16, 16, image::Rgb([0, 255, 0]));
    for picture in [PICTURE, "areas.png"] {
        green.save(folder.file(picture)).expect("it can be written");
    }
    let lab = Lab::open(&[path(&file)]);
    let before = Scene::read(&file, &Overrides::default())
        .expect("it is a scene")
        .1;
    lab.hold();

    let ball = 1;
    let prefix = format!("object.{ball}.");
    let mut expected = before.clone();
    // With gravity, all sensors walk.
    let sensing = PARAMETERS.iter().find(|p| p.key == SENSING);
    let sensing = sensing.expect("it is in the table");
    expected = turn(&lab, sensing, "", &expected, &before);
    // Choices can disable numbers, so they come last, and choices that others depend on after those.
    let (lively, idle): (Vec<&Parameter>, Vec<&Parameter>) = PARAMETERS
        .iter()
        .filter(|p| has_row(p) && !is_word(p))
        .partition(|p| why_idle(p.key, &before).is_none());
    for parameter in lively {
        expected = turn(&lab, parameter, "", &expected, &before);
    }
    // Only the start `mask` has a mask.
    lab.find("particles.start");
    lab.click("particles.start=mask");
    expected.particles.start = Start::Mask;
    let (of_food, idle): (Vec<&Parameter>, Vec<&Parameter>) =
        (idle.into_iter()).partition(|p| p.key == START_FOOD);
    let (of_trail, idle): (Vec<&Parameter>, Vec<&Parameter>) =
        (idle.into_iter()).partition(|p| OF_TRAIL.contains(&p.key));
    for parameter in idle {
        // Each of these belongs to some depths only.
        let depth = DEPTHS.iter().find(|(key, ..)| *key == parameter.key);
        if let Some(&(_, word, depth)) = depth {
            lab.find("distance.depth");
            lab.click(&format!("distance.depth={word}"));
            expected.distance.depth = depth;
        }
        expected = turn(&lab, parameter, "", &expected, &before);
    }
    lab.key("Escape");
    lab.key_until("1", "the surface", "show", "surface");
    expected.picture.show = Show::Surface;
    for parameter in of_trail {
        expected = turn(&lab, parameter, "", &expected, &before);
    }
    // Only the start `food` asks which food.
    lab.find("particles.start");
    lab.click("particles.start=food");
    expected.particles.start = Start::Food;
    for parameter in of_food {
        expected = turn(&lab, parameter, "", &expected, &before);
    }
    // Only this method has texel weights, and only the one before has cell sizes.
    lab.find("atlas.method");
    lab.click("atlas.method=charts");
    expected.atlas.method = AtlasMethod::Charts;
    // These take the place of others, which have no effect then. They are lifted on the object until it is their turn.
    let instead = ["trail.diffusion_length", "trail.half_life"];
    for key in instead {
        let name = format!("{prefix}{key}");
        lab.find(key);
        lab.click(&format!("{name}:own"));
        lab.type_until(&name, 0.9, "0", &name, "0");
    }
    for parameter in OBJECT_PARAMETERS.iter().filter(|p| !is_word(p)) {
        if instead.contains(&parameter.key) {
            lab.find(parameter.key);
            lab.click(&format!("{prefix}{}:own", parameter.key));
        }
        if parameter.key == "start.mask" {
            lab.find("start.place");
            lab.click(&format!("{prefix}start.place=mask"));
            expected.objects[ball].start.place = ObjectStart::Mask;
        }
        expected.objects[ball] = turn(
            &lab,
            parameter,
            &prefix,
            &expected.objects[ball],
            &before.objects[ball],
        );
    }
    // No built-in mesh has an animation, so a scene saved with this value could not be opened.
    lab.find(MODEL);
    let model = format!("{prefix}{MODEL}");
    for (control, word) in [("=follow", "follow"), (":reset", "still")] {
        lab.click(&format!("{model}{control}"));
        lab.wait("the word is taken", |seen| seen["values"][&model] == word);
    }
    let words = OBJECT_PARAMETERS.iter().rev().filter(|p| is_word(p));
    for parameter in words.filter(|p| p.key != MODEL) {
        expected.objects[ball] = turn(
            &lab,
            parameter,
            &prefix,
            &expected.objects[ball],
            &before.objects[ball],
        );
    }
    for parameter in FOOD_PARAMETERS {
        let (food, first) = (&expected.foods[0], &before.foods[0]);
        expected.foods[0] = turn(&lab, parameter, "food.0.", food, first);
    }
    let words = PARAMETERS.iter().rev();
    for parameter in words.filter(|p| has_row(p) && is_word(p) && p.key != SENSING) {
        if parameter.key == "transfer.respawn" {
            lab.find("transfer.strategy");
            lab.click("transfer.strategy=respawn");
            expected.transfer.strategy = Strategy::Respawn;
        }
        expected = turn(&lab, parameter, "", &expected, &before);
    }
    let saved = lab.save("lively");
    for parameter in PARAMETERS.iter().filter(|p| has_row(p)) {
        let key = parameter.key;
        assert!(parameter.differs(&before, &saved), "{key} has not changed");
        let [found, wanted] = [&saved, &expected].map(|s| parameter.value(s));
        out::assert_same(&found, &wanted, key);
    }
    for parameter in OBJECT_PARAMETERS {
        let [found, wanted] = [&saved, &expected].map(|s| parameter.value(&s.objects[ball]));
        out::assert_same(&found, &wanted, parameter.key);
    }
    for parameter in FOOD_PARAMETERS {
        let [found, wanted] = [&saved, &expected].map(|s| parameter.value(&s.foods[0]));
        out::assert_same(&found, &wanted, parameter.key);
    }
    lab.quit();
}

#[test]
fn numbers_beyond_their_range_give_a_notice_and_text_is_not_taken() {
    if !can_open() {
        return;
    }
    let lab = Lab::open(&SMALL);
    for (key, typed, becomes) in [
        ("trail.decay", "7", "1"),
        ("trail.decay", "-0.5", "0"),
        // The slider goes from 0.01 to 10,000; typed numbers may lie beyond.
        ("picture.brightest", "0.001", "0.001"),
        ("picture.brightest", "2000000000", "1000000000"),
    ] {
        lab.find(key);
        if lab.seen().expect("the lab has reported")["values"][key] == "0"
            && key == "picture.brightest"
        {
            lab.click("auto");
        }
        lab.type_until(key, 0.9, typed, key, becomes);
        if typed != becomes {
            lab.wait("a notice", |seen| {
                let notice = seen["state"]["notice"].as_str();
                notice.is_some_and(|text| text.contains(&format!("{typed} became {becomes}")))
            });
        }
    }
    lab.find("trail.decay");
    for none in ["nan", "inf", "0,5,5", "much"] {
        lab.type_into("trail.decay", 0.9, none);
        lab.wait("it is not typed any more", |seen| {
            seen["state"]["typing"] == false
        });
        assert_eq!(lab.value("trail.decay"), "0", "{none}");
    }
    assert_eq!(lab.save("cube").trail.decay, 0.0);

    // Colours can be reset, too.
    lab.find("picture.color_map");
    let first = lab.value("picture.color_map");
    lab.click("colors");
    lab.click_until("colors=ice", "color_map", "ice");
    lab.click_until("picture.color_map:reset", "color_map", first);
    lab.quit();
}
