//! Input on an X display: pointer and keys by `xdotool`, and the clipboard by `xclip`. There is one pointer, so tests take turns.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::sleep;
use std::time::{Duration, Instant};

use serde_json::Value;

use super::messages;
use crate::input::Gesture;
use crate::lab::PATIENCE;

/// Input reaches the window within this time; a frame that shows it may come later.
const REACHES_IT: Duration = Duration::from_millis(150);
/// The least time between two inputs.
const AT_LEAST: Duration = Duration::from_millis(30);
/// After so long without a new frame, the window may be gone.
const GOES_WITHIN: Duration = Duration::from_secs(1);
/// The interval at which the window's report is read.
const INTERVAL: Duration = Duration::from_millis(10);

/// There is one pointer.
static HAND: Mutex<()> = Mutex::new(());

/// Waits until no other test has the pointer.
pub fn only_one() -> MutexGuard<'static, ()> {
    HAND.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A lab's window. It holds the pointer until it is dropped.
pub struct Display {
    /// The file into which the lab writes what the window shows.
    places: PathBuf,
    window: String,
    /// When input was sent last.
    moved: Instant,
    _guard: MutexGuard<'static, ()>,
}

/// Runs `xdotool` and returns its output.
pub fn xdotool(arguments: &[&str]) -> String {
    let output = Command::new("xdotool").args(arguments).output();
    let output = output.expect("it is installed");
    String::from_utf8_lossy(&output.stdout).trim().to_owned()
}

impl Display {
    /// Waits until the pointer is free. `places` is the file into which the lab writes what it shows.
    pub fn new(places: PathBuf) -> Self {
        Self {
            _guard: only_one(),
            places,
            window: String::new(),
            moved: Instant::now(),
        }
    }

    /// Moves the window of that process to the corner, where coordinates of the pointer are right, and gives it the keyboard.
    pub fn take_hold(&mut self, process: u32) {
        let process = process.to_string();
        let begun = Instant::now();
        while self.window.is_empty() {
            let windows = xdotool(&["search", "--onlyvisible", "--pid", &process]);
            windows
                .lines()
                .last()
                .unwrap_or_default()
                .clone_into(&mut self.window);
            assert!(begun.elapsed() < PATIENCE, "there is no window");
        }
        self.hold_again();
    }

    /// Does this again after the window was moved.
    pub fn hold_again(&mut self) {
        self.ask(&["windowmove", &self.window, "0", "0"]);
        self.ask(&["windowraise", &self.window]);
        self.ask(&["windowfocus", &self.window]);
        let begun = Instant::now();
        let is_held = |window: &str| {
            let geometry = xdotool(&["getwindowgeometry", "--shell", window]);
            let is_there = ["X=0", "Y=0"]
                .iter()
                .all(|place| geometry.lines().any(|line| line == *place));
            is_there && xdotool(&["getwindowfocus", "-f"]) == window
        };
        while !is_held(&self.window) {
            assert!(begun.elapsed() < PATIENCE, "it takes no hold of the window");
            sleep(INTERVAL);
        }
        self.settle(0);
    }

    /// The window's id.
    pub fn window(&self) -> &str {
        &self.window
    }

    /// Runs `xdotool` on the window.
    pub fn ask(&self, arguments: &[&str]) -> String {
        xdotool(arguments)
    }

    /// What it shows.
    pub fn seen(&self) -> Option<Value> {
        serde_json::from_str(&std::fs::read_to_string(&self.places).ok()?).ok()
    }

    /// Lets some time pass.
    pub fn look(&self) {
        sleep(INTERVAL);
    }

    /// No frame is due, and all input has arrived.
    pub fn rests(&self, seen: &Value) -> bool {
        seen["rests"] == true && self.moved.elapsed() > REACHES_IT
    }

    fn frames(&self) -> u64 {
        let frames = self.seen().and_then(|seen| seen["frames"].as_u64());
        frames.unwrap_or_default()
    }

    /// Waits for two frames after `frames`, the second of which began after the last input, unless none is due.
    fn settle(&mut self, frames: u64) {
        self.moved = Instant::now();
        while self.moved.elapsed() < PATIENCE {
            let since = self.moved.elapsed();
            let Some(seen) = self.seen() else {
                return;
            };
            let is_shown = seen["frames"].as_u64() >= Some(frames + 2) && since > AT_LEAST;
            let has_gone = || since > GOES_WITHIN && !self.is_there();
            if is_shown || self.rests(&seen) || has_gone() {
                return;
            }
            sleep(INTERVAL);
        }
    }

