//! A tour of the lab: a real pointer and real keys on a display operate every control, and the scene that is saved at the
//! end, or what the lab tells of itself, shows that each had its effect.
//!
//! Needs `xdotool`, `xclip` and an X display, which `make test` brings; without them it fails, unless MYXO_ALLOW_NO_DEVICE=1 lets it
//! skip.

#[path = "tour_steps/gestures.rs"]
mod gestures;
#[path = "tour_steps/hands.rs"]
mod hands;
#[path = "tour_steps/long_steps.rs"]
mod long_steps;
#[path = "tour_steps/opening.rs"]
mod opening;
#[path = "tour_steps/out.rs"]
mod out;
#[path = "tour_steps/parameters.rs"]
mod parameters;
mod program;
#[path = "tour_steps/views.rs"]
mod views;
#[path = "tour_steps/window_times.rs"]
mod window_times;
#[path = "tour_steps/worked.rs"]
mod worked;

use std::cell::RefCell;
use std::fs::File;
use std::io::{Read as _, Seek as _};
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::sleep;
use std::time::{Duration, Instant, SystemTime};

use myxo::scene::settings::Settings;
use myxo::scene::{Overrides, Scene};
use myxo::sim::areas::AreaMap;
use myxo::sim::start::Masks;
use program::{Folder, path, program};
use serde_json::Value;

/// Longer than anything may take on a slow machine.
const PATIENCE: Duration = Duration::from_secs(120);

/// Longer than keys and clicks take to the lab.
const REACHES_IT: Duration = Duration::from_millis(150);

/// There is one pointer.
static HAND: Mutex<()> = Mutex::new(());

/// An open lab, and the hand on it.
struct Lab {
    child: RefCell<Child>,
    /// What it has said; a pipe that nobody reads would fill up.
    said: File,
    folder: Folder,
    places: PathBuf,
    /// Of all tours on this display.
    _hand: MutexGuard<'static, ()>,
}

impl Drop for Lab {
    fn drop(&mut self) {
        let child = self.child.get_mut();
        if std::thread::panicking() {
            let ended = child.try_wait().ok().flatten();
            let state = ended.map_or("is running".to_owned(), |status| status.to_string());
            eprintln!("the lab: {state}; it has said: {}", said(&self.said));
        }
        let _ = child.kill();
        let _ = child.wait();
    }
}

fn said(mut file: &File) -> String {
    let mut text = String::new();
    file.rewind().expect("it is a file");
    file.read_to_string(&mut text).expect("it is text");
    text
}

/// Is there a display and a hand to be had?
fn can_tour() -> bool {
    worked::begins();
    let has = |tool: &str| {
        let mut version = Command::new(tool);
        version.arg("-version").stdin(Stdio::null());
        version.stdout(Stdio::null()).stderr(Stdio::null());
        version.status().is_ok()
    };
    if std::env::var_os("DISPLAY").is_some() && has("xdotool") && has("xclip") {
        return true;
    }
    assert!(
        std::env::var_os("MYXO_ALLOW_NO_DEVICE").is_some(),
        "no X display, xdotool or xclip: run `make test` (MYXO_ALLOW_NO_DEVICE=1 skips this)"
    );
    eprintln!("skipped: no X display, xdotool or xclip");
    false
}

fn xdotool(arguments: &[&str]) -> String {
    worked::did(arguments);
    let output = Command::new("xdotool")
        .args(arguments)
        .output()
        .expect("it is installed");
    String::from_utf8_lossy(&output.stdout).trim().to_owned()
}

impl Lab {
    fn open(arguments: &[&str]) -> Self {
        Self::start(program(), arguments)
    }

    fn start(program: Command, arguments: &[&str]) -> Self {
        let usual = ["--size=900x760", "--validate"];
        let lab = Self::begin(program, &[&usual, arguments].concat());
        lab.wait("the scene is there", |seen| {
            seen["state"]["loading"] == false && seen["state"]["step"].as_u64() > Some(0)
        });
        lab.take_hold();
        lab
    }

