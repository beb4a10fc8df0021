//! Times of the window: until it opens, for a large picture, for a film, and from a key or a look under the pointer to its answer, while a
//! scene runs. `make window-times` prints them as tables; what was measured is in `benches/results/README.md`.

use std::path::PathBuf;
use std::thread::sleep;
use std::time::{Duration, Instant};

use serde_json::Value;

use super::can_open_a_window;
use super::display::xdotool;
use crate::Lab;
use crate::lab::PATIENCE;
use crate::program::{program, shown_of};

const SIZE: &str = "--size=1280x800";
/// The scenes, and their numbers of particles.
const SCENES: [&str; 3] = ["torus", "trio", "gears"];
const COUNT: &str = "--set=particles.count=500000";
const KEYS: usize = 60;
/// The scenes in which looks are previewed, and their numbers of particles.
const PREVIEWED: [&str; 2] = ["torus", "oats"];
const PREVIEWED_COUNT: &str = "--set=particles.count=200000";
/// Looks, and the colours of each, in the order in which the pointer comes to them.
const LOOKS: [(&str, &str); 5] = [
    ("cells", "viridis"),
    ("ribbons", "inferno"),
    ("spots", "moss"),
    ("network", "myxo"),
    ("ribbons", "inferno"),
];
/// The pointer has to rest on the first one for so long, milliseconds.
const RESTS: f64 = 150.0;
/// Seconds of a film, and its frames in each.
const FILM: [u64; 2] = [10, 30];

/// An open lab, its scene running, and the seconds until its first frame and its first step.
fn opened(scene: &str, count: &str) -> (Lab, [f64; 2]) {
    let begun = Instant::now();
    let lab = Lab::begin_on_display(program(), &[SIZE, scene, count]);
    let mut seconds = [0.0; 2];
    lab.wait("a frame", |_| true);
    seconds[0] = begun.elapsed().as_secs_f64();
    lab.wait("a step", |seen| {
        seen["state"]["loading"] == false && seen["state"]["step"].as_u64() > Some(0)
    });
    seconds[1] = begun.elapsed().as_secs_f64();
    lab.display(|display, child| display.take_hold(child));
    (lab, seconds)
}

/// Milliseconds from before a key is sent to the frame that shows what it did, least first.
fn answers(lab: &Lab) -> Vec<f64> {
    let mut times = Vec::new();
    let mut lost = 0;
    let is_shown = || lab.seen()?["state"]["help"].as_bool();
    while times.len() < KEYS {
        assert!(lost < KEYS, "keys do not come");
        // A key that was counted as lost may have arrived since.
        let reported = lab.wait("the report", |seen| seen["state"]["help"].is_boolean());
        let reported = reported["state"]["help"] == true;
        // Spread over all phases of a step.
        let pause = 120 + 37 * (times.len() as u64 * 7 % 11);
        sleep(Duration::from_millis(pause));
        let shown = is_shown().unwrap_or(reported);
        let begun = Instant::now();
        xdotool(&["key", "--delay", "0", "h"]);
        let is_answered = || is_shown() == Some(!shown);
        while !is_answered() && begun.elapsed() < Duration::from_secs(10) {
            sleep(Duration::from_millis(1));
        }
        if is_answered() {
            times.push(1000.0 * begun.elapsed().as_secs_f64());
        } else {
            lost += 1;
        }
    }
    if lost > 0 {
        println!("{lost} keys were lost on the way");
    }
    times.sort_by(f64::total_cmp);
    times
}

