//! An open lab and the input to it: controls are found by their names, and tests wait for the effect of each input.

use std::cell::RefCell;
use std::fs::File;
use std::io::{Read as _, Seek as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant, SystemTime};

use myxo::scene::settings::Settings;
use myxo::scene::{Overrides, Scene};
use myxo::sim::areas::AreaMap;
use myxo::sim::start::Masks;
use serde_json::{Value, json};

use crate::input::{Gesture, Input, Lines};
use crate::program::{Folder, path, program};
use crate::real::display::Display;
use crate::worked;

/// Longer than anything may take on a slow machine.
pub const PATIENCE: Duration = Duration::from_secs(120);

/// Arguments of every lab, unless a test has a size of its own.
const USUAL: [&str; 2] = ["--validate", "--size=900x760"];

fn with_usual<'a>(arguments: &[&'a str]) -> Vec<&'a str> {
    let has_size = arguments.iter().any(|word| word.starts_with("--size"));
    [&USUAL[..if has_size { 1 } else { 2 }], arguments].concat()
}

/// An open lab, and the input to it.
pub struct Lab {
    child: RefCell<Child>,
    /// Its messages. They go to a file because a pipe that is not read would fill up.
    pub said: File,
    pub folder: Folder,
    input: RefCell<Input>,
    /// The control that the pointer is on.
    at: RefCell<String>,
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
        worked::keep();
    }
}

pub fn said(mut file: &File) -> String {
    let mut text = String::new();
    file.rewind().expect("it is a file");
    file.read_to_string(&mut text).expect("it is text");
    text
}

/// Is there a device? Where there is none, tests fail unless MYXO_ALLOW_NO_DEVICE=1 lets them skip.
pub fn can_open() -> bool {
    worked::begins();
    std::env::var_os("MYXO_ALLOW_NO_DEVICE").is_none() || !crate::program::no_device()
}

/// A lab without a window that shows the scene of this text, and the folder of its file; none without a device.
#[track_caller]
pub fn with_scene(file: &str, text: &str) -> Option<(Folder, Lab)> {
    can_open().then(|| {
        let folder = Folder::new();
        let file = folder.with(file, text);
        let lab = Lab::open(&[path(&file)]);
        (folder, lab)
    })
}

/// Steps taken, in a report.
pub fn step(seen: &Value) -> u64 {
    seen["state"]["step"].as_u64().expect("it is a number")
}

/// A lab that is about to start, in a folder of its own unless the command has one.
struct Begun {
    command: Command,
    said: File,
    folder: Folder,
}

impl Begun {
    fn new(mut command: Command, arguments: &[&str]) -> Self {
        let folder = Folder::new();
        let said = tempfile::tempfile().expect("a temporary file");
        // Tests that set a folder for preferences want them kept.
        let forgets = !command
            .get_envs()
            .any(|(name, _)| name == "XDG_CONFIG_HOME");
        if command.get_current_dir().is_none() {
            command
                .current_dir(folder.path())
                .env("XDG_DATA_HOME", folder.path());
        }
        command
            .arg("lab")
            .args(forgets.then_some("--no-preferences"))
            .args(arguments)
            .stderr(said.try_clone().expect("another handle"));
        Self {
            command,
            said,
            folder,
        }
    }

    fn with(mut self, input: impl FnOnce(&mut Child) -> Input) -> Lab {
        let mut child = self.command.spawn().expect("the program starts");
        Lab {
            input: RefCell::new(input(&mut child)),
            child: RefCell::new(child),
            said: self.said,
            folder: self.folder,
            at: RefCell::default(),
        }
    }
}

impl Lab {
    /// Opens one without a window.
    #[track_caller]
    pub fn open(arguments: &[&str]) -> Self {
        Self::start(program(), arguments)
    }

    #[track_caller]
    pub fn start(program: Command, arguments: &[&str]) -> Self {
        let lab = Self::begin(program, &with_usual(arguments));
        lab.has_begun();
        lab
    }