    /// Does not wait for anything.
    fn begin(mut program: Command, arguments: &[&str]) -> Self {
        let hand = HAND.lock().unwrap_or_else(PoisonError::into_inner);
        let folder = Folder::new();
        let places = folder.file("places.json");
        let said = tempfile::tempfile().expect("a temporary file");
        // A test that has a folder for them wants preferences.
        let forgets = !program
            .get_envs()
            .any(|(name, _)| name == "XDG_CONFIG_HOME");
        let child = program
            .current_dir(folder.path())
            .env("XDG_DATA_HOME", folder.path())
            .args(["lab", "--places", path(&places)])
            .args(forgets.then_some("--no-preferences"))
            .args(arguments)
            .stderr(said.try_clone().expect("another handle"))
            .spawn()
            .expect("the program starts");
        Self {
            child: RefCell::new(child),
            said,
            folder,
            places,
            _hand: hand,
        }
    }

    /// The window to the corner, where the pointer looks for it, and the keys to it.
    fn take_hold(&self) {
        let window = xdotool(&["search", "--onlyvisible", "--pid", &self.pid()]);
        let window = window.lines().last().unwrap_or_default().to_owned();
        xdotool(&["windowmove", &window, "0", "0"]);
        xdotool(&["windowfocus", &window]);
        sleep(Duration::from_millis(300));
    }

    fn pid(&self) -> String {
        self.child.borrow().id().to_string()
    }

    /// It must not have ended.
    #[track_caller]
    fn is_open(&self) {
        let ended = self.child.borrow_mut().try_wait();
        assert_eq!(ended.expect("it can be asked"), None, "it has ended");
    }

    fn seen(&self) -> Option<Value> {
        let seen = serde_json::from_str(&std::fs::read_to_string(&self.places).ok()?).ok()?;
        worked::met(&seen);
        Some(seen)
    }

    /// Waits until it is so.
    #[track_caller]
    fn wait(&self, what: &str, is_so: impl Fn(&Value) -> bool) -> Value {
        let begun = Instant::now();
        loop {
            let seen = self.seen();
            if let Some(seen) = seen.as_ref().filter(|seen| is_so(seen)) {
                return seen.clone();
            }
            assert!(begun.elapsed() < PATIENCE, "{what}: {seen:?}");
            self.is_open();
            sleep(Duration::from_millis(15));
        }
    }

    /// What is told of a value.
    fn value(&self, key: &str) -> String {
        let seen = self.seen().expect("it is told");
        seen["values"][key]
            .as_str()
            .expect("it is shown")
            .to_owned()
    }

    /// Waits until a control is there and stays where it is.
    #[track_caller]
    fn place(&self, name: &str) -> [f64; 4] {
        let of = |seen: &Value| -> Option<[f64; 4]> {
            let ends = seen["places"].get(name)?.as_array()?;
            let ends: Vec<f64> = ends.iter().filter_map(Value::as_f64).collect();
            ends.try_into().ok()
        };
        let mut last: Option<([f64; 4], Value, Instant)> = None;
        let begun = Instant::now();
        loop {
            let seen = self.seen();
            let now = seen.as_ref().and_then(of);
            if let (Some(seen), Some(now)) = (&seen, now) {
                // What has just come moves in the next frame, which may take long, unless there is none to come; what the hand
                // did last may still be on its way.
                last = match last {
                    Some((was, frames, since)) if was == now => {
                        let rests = seen["rests"] == true && since.elapsed() > REACHES_IT;
                        if rests || seen["frames"] != frames {
                            return now;
                        }
                        Some((was, frames, since))
                    }
                    _ => Some((now, seen["frames"].clone(), Instant::now())),
                };
            } else {
                last = None;
            }
            assert!(begun.elapsed() < PATIENCE, "{name} is not there: {seen:?}");
            self.is_open();
            sleep(Duration::from_millis(40));
        }
    }

    /// The pointer onto a control, a share of its width from the left.
    #[track_caller]
    fn point(&self, name: &str, share: f64) {
        let [left, top, right, bottom] = self.place(name);
        let x = (left + share * (right - left)).round().to_string();
        let y = (0.5 * (top + bottom)).round().to_string();
        xdotool(&["mousemove", &x, &y]);
        worked::at(name);
        sleep(Duration::from_millis(60));
    }