/// Milliseconds from before the pointer is moved onto each look to the picture in its colours, and to one with its steps. Those of the
/// first look count from when the pointer has rested on it.
fn previews(lab: &Lab) -> Vec<[f64; 2]> {
    lab.click_until("gallery", "gallery", true);
    let places = LOOKS.map(|(name, _)| lab.place(&format!("card={name}")));
    // The trail is to have patterns.
    lab.grows_beyond(100);
    let looks = LOOKS.iter().zip(places).enumerate();
    let times = looks.map(|(i, ((name, colors), [left, top, right, bottom]))| {
        let [x, y] = [left + right, top + bottom].map(|sum| format!("{:.0}", 0.5 * sum));
        let begun = Instant::now();
        xdotool(&["mousemove", &x, &y]);
        let rests = if i == 0 { RESTS } else { 0.0 };
        let after = |what: &str, is_so: &dyn Fn(&Value) -> bool| {
            while !(lab.seen()).is_some_and(|seen| is_so(&seen["state"])) {
                assert!(begun.elapsed() < PATIENCE, "{what} of {name}");
                sleep(Duration::from_millis(1));
            }
            1000.0 * begun.elapsed().as_secs_f64() - rests
        };
        let is_previewed = |state: &Value| state["previewed"] == *name;
        [
            after("colours", &|state| {
                is_previewed(state) && state["drawn_colors"] == *colors
            }),
            after("steps", &|state| {
                is_previewed(state) && state["previewed_steps"] == true
            }),
        ]
    });
    times.collect()
}

/// Seconds from a click to the whole file.
fn made(lab: &Lab, button: &str, file: &str) -> (f64, PathBuf) {
    let place = lab.folder.file(file);
    lab.point(button, 0.5);
    let begun = Instant::now();
    lab.press();
    while !place.exists() {
        assert!(begun.elapsed() < 20 * PATIENCE, "{file}: {:?}", lab.seen());
        lab.is_open();
        sleep(Duration::from_millis(5));
    }
    (begun.elapsed().as_secs_f64(), place)
}

#[test]
#[ignore = "takes minutes, and measures the machine; `make window-times` runs it"]
fn times_of_the_window() {
    if !can_open_a_window() {
        return;
    }
    println!("| scene | first frame, s | first step, s | key to answer: median, 95 %, most, ms |");
    println!("| --- | --- | --- | --- |");
    for scene in SCENES {
        let (lab, [frame, step]) = opened(scene, COUNT);
        let times = answers(&lab);
        let ranks = [KEYS / 2, (KEYS * 95).div_ceil(100) - 1, KEYS - 1];
        let [median, of_95_percent, most] = ranks.map(|rank| times[rank]);
        println!(
            "| `{scene}` | {frame:.2} | {step:.2} | {median:.0}, {of_95_percent:.0}, {most:.0} |"
        );
        lab.quit();
    }

    println!("| scene | look | colours after, ms | its steps after, ms |");
    println!("| --- | --- | --- | --- |");
    for scene in PREVIEWED {
        let (lab, _) = opened(scene, PREVIEWED_COUNT);
        for ((look, _), [colors, steps]) in LOOKS.iter().zip(previews(&lab)) {
            println!("| `{scene}` | `{look}` | {colors:.0} | {steps:.0} |");
        }
        lab.quit();
    }

    let (lab, _) = opened("torus", COUNT);
    lab.click_until("out", "out", true);
    lab.click("out.size=4K");
    for number in 1..=3 {
        let name = format!("screenshot_{number:06}.png");
        let (seconds, picture) = made(&lab, "out.picture", &name);
        let picture = image::image_dimensions(&picture).expect("it is a picture");
        assert_eq!(picture, (3840, 2160));
        println!("a picture of 3840 x 2160: {seconds:.2} s");
    }
    lab.click("out.kind=MP4");
    lab.click("out.film_size=1080p");
    let [length, fps] = FILM;
    for (row, number) in [("out.seconds", length), ("out.film_fps", fps)] {
        let number = number.to_string();
        lab.type_until(row, 0.5, &number, row, &number);
    }
    let (seconds, film) = made(&lab, "out.film", "film_000001.mp4");
    assert_eq!(shown_of(&film), ([1920, 1080], length * fps));
    println!(
        "a film of 1920 x 1080, {length} s: {} frames, none left out, in {seconds:.0} s",
        length * fps
    );
    lab.quit();
}