    /// Does not wait for the scene.
    pub fn begin(program: Command, arguments: &[&str]) -> Self {
        let mut begun = Begun::new(program, arguments);
        (begun.command)
            .arg("--windowless")
            .env_remove("DISPLAY")
            .env_remove("WAYLAND_DISPLAY")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped());
        begun.with(|child| Input::Lines(Box::new(Lines::new(child))))
    }

    /// Opens one in a window of the display, once no other test has the pointer.
    #[track_caller]
    pub fn open_on_display(arguments: &[&str]) -> Self {
        Self::start_on_display(program(), arguments)
    }

    #[track_caller]
    pub fn start_on_display(program: Command, arguments: &[&str]) -> Self {
        let lab = Self::begin_on_display(program, &with_usual(arguments));
        lab.has_begun();
        lab.display(|display, child| display.take_hold(child));
        lab
    }

    /// Waits only until no other test has the pointer, not for the scene.
    pub fn begin_on_display(program: Command, arguments: &[&str]) -> Self {
        let mut begun = Begun::new(program, arguments);
        let places = begun.folder.file("places.json");
        begun.command.args(["--places", path(&places)]);
        // `xdotool` works on X only.
        begun.command.env_remove("WAYLAND_DISPLAY");
        begun.command.env_remove("WAYLAND_SOCKET");
        let display = Display::new(places);
        begun.with(|_| Input::Display(Box::new(display)))
    }

    #[track_caller]
    fn has_begun(&self) {
        self.wait("the scene is there", |seen| {
            seen["state"]["loading"] == false && seen["state"]["step"].as_u64() > Some(0)
        });
    }

    /// For labs with a window.
    #[track_caller]
    pub fn display<T>(&self, what: impl FnOnce(&mut Display, u32) -> T) -> T {
        let child = self.child.borrow().id();
        match &mut *self.input.borrow_mut() {
            Input::Display(display) => what(display, child),
            Input::Lines(_) => panic!("it has no window"),
        }
    }

    fn has_window(&self) -> bool {
        matches!(&*self.input.borrow(), Input::Display(_))
    }

    pub fn pid(&self) -> String {
        self.child.borrow().id().to_string()
    }

    /// It must not have ended.
    #[track_caller]
    pub fn is_open(&self) {
        let ended = self.child.borrow_mut().try_wait();
        assert_eq!(ended.expect("it can be asked"), None, "it has ended");
    }

    /// What is shown.
    pub fn seen(&self) -> Option<Value> {
        let seen = match &*self.input.borrow() {
            Input::Lines(lines) => lines.seen(),
            Input::Display(display) => display.seen(),
        }?;
        worked::met(&seen);
        Some(seen)
    }

    /// Steps taken.
    #[track_caller]
    pub fn step(&self) -> u64 {
        step(&self.seen().expect("the lab has reported"))
    }

    /// Pauses the simulation.
    #[track_caller]
    pub fn hold(&self) {
        self.key_until("space", "it is held", "playing", false);
    }

    /// Waits until more than so many steps are taken.
    #[track_caller]
    pub fn grows_beyond(&self, steps: u64) {
        self.wait("it grows", |seen| step(seen) > steps);
    }

    /// Lets a frame pass.
    pub fn look(&self) {
        match &mut *self.input.borrow_mut() {
            Input::Lines(lines) => lines.look(),
            Input::Display(display) => display.look(),
        }
    }

    /// Lets so many frames pass.
    pub fn look_at(&self, frames: u32) {
        (0..frames).for_each(|_| self.look());
    }

    /// Waits until `found` returns something.
    #[track_caller]
    pub fn until<T>(&self, what: &str, found: impl Fn() -> Option<T>) -> T {
        let begun = Instant::now();
        loop {
            if let Some(found) = found() {
                return found;
            }
            self.is_open();
            if begun.elapsed() > PATIENCE {
                let picture = match &*self.input.borrow() {
                    Input::Display(display) => display.picture(),
                    Input::Lines(_) => String::new(),
                };
                panic!("{what}: {:?}{picture}", self.seen());
            }
            self.look();
        }
    }

    /// Waits until the lab's report meets a condition.
    #[track_caller]
    pub fn wait(&self, what: &str, is_so: impl Fn(&Value) -> bool) -> Value {
        self.until(what, || self.seen().filter(&is_so))
    }

    /// Does something and waits for its effect. On a busy display input may be lost, so there it is repeated.
    #[track_caller]
    pub fn again_until(&self, what: &str, act: impl Fn(), is_so: impl Fn(&Value) -> bool) -> Value {
        if self.has_window() {
            for _ in 0..4 {
                act();
                let begun = Instant::now();
                while begun.elapsed() < Duration::from_secs(3) {
                    if let Some(seen) = self.seen().filter(&is_so) {
                        return seen;
                    }
                    self.look();
                }
            }
        }
        act();
        self.wait(what, is_so)
    }

    /// The text of a value in the lab's report.
    #[track_caller]
    pub fn value(&self, key: &str) -> String {
        let seen = self.seen().expect("the lab has reported");
        seen["values"][key]
            .as_str()
            .expect("it is shown")
            .to_owned()
    }

    /// Waits until a control is there and stays where it is.
    #[track_caller]
    pub fn place(&self, name: &str) -> [f64; 4] {
        let of = |seen: &Value| -> Option<[f64; 4]> {
            let ends = seen["places"].get(name)?.as_array()?;
            let ends: Vec<f64> = ends.iter().filter_map(Value::as_f64).collect();
            ends.try_into().ok()
        };
        let rests = |seen: &Value| match &*self.input.borrow() {
            Input::Lines(lines) => lines.rests,
            Input::Display(display) => display.rests(seen),
        };
        let last: RefCell<Option<([f64; 4], Value)>> = RefCell::default();
        self.until(name, || {
            let seen = self.seen()?;
            let now = of(&seen);
            let mut last = last.borrow_mut();
            let Some(now) = now else {
                *last = None;
                return None;
            };
            if rests(&seen) {
                return Some(now);
            }
            // A control that has just appeared moves in the next frame.
            match &*last {
                Some((was, frames)) if *was == now => (*frames != seen["frames"]).then_some(now),
                _ => {
                    *last = Some((now, seen["frames"].clone()));
                    None
                }
            }
        })
    }

    /// Keeps which keys and controls a gesture works.
    fn works(&self, what: &Gesture) {
        what.keys().iter().for_each(|key| worked::key(key));
        if what.presses() {
            worked::control(&self.at.borrow());
        }
    }

    /// Sends a gesture.
    pub fn perform(&self, what: Gesture) {
        self.works(&what);
        match &mut *self.input.borrow_mut() {
            Input::Lines(lines) => lines.perform(&what),
            Input::Display(display) => display.perform(&what),
        }
    }

    /// Sends gestures one after the other. A lab without a window takes them all before it is at rest.
    fn perform_all(&self, all: &[Gesture]) {
        all.iter().for_each(|what| self.works(what));
        match &mut *self.input.borrow_mut() {
            Input::Lines(lines) => lines.perform_all(all),
            Input::Display(display) => all.iter().for_each(|what| display.perform(what)),
        }
    }

    /// The pixel of a control that is a share of its width from the left.
    #[track_caller]
    fn pixel(&self, name: &str, share: f64) -> (f64, f64) {
        let [left, top, right, bottom] = self.place(name);
        let x = (left + share * (right - left)).round();
        (x, (0.5 * (top + bottom)).round())
    }

    /// Moves the pointer onto a control, a share of its width from the left.
    #[track_caller]
    pub fn point(&self, name: &str, share: f64) {
        let (x, y) = self.pixel(name, share);
        self.perform(Gesture::Move(x, y));
        name.clone_into(&mut self.at.borrow_mut());
    }

    #[track_caller]
    pub fn click(&self, name: &str) {
        self.point(name, 0.5);
        self.press();
    }

    pub fn press(&self) {
        self.perform(Gesture::Click(1));
    }

    /// Presses a button of the pointer, moves `times` times by so many pixels, and releases it.
    pub fn drag(&self, button: u8, times: u32, (right, down): (i32, i32)) {
        self.perform(Gesture::Down(button));
        (0..times).for_each(|_| self.perform(Gesture::MoveBy(right, down)));
        self.perform(Gesture::Up(button));
    }

    /// Picks the object in the middle of the picture, which has this name.
    #[track_caller]
    pub fn pick(&self, name: &str) {
        let act = || {
            self.point("picture", 0.5);
            self.press();
        };
        self.again_until("it is picked", act, |seen| seen["values"]["picked"] == name);
    }

    pub fn key(&self, key: &str) {
        self.perform(Gesture::Keys(&[key]));
    }

    pub fn write(&self, text: &str) {
        self.perform(Gesture::Write(text));
    }

    /// Presses a key and waits until an entry of the lab's state has this value.
    #[track_caller]
    pub fn key_until(&self, key: &str, what: &str, state: &str, value: impl Into<Value>) {
        let value = value.into();
        self.key(key);
        self.wait(what, |seen| seen["state"][state] == value);
    }

    #[track_caller]
    pub fn click_until(&self, name: &str, state: &str, value: impl Into<Value>) {
        let value = value.into();
        self.click(name);
        self.wait(name, |seen| seen["state"][state] == value);
    }

    /// Lets the panel show one parameter.
    #[track_caller]
    pub fn find(&self, words: &str) {
        self.type_until("filter", 0.5, words, "filter", words);
    }

    /// Types a number into the box at the right end of a slider.
    #[track_caller]
    pub fn type_into(&self, name: &str, share: f64, number: &str) {
        if self.has_window() {
            self.point(name, share);
            self.press();
            self.wait(name, |seen| seen["state"]["typing"] == true);
            self.key("ctrl+a");
            self.write(number);
            return self.key("Return");
        }
        // Without a window no input is lost, so nothing has to be waited for.
        let (x, y) = self.pixel(name, share);
        name.clone_into(&mut self.at.borrow_mut());
        self.perform_all(&[
            Gesture::Move(x, y),
            Gesture::Click(1),
            Gesture::Keys(&["ctrl+a"]),
            Gesture::Write(number),
            Gesture::Keys(&["Return"]),
        ]);
    }

    /// Types a text and waits until the lab has the value.
    #[track_caller]
    pub fn type_until(&self, name: &str, share: f64, text: &str, key: &str, value: &str) {
        let what = format!("{key} is {value}");
        let act = || self.type_into(name, share, text);
        self.again_until(&what, act, |seen| seen["values"][key] == value);
    }

    /// Drops files onto the middle of the window, and waits until it has taken them.
    pub fn drop_files(&self, files: &[&Path]) {
        match &mut *self.input.borrow_mut() {
            Input::Lines(lines) => {
                let all = files.iter().map(|file| json!({ "drop": file }));
                lines.send(&json!([all.collect::<Vec<_>>()]));
            }
            Input::Display(display) => display.drop_files(files),
        }
    }

    /// Puts text into the clipboard, as another program does.
    pub fn copy(&self, text: &str) {
        match &mut *self.input.borrow_mut() {
            Input::Lines(lines) => lines.send(&json!([[{ "copied": text }]])),
            Input::Display(display) => display.copy(text),
        }
    }

    /// What the lab has put into the clipboard, once this is part of it.
    #[track_caller]
    pub fn clipboard(&self, part: &str) -> String {
        self.until("it is copied", || {
            let text = match &*self.input.borrow() {
                Input::Lines(lines) => lines.clipboard(),
                Input::Display(display) => display.clipboard(),
            };
            text.contains(part).then_some(text)
        })
    }

    /// Saves the scene, and reads what was saved.
    #[track_caller]
    pub fn save(&self, name: &str) -> Settings {
        let before = self.saved_last(name);
        self.again_until(
            &format!("{name} is saved"),
            || self.key("ctrl+s"),
            |_| self.saved_last(name) != before,
        );
        let (_, file) = self.saved_last(name).expect("it has just been written");
        let scene = Scene::load(&file, &Overrides::default());
        let scene = scene.expect("what was saved can be opened");
        Masks::open(&scene).expect("so can the pictures that it begins on");
        let map = &scene.settings.areas.map;
        if !map.is_empty() {
            AreaMap::open(map.as_ref(), scene.settings.atlas.size).expect("and its areas");
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
            Some((written.expect("the lab has reported"), entry.path()))
        });
        files.max()
    }

    /// Ends it by a key; nothing may have gone wrong.
    #[track_caller]
    pub fn quit(self) {
        self.quit_and_keep();
    }

    /// Ends the lab as [`Self::quit`] does, and keeps its folder.
    #[track_caller]
    pub fn quit_and_keep(self) -> Self {
        self.key("ctrl+q");
        let status = self.ended();
        assert!(status.success(), "{status}");
        self
    }

    /// Waits until it has ended.
    #[track_caller]
    pub fn ended(&self) -> ExitStatus {
        let begun = Instant::now();
        loop {
            let ended = self.child.borrow_mut().try_wait();
            if let Some(status) = ended.expect("it can be asked") {
                return status;
            }
            assert!(begun.elapsed() < PATIENCE, "it ends");
            self.look();
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}
