//! Input to a lab: lines to a lab without a window, or `xdotool` on a display.

use std::io::{BufRead as _, BufReader, Write as _};
use std::process::{Child, ChildStdin};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread::spawn;

use serde_json::{Value, json};

use crate::lab::PATIENCE;
use crate::real::display::Display;

/// The receiver of input.
pub enum Input {
    Lines(Box<Lines>),
    Display(Box<Display>),
}

/// What a user does. Keys have the names that `xdotool` uses.
#[derive(Clone, Debug)]
pub enum Gesture<'a> {
    /// Moves the pointer to this pixel.
    Move(f64, f64),
    /// Moves the pointer by so many pixels.
    MoveBy(i32, i32),
    Down(u8),
    Up(u8),
    /// Presses and releases a button.
    Click(u8),
    DoubleClick,
    /// Turns the wheel by a notch: away from the user, or towards them.
    Wheel(bool),
    KeyDown(&'a str),
    KeyUp(&'a str),
    /// Presses these keys one after the other, as quickly as possible; modifiers come first: `ctrl+s`.
    Keys(&'a [&'a str]),
    Write(&'a str),
    Resize(u32, u32),
    /// The window cannot be seen for so many frames. Without a window only.
    HideFor(usize),
}

impl Gesture<'_> {
    /// The keys that it presses and releases.
    pub fn keys(&self) -> &[&str] {
        match self {
            Self::Keys(keys) => keys,
            _ => &[],
        }
    }

    /// Does it press one of the pointer's buttons?
    pub fn presses(&self) -> bool {
        matches!(self, Self::Down(_) | Self::Click(_) | Self::DoubleClick)
    }

    /// The events of each frame.
    fn moments(&self) -> Value {
        match self {
            Self::Move(x, y) => json!([[{ "move": [x, y] }]]),
            Self::MoveBy(x, y) => json!([[{ "move_by": [x, y] }]]),
            Self::Down(button) => json!([[{ "press": button }]]),
            Self::Up(button) => json!([[{ "release": button }]]),
            Self::Click(button) => json!([[{ "press": button }], [{ "release": button }]]),
            Self::DoubleClick => {
                let both = [json!([{ "press": 1 }]), json!([{ "release": 1 }])];
                json!([both[0], both[1], both[0], both[1]])
            }
            Self::Wheel(away) => json!([[{ "wheel": if *away { 1 } else { -1 } }]]),
            Self::KeyDown(key) => json!([[{ "key_down": key_of(key) }]]),
            Self::KeyUp(key) => json!([[{ "key_up": key_of(key) }]]),
            Self::Keys([key]) => {
                let (down, up) = strokes(key);
                json!([down, up])
            }
            Self::Keys(keys) => {
                let all = keys.iter().map(|key| strokes(key));
                let all: Vec<Value> = all.flat_map(|(down, up)| [down, up].concat()).collect();
                json!([all])
            }
            Self::Write(text) => json!([[{ "text": text }]]),
            Self::Resize(width, height) => json!([[{ "resize": [width, height] }]]),
            Self::HideFor(frames) => {
                let mut moments = vec![json!([]); *frames];
                moments[0] = json!([{ "hide": true }]);
                moments.push(json!([{ "hide": false }]));
                Value::Array(moments)
            }
        }
    }
}

/// The events that press keys, and those that release them.
fn strokes(keys: &str) -> (Vec<Value>, Vec<Value>) {
    let keys: Vec<String> = keys.split('+').map(key_of).collect();
    let down = keys.iter().map(|key| json!({ "key_down": key }));
    let up = keys.iter().rev().map(|key| json!({ "key_up": key }));
    (down.collect(), up.collect())
}

/// The lab's name of a key.
fn key_of(name: &str) -> String {
    let other = match name {
        "Shift_L" => "shift",
        "Return" => "Enter",
        "BackSpace" => "Backspace",
        "space" => "Space",
        "period" => "Period",
        "slash" => "Slash",
        "plus" => "Plus",
        "minus" => "Minus",
        "bracketleft" => "OpenBracket",
        "bracketright" => "CloseBracket",
        name if name.len() == 1 => return name.to_uppercase(),
        name => name,
    };
    other.to_owned()
}

/// A lab without a window: it reads input as lines and answers each.
pub struct Lines {
    input: ChildStdin,
    answers: Receiver<String>,
    /// Its last answer.
    answer: Option<Value>,
    /// The last line was input, so controls stay where the answer says.
    pub rests: bool,
    /// The lab has ended.
    has_ended: bool,
}

impl Lines {
    /// Takes the pipes of a child that has just begun.
    pub fn new(child: &mut Child) -> Self {
        let out = BufReader::new(child.stdout.take().expect("it is piped"));
        let (sender, answers) = channel();
        // Ends when the child closes its output or the receiver is dropped.
        spawn(move || {
            let lines = out.lines().map_while(Result::ok);
            lines.map(|line| sender.send(line)).all(|sent| sent.is_ok())
        });
        Self {
            input: child.stdin.take().expect("it is piped"),
            answers,
            answer: None,
            rests: false,
            has_ended: false,
        }
    }

    /// Sends a gesture.
    pub fn perform(&mut self, what: &Gesture) {
        self.send(&what.moments());
        self.rests = true;
    }

    /// Sends gestures in one line, each in moments of its own.
    pub fn perform_all(&mut self, all: &[Gesture]) {
        let mut moments = Vec::new();
        for what in all {
            if let Value::Array(own) = what.moments() {
                moments.extend(own);
            }
            if what.presses() {
                // What a click opens is there in a later frame.
                moments.extend([json!([]), json!([])]);
            }
        }
        self.send(&Value::Array(moments));
        self.rests = true;
    }

    /// Lets it draw a frame.
    pub fn look(&mut self) {
        self.send(&json!([]));
        self.rests = false;
    }

    /// Sends a line and waits for its answer.
    pub fn send(&mut self, moments: &Value) {
        if self.has_ended {
            return;
        }
        let sent = writeln!(self.input, "{moments}").and_then(|()| self.input.flush());
        if sent.is_err() {
            self.has_ended = true;
            return;
        }
        match self.answers.recv_timeout(PATIENCE) {
            Ok(answer) => {
                let answer = serde_json::from_str(&answer);
                self.answer = Some(answer.expect("answers are JSON"));
            }
            Err(RecvTimeoutError::Disconnected) => self.has_ended = true,
            Err(RecvTimeoutError::Timeout) => panic!("no answer to {moments}"),
        }
    }

    /// What the lab shows.
    pub fn seen(&self) -> Option<Value> {
        let seen = self.answer.as_ref()?["seen"].clone();
        (!seen.is_null()).then_some(seen)
    }

    /// The lab's clipboard.
    pub fn clipboard(&self) -> String {
        let answer = self.answer.as_ref();
        let text = answer.and_then(|answer| answer["clipboard"].as_str());
        text.unwrap_or_default().to_owned()
    }
}