    #[track_caller]
    fn click(&self, name: &str) {
        self.point(name, 0.5);
        self.press();
    }

    /// Long enough to be seen between two slow frames.
    fn press(&self) {
        xdotool(&["mousedown", "1"]);
        sleep(Duration::from_millis(120));
        xdotool(&["mouseup", "1"]);
        sleep(Duration::from_millis(120));
    }

    /// Picks the object in the middle of the picture, which has this name.
    #[track_caller]
    fn pick(&self, name: &str) {
        for _ in 0..5 {
            self.point("picture", 0.5);
            self.press();
            for _ in 0..30 {
                if self
                    .seen()
                    .is_some_and(|seen| seen["values"]["picked"] == name)
                {
                    return;
                }
                sleep(Duration::from_millis(50));
            }
        }
        panic!("{name} is not picked: {:?}", self.seen());
    }

    fn key(&self, key: &str) {
        xdotool(&["key", "--delay", "40", key]);
        sleep(Duration::from_millis(120));
    }

    fn write(&self, text: &str) {
        xdotool(&["type", "--delay", "30", "--", text]);
        sleep(Duration::from_millis(120));
    }

    /// Presses and sees what comes of it.
    #[track_caller]
    fn key_until(&self, key: &str, what: &str, state: &str, value: impl Into<Value>) {
        let value = value.into();
        self.key(key);
        self.wait(what, |seen| seen["state"][state] == value);
    }

    #[track_caller]
    fn click_until(&self, name: &str, state: &str, value: impl Into<Value>) {
        let value = value.into();
        self.click(name);
        self.wait(name, |seen| seen["state"][state] == value);
    }

    /// Lets the panel show one parameter.
    #[track_caller]
    fn find(&self, words: &str) {
        self.type_until("filter", 0.5, words, "filter", words);
    }

    /// Types a number into the box at the right end of a slider.
    #[track_caller]
    fn type_into(&self, name: &str, share: f64, number: &str) {
        self.point(name, share);
        self.press();
        self.wait(name, |seen| seen["state"]["typing"] == true);
        self.key("ctrl+a");
        self.write(number);
        self.key("Return");
    }

    /// The same until the lab has it: on a display that is short of time, keys are lost or come twice.
    #[track_caller]
    fn type_until(&self, name: &str, share: f64, text: &str, key: &str, value: &str) {
        for _ in 0..5 {
            self.type_into(name, share, text);
            for _ in 0..30 {
                if self.seen().is_some_and(|seen| seen["values"][key] == value) {
                    return;
                }
                sleep(Duration::from_millis(50));
            }
        }
        panic!("{key} is not {value}: {:?}", self.seen());
    }

    /// Saves the scene, and reads what was saved.
    #[track_caller]
    fn save(&self, name: &str) -> Settings {
        let before = self.saved_last(name);
        let is_old = || self.saved_last(name) == before;
        let begun = Instant::now();
        while is_old() {
            assert!(begun.elapsed() < PATIENCE, "{name} is saved");
            self.key("ctrl+s");
            // Keys are lost on a display that is short of time.
            (0..750)
                .take_while(|_| is_old())
                .for_each(|_| sleep(Duration::from_millis(20)));
        }
        let (_, file) = self.saved_last(name).expect("it has just been written");
        let scene = Scene::load(&file, &Overrides::default());
        let scene = scene.expect("what was saved can be opened");
        Masks::open(&scene).expect("so can the pictures that it begins on");
        let map = &scene.settings.areas.map;
        if !map.is_empty() {
            AreaMap::open(map.as_ref()).expect("and its areas");
        }
        let read = Scene::read(&file, &Overrides::default());
        read.expect("it has just been read").1
    }

    /// The numbered file of this name that was written last, and when.
    fn saved_last(&self, name: &str) -> Option<(SystemTime, PathBuf)> {
        let files = std::fs::read_dir(self.folder.path()).expect("it is there");
        let files = files.filter_map(|entry| {
            let entry = entry.expect("it can be read");
            let file = entry.file_name().into_string().ok()?;
            let number = file.strip_prefix(name)?.strip_prefix('_')?;
            number.strip_suffix(".toml")?.parse::<u32>().ok()?;
            let written = entry.metadata().and_then(|file| file.modified());
            Some((written.expect("it is told"), entry.path()))
        });
        files.max()
    }