    /// Has the window not gone?
    fn is_there(&self) -> bool {
        !xdotool(&["getwindowname", &self.window]).is_empty()
    }

    /// Sends a gesture and gives the window time to react.
    pub fn perform(&mut self, what: &Gesture) {
        let frames = self.frames();
        let click = |button: &u8| {
            xdotool(&["click", "--delay", "60", &button.to_string()]);
        };
        match what {
            Gesture::Move(x, y) => {
                xdotool(&["mousemove", &x.to_string(), &y.to_string()]);
            }
            Gesture::MoveBy(x, y) => {
                xdotool(&["mousemove_relative", "--", &x.to_string(), &y.to_string()]);
            }
            Gesture::Down(button) => {
                xdotool(&["mousedown", &button.to_string()]);
            }
            Gesture::Up(button) => {
                xdotool(&["mouseup", &button.to_string()]);
            }
            Gesture::Click(button) => {
                // Long enough to be seen between two slow frames.
                self.perform(&Gesture::Down(*button));
                return self.perform(&Gesture::Up(*button));
            }
            Gesture::DoubleClick => {
                xdotool(&["click", "--repeat", "2", "--delay", "90", "1"]);
            }
            Gesture::Wheel(away) => click(if *away { &4 } else { &5 }),
            Gesture::KeyDown(key) => {
                xdotool(&["keydown", key]);
            }
            Gesture::KeyUp(key) => {
                xdotool(&["keyup", key]);
            }
            Gesture::Keys(keys) => {
                let delay = if keys.len() == 1 { "40" } else { "12" };
                xdotool(&[&["key", "--delay", delay], *keys].concat());
                if keys.contains(&"ctrl+q") {
                    // The window is closing and shows nothing after that.
                    return;
                }
            }
            Gesture::Write(text) => {
                xdotool(&["type", "--delay", "30", "--", text]);
            }
            Gesture::Resize(width, height) => {
                let (width, height) = (width.to_string(), height.to_string());
                xdotool(&["windowsize", &self.window, &width, &height]);
            }
            Gesture::HideFor(_) => panic!("a display shows all of its windows"),
        }
        self.settle(frames);
    }

    /// Drops files onto the middle of the window, and waits until it has taken them.
    pub fn drop_files(&mut self, files: &[&Path]) {
        let frames = self.frames();
        messages::drop_all_on(&self.window, files);
        self.settle(frames);
    }

    /// Asks the window to close, as the cross in its frame does.
    pub fn ask_to_close(&self) {
        messages::send_to(&self.window, "WM_PROTOCOLS", "WM_DELETE_WINDOW");
    }

    /// Puts text into the clipboard, which a program of its own holds.
    pub fn copy(&self, text: &str) {
        let mut holder = Command::new("xclip")
            .args(["-selection", "clipboard"])
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("it is installed");
        let mut pipe = holder.stdin.take().expect("it is piped");
        pipe.write_all(text.as_bytes()).expect("it is read");
        drop(pipe);
        assert!(holder.wait().expect("it ends").success());
    }

    /// What is in the clipboard.
    pub fn clipboard(&self) -> String {
        // `xclip` waits for the program that has copied something.
        let output = Command::new("timeout")
            .args(["5", "xclip", "-selection", "clipboard", "-out"])
            .stdin(Stdio::null())
            .output();
        let output = output.expect("it is installed");
        String::from_utf8_lossy(&output.stdout).into_owned()
    }

    /// Takes a picture of the display, and says where it is.
    pub fn picture(&self) -> String {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let name = format!("window_{}_{number}.png", std::process::id());
        let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        let display = std::env::var("DISPLAY").unwrap_or_default();
        let taken = Command::new("ffmpeg")
            .args(["-v", "error", "-y", "-f", "x11grab", "-i", &display])
            .args(["-frames:v", "1"])
            .arg(&file)
            .stdin(Stdio::null())
            .status();
        match taken {
            Ok(status) if status.success() => format!("; the display: {}", file.display()),
            _ => "; there is no picture of the display".to_owned(),
        }
    }
}