    /// Ends it by a key; nothing may have gone wrong.
    fn quit(self) {
        self.quit_and_keep();
    }

    /// The same, with the folder of what it has written.
    fn quit_and_keep(self) -> Self {
        self.key("ctrl+q");
        let status = self.ended();
        assert!(status.success(), "{status}");
        self
    }

    /// Waits until it has ended.
    #[track_caller]
    fn ended(&self) -> ExitStatus {
        let begun = Instant::now();
        loop {
            let ended = self.child.borrow_mut().try_wait();
            if let Some(status) = ended.expect("it can be asked") {
                return status;
            }
            assert!(begun.elapsed() < PATIENCE, "it ends");
            sleep(Duration::from_millis(20));
        }
    }
}

/// Small, on one object that is seen from all sides.
const SMALL: [&str; 3] = ["cube", "--set=particles.count=3000", "--set=atlas.size=128"];

#[test]
fn every_button_and_key_has_its_effect() {
    if !can_tour() {
        return;
    }
    let lab = Lab::open(&SMALL);
    let step = |seen: &Value| seen["state"]["step"].as_u64().expect("it is a number");

    // Run, hold, step, reset.
    lab.click_until("run", "playing", false);
    let before = step(&lab.seen().expect("it is told"));
    lab.click("step");
    lab.wait("one step", |seen| step(seen) == before + 1);
    lab.key("period");
    lab.wait("one more", |seen| step(seen) == before + 2);
    lab.click("reset");
    lab.wait("from the beginning", |seen| step(seen) == 0);
    lab.key_until("space", "it runs", "playing", true);
    lab.wait("it goes on", |seen| step(seen) > 3);
    lab.key_until("space", "it is held", "playing", false);

    // What the picture shows.
    for show in ["particles", "atlas", "surface"] {
        lab.click_until(&format!("show={show}"), "show", show);
    }
    for (key, show) in [("2", "particles"), ("3", "atlas"), ("1", "surface")] {
        lab.key_until(key, show, "show", show);
    }
    lab.click("colors");
    lab.click_until("colors=ice", "color_map", "ice");
    lab.key_until("c", "the next colours", "color_map", "moss");
    lab.find("picture.charts");
    lab.type_into("picture.charts", 0.9, "0.5");
    lab.find("picture.brightest");
    lab.click("auto");
    lab.type_into("picture.brightest", 0.9, "33");
    lab.key("2");
    lab.find("particle_size");
    lab.type_into("picture.particle_size", 0.9, "4");
    let saved = lab.save("cube");
    let picture = &saved.picture;
    assert_eq!((picture.charts, picture.brightest), (0.5, 33.0));
    assert_eq!(picture.particle_size, 4.0);
    lab.key("1");

    // Undo and redo, by button and by key.
    lab.find("trail.decay");
    lab.type_until("trail.decay", 0.9, "0.5", "trail.decay", "0.5");
    lab.click("undo");
    assert_eq!(lab.save("cube").trail.decay, saved.trail.decay);
    lab.click("redo");
    assert_eq!(lab.save("cube").trail.decay, 0.5);
    for key in ["ctrl+shift+z", "ctrl+y"] {
        lab.key("ctrl+z");
        lab.wait("undone", |seen| seen["values"]["trail.decay"] != "0.5");
        lab.key(key);
        lab.wait(key, |seen| seen["values"]["trail.decay"] == "0.5");
        assert_eq!(lab.save("cube").trail.decay, 0.5, "{key}");
    }
    lab.click("trail.decay:reset");
    assert_eq!(lab.save("cube").trail.decay, saved.trail.decay);

    // What restarts waits, and is discarded or taken.
    lab.find("particles.count");
    let count = "particles.count";
    lab.type_until(count, 0.9, "4000", count, "4000");
    lab.wait("it waits", |seen| seen["state"]["pending"] == true);
    lab.click_until("discard", "pending", false);
    lab.find(count);
    lab.type_until(count, 0.9, "4000", count, "4000");
    lab.wait("it waits", |seen| seen["state"]["pending"] == true);
    lab.click_until("restart", "pending", false);
    assert_eq!(lab.save("cube").particles.count, 4000);

    // Looks.
    lab.click("preset");
    lab.click_until("preset=waves", "preset", "waves");
    assert!(lab.save("cube").physarum.rotation_angle < 0.0);
    lab.key_until("bracketright", "the next preset", "preset", "mist");
    lab.key_until("bracketleft", "the preset before", "preset", "waves");
    lab.click_until("chance", "preset", Value::Null);
    let by_chance = lab.save("cube");
    lab.key("d");
    assert_ne!(lab.save("cube").physarum, by_chance.physarum);
    lab.type_into("morph", 0.5, "0.5");
    lab.key("bracketright");
    lab.wait("it is on its way, or there", |seen| {
        seen["state"]["preset"] == "network"
    });
    lab.wait("it is there", |seen| seen["state"]["morphing"] == false);
    assert_eq!(lab.save("cube").physarum.sensor_offset, 0.03);

    // The window itself.
    lab.click_until("theme", "light", true);
    lab.key_until("t", "it is dark", "light", false);
    lab.key_until("p", "the panel goes", "panel", false);
    lab.key_until("p", "the panel comes", "panel", true);
    lab.key_until("F10", "the picture alone", "performing", true);
    lab.key_until("Escape", "and not alone", "performing", false);
    lab.click_until("help", "help", true);
    lab.key_until("h", "it goes again", "help", false);
    // The crosses of floating windows.
    for (window, cross) in [
        ("help", "help.close"),
        ("gallery", "gallery.close"),
        ("out", "out.close"),
    ] {
        lab.click_until(window, window, true);
        lab.click_until(cross, window, false);
    }
    lab.key_until("F11", "it fills the screen", "full_screen", true);
    lab.key_until("F11", "it is a window again", "full_screen", false);
    lab.click("screenshot");
    lab.wait("it is told", |seen| {
        let notice = seen["state"]["notice"].as_str();
        notice.is_some_and(|text| text.contains("screenshot_000001.png"))
    });
    let picture = image::open(lab.folder.file("screenshot_000001.png"));
    let picture = picture.expect("it is a picture").into_rgb8();
    let lit = picture
        .pixels()
        .filter(|pixel| pixel.0.iter().max() > Some(&60));
    assert!(lit.count() > 5000, "something is seen");

    // The camera: drag, wheel, double click, and back.
    let camera = lab.save("cube").camera;
    lab.point("picture", 0.4);
    xdotool(&["mousedown", "1"]);
    for _ in 0..6 {
        xdotool(&["mousemove_relative", "20", "5"]);
        sleep(Duration::from_millis(60));
    }
    xdotool(&["mouseup", "1"]);
    let turned = lab.save("cube").camera;
    assert!((turned.azimuth - camera.azimuth).abs() > 5.0, "{turned:?}");
    for _ in 0..3 {
        xdotool(&["click", "4"]);
        sleep(Duration::from_millis(150));
    }
    let near = lab.save("cube").camera;
    assert!(near.distance < 0.95 * turned.distance, "{near:?}");
    views::look_for_nothing(&lab);
    lab.click("fit");
    sleep(Duration::from_millis(300));
    let fitted = lab.save("cube").camera;
    assert!(fitted.distance > 1.05 * near.distance, "{fitted:?}");

    // Another scene, by its picture; and one that is given up, if it is not quicker than the hand.
    lab.click_until("gallery", "gallery", true);
    lab.click("card=sphere");
    lab.wait("the sphere is there", |seen| {
        seen["state"]["scene"] == "sphere" && seen["state"]["loading"] == false
    });
    lab.key_until("g", "the gallery", "gallery", true);
    // Presets are below the scenes.
    lab.point("card=sphere", 0.5);
    for _ in 0..4 {
        xdotool(&["click", "5"]);
        sleep(Duration::from_millis(150));
    }
    // It scrolls smoothly, and cards stand still after a while.
    sleep(Duration::from_millis(1500));
    lab.click("card=cells");
    lab.wait("the look is taken", |seen| {
        seen["state"]["preset"] == "cells"
    });
    lab.key_until("Escape", "the gallery goes", "gallery", false);
    lab.quit();
}
