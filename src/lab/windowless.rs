//! The lab without a window, for tests: `myxo lab --windowless`. Each line of standard input is a list of input events; the reply
//! is one line with the state of the interface. Between two lines nothing happens.
//!
//! A line is a list of moments in JSON, each a list of [`Event`]s that come in together; at least one frame shows them before those
//! of the next moment come. After the last one there are frames until nothing moves by itself, such as a card that opens or a camera
//! on its way; a line without moments is a single frame. Time goes on by [`FRAME`] with each frame, however long it takes.

use std::io::{BufRead as _, Write as _};
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{sleep, spawn};
use std::time::{Duration, Instant};

use egui::{Event as Input, Key, Modifiers, MouseWheelUnit, PointerButton, Pos2, Rect, TouchPhase};
use myxo::{Error, Result};
use serde::Deserialize;

use crate::lab::LabOptions;
use crate::lab::app::App;
use crate::lab::host::Host;
use crate::lab::loading::Opened;

/// The time from one frame to the next. Most that moves by itself has moved after two.
const FRAME: Duration = Duration::from_millis(60);
/// Steps of a frame take about so long.
pub const PACE: Duration = Duration::from_millis(16);
/// The interface of one frame in so many is drawn, for the validation layers; nothing else looks at it.
const DRAWN: u32 = 16;
/// What moves for more frames than this does not come to rest.
const MOST_FRAMES: u64 = 90;
/// As long as a button or a key is held, something may move; so many frames show what it has done.
const FRAMES_WHILE_HELD: u64 = 2;
/// Where no frame is due, what is waited for has so much time.
const PAUSE: Duration = Duration::from_millis(25);

/// Something that happens to a window.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Event {
    /// The pointer comes to this pixel.
    Move([f32; 2]),
    /// The pointer moves by so many pixels.
    MoveBy([f32; 2]),
    /// A button of the pointer goes down: 1 is the first, 2 the one in the middle, 3 the other one.
    Press(u8),
    /// It comes up.
    Release(u8),
    /// The wheel is turned by so many notches, away from the hand.
    Wheel(f32),
    /// A key goes down: `ctrl`, `shift`, `alt`, or what egui calls it.
    KeyDown(String),
    /// It comes up.
    KeyUp(String),
    /// Letters are typed.
    Text(String),
    /// Something else puts text into the clipboard.
    Copied(String),
    /// A file is dropped onto the window.
    Drop(PathBuf),
    /// The window has this size in pixels; none is as large as one that some systems hide.
    Resize([u32; 2]),
    /// So many pixels are a point.
    Scale(f32),
    /// It is minimised, or not any more.
    Minimize(bool),
    /// It is asked to close, as by its cross.
    Close,
}

/// What stands for a window.
pub struct Windowless {
    context: egui::Context,
    input: egui::RawInput,
    begun: Instant,
    /// Since then.
    clock: Duration,
    frames: u32,
    size: [u32; 2],
    /// Pixels of a point, before the interface is zoomed.
    scale: f32,
    modifiers: Modifiers,
    pointer: Pos2,
    /// Buttons and keys that are down.
    held: Vec<String>,
    clipboard: String,
    fills_screen: bool,
    is_minimized: bool,
    /// Another frame is wanted at once.
    needs_frame: bool,
}

impl Windowless {
    fn new(size: [u32; 2]) -> Self {
        Self {
            context: egui::Context::default(),
            input: egui::RawInput::default(),
            begun: Instant::now(),
            clock: Duration::ZERO,
            frames: 0,
            size,
            scale: 1.0,
            modifiers: Modifiers::NONE,
            pointer: Pos2::ZERO,
            held: Vec::new(),
            clipboard: String::new(),
            fills_screen: false,
            is_minimized: false,
            needs_frame: true,
        }
    }

    /// The interface.
    pub fn context(&self) -> &egui::Context {
        &self.context
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Is it minimised?
    pub fn is_minimized(&self) -> bool {
        self.is_minimized
    }

    /// Does it fill the screen?
    pub fn is_full_screen(&self) -> bool {
        self.fills_screen
    }

    /// Lets it fill the screen, which is as large as the window.
    pub fn fill_screen(&mut self, fills: bool) {
        self.fills_screen = fills;
        self.needs_frame = true;
    }

    /// A frame is wanted at once.
    pub fn request_redraw(&mut self) {
        self.needs_frame = true;
    }

    /// What the next frame takes in.
    pub fn input(&mut self) -> &mut egui::RawInput {
        &mut self.input
    }

    /// Has something come in that no frame has seen?
    pub fn has_input(&self) -> bool {
        !self.input.events.is_empty()
    }

    /// What has come in since the last frame.
    pub fn take_input(&mut self) -> egui::RawInput {
        self.clock += FRAME;
        self.frames = self.frames.wrapping_add(1);
        self.needs_frame = false;
        let [width, height] = self.size.map(|side| side as f32 / self.pixels_per_point());
        let input = &mut self.input;
        input.time = Some(self.clock.as_secs_f64());
        input.screen_rect = (width > 0.0 && height > 0.0)
            .then(|| Rect::from_min_size(Pos2::ZERO, egui::vec2(width, height)));
        let viewport = input.viewports.entry(egui::ViewportId::ROOT).or_default();
        viewport.native_pixels_per_point = Some(self.scale);
        input.take()
    }

    /// The time, which frames make.
    pub fn now(&self) -> Instant {
        self.begun + self.clock
    }

    /// Is the interface of this frame drawn?
    pub fn draws_interface(&self) -> bool {
        self.frames.is_multiple_of(DRAWN)
    }

    /// Does what the interface asks of the system.
    pub fn take_output(&mut self, output: egui::PlatformOutput, repaint: Option<Duration>) {
        for command in output.commands {
            if let egui::OutputCommand::CopyText(text) = command {
                self.clipboard = text;
            }
        }
        self.needs_frame |= repaint == Some(Duration::ZERO);
    }

    fn pixels_per_point(&self) -> f32 {
        self.scale * self.context.zoom_factor()
    }

    fn push(&mut self, event: Input) {
        self.input.events.push(event);
    }

    fn move_to(&mut self, to: Pos2) {
        self.pointer = to;
        self.push(Input::PointerMoved(to));
    }

    fn press(&mut self, number: u8, pressed: bool) -> Result<()> {
        let button = match number {
            1 => PointerButton::Primary,
            2 => PointerButton::Middle,
            3 => PointerButton::Secondary,
            _ => return Err(unknown(&format!("there is no button {number}"))),
        };
        self.hold(format!("button {number}"), pressed);
        self.push(Input::PointerButton {
            pos: self.pointer,
            button,
            pressed,
            modifiers: self.modifiers,
        });
        Ok(())
    }

    fn hold(&mut self, what: String, is_held: bool) {
        self.held.retain(|held| *held != what);
        if is_held {
            self.held.push(what);
        }
    }

    /// A key as egui has it from a system: some are commands, and others are letters, too.
    fn key(&mut self, name: &str, pressed: bool) -> Result<()> {
        self.hold(name.to_owned(), pressed);
        let modifiers = &mut self.modifiers;
        match name {
            "ctrl" => (modifiers.ctrl, modifiers.command) = (pressed, pressed),
            "shift" => modifiers.shift = pressed,
            "alt" => modifiers.alt = pressed,
            _ => return self.other_key(name, pressed),
        }
        self.push(Input::ModifiersChanged(self.modifiers));
        Ok(())
    }

    fn other_key(&mut self, name: &str, pressed: bool) -> Result<()> {
        let key =
            Key::from_name(name).ok_or_else(|| unknown(&format!("there is no key {name}")))?;
        let modifiers = self.modifiers;
        if pressed && modifiers.command {
            match key {
                Key::C => {
                    self.push(Input::Copy);
                    return Ok(());
                }
                Key::X => {
                    self.push(Input::Cut);
                    return Ok(());
                }
                Key::V => {
                    if !self.clipboard.is_empty() {
                        self.push(Input::Paste(self.clipboard.replace("\r\n", "\n")));
                    }
                    return Ok(());
                }
                _ => {}
            }
        }
        self.push(Input::Key {
            key,
            physical_key: None,
            pressed,
            repeat: false,
            modifiers,
        });
        if pressed
            && !modifiers.command
            && let Some(letter) = letter(key, modifiers.shift)
        {
            self.push(Input::Text(letter));
        }
        Ok(())
    }

    fn type_text(&mut self, text: &str) {
        for letter in text.chars().map(String::from) {
            let key = Key::from_name(&letter.to_uppercase());
            let modifiers = self.modifiers;
            let mut send = |pressed| {
                if let Some(key) = key {
                    self.push(Input::Key {
                        key,
                        physical_key: None,
                        pressed,
                        repeat: false,
                        modifiers,
                    });
                }
                if pressed {
                    self.push(Input::Text(letter.clone()));
                }
            };
            send(true);
            send(false);
        }
    }
}

/// What a key types.
fn letter(key: Key, shift: bool) -> Option<String> {
    let name = match key {
        Key::Space => " ",
        key => key.symbol_or_name(),
    };
    let is_one = name.chars().count() == 1 && name.is_ascii();
    is_one.then(|| match shift {
        true => name.to_owned(),
        false => name.to_lowercase(),
    })
}

fn unknown(what: &str) -> Error {
    Error::Invalid(format!("--windowless: {what}"))
}

/// What comes from outside.
enum Message {
    Line(String),
    Close,
}

/// Runs a lab without a window until it is closed, or nothing more comes.
pub fn run(
    opened: Opened,
    options: LabOptions,
    listen: impl FnOnce(Box<dyn Fn() + Send>) -> Result<()>,
) -> Result<()> {
    let (sender, messages) = channel();
    let closes = sender.clone();
    // A send fails only when the lab has closed already.
    listen(Box::new(move || {
        let _ = closes.send(Message::Close);
    }))?;
    spawn(move || read_lines(&sender));
    let size = options.size;
    let mut app = App::new(opened, options);
    if app.open(|_, last| {
        let windowless = Windowless::new(size.unwrap_or(last));
        Ok(Host::Windowless(Box::new(windowless)))
    }) {
        let ended = app.run_lines(&messages);
        app.error = app.error.take().or(ended.err());
        app.close();
    }
    app.error.map_or(Ok(()), Err)
}

fn read_lines(sender: &Sender<Message>) {
    for line in std::io::stdin().lock().lines().map_while(Result::ok) {
        if sender.send(Message::Line(line)).is_err() {
            return;
        }
    }
    let _ = sender.send(Message::Close);
}

impl App {
    fn run_lines(&mut self, messages: &Receiver<Message>) -> Result<()> {
        while let Ok(Message::Line(line)) = messages.recv() {
            let moments: Vec<Vec<Event>> =
                serde_json::from_str(&line).map_err(|error| unknown(&error.to_string()))?;
            let goes_on = match moments.is_empty() {
                true => self.wait_a_frame(),
                false => self.take_moments(moments)?,
            };
            if !goes_on {
                return Ok(());
            }
            self.answer();
        }
        Ok(())
    }

    /// Tells what is seen.
    fn answer(&self) {
        let Some(lab) = &self.lab else { return };
        let Host::Windowless(host) = &lab.host else {
            return;
        };
        let seen = lab.places.as_ref().map_or("", |places| places.last().0);
        let seen = if seen.is_empty() { "null" } else { seen };
        let clipboard = serde_json::Value::from(host.clipboard.as_str());
        let mut out = std::io::stdout().lock();
        // Nobody listening is no reason to stop: the next line will not come.
        let _ = writeln!(out, "{{\"clipboard\":{clipboard},\"seen\":{seen}}}");
        let _ = out.flush();
    }

    /// What is being waited for may come with the next frame.
    fn wait_a_frame(&mut self) -> bool {
        let now = self.lab.as_ref().map(|lab| lab.host.now());
        let due = self.wake.zip(now);
        let due = due.map_or(PAUSE, |(wake, now)| wake.saturating_duration_since(now));
        sleep(due.min(PAUSE));
        self.draw_until(|_, frames| frames >= 1)
    }

    /// Takes in what happens. False where the lab is to close.
    fn take_moments(&mut self, moments: Vec<Vec<Event>>) -> Result<bool> {
        for moment in moments {
            for event in moment {
                if !self.take_event(event)? {
                    return Ok(false);
                }
            }
            if !self.draw_until(|_, frames| frames >= 1) {
                return Ok(false);
            }
        }
        Ok(self.draw_until(Self::rests))
    }

    /// Draws frames until `is_enough` holds for their number; frames that show nothing do not count. False where the lab is to close.
    fn draw_until(&mut self, is_enough: impl Fn(&Self, u64) -> bool) -> bool {
        let frames = |app: &Self| {
            let places = app.lab.as_ref().and_then(|lab| lab.places.as_ref());
            places.map_or(0, |places| places.last().1)
        };
        let before = frames(self);
        loop {
            if !self.draw() {
                return false;
            }
            // Where there is no size nothing is told.
            let is_hidden = self
                .lab
                .as_ref()
                .is_none_or(|lab| lab.host.size().contains(&0));
            if is_hidden || is_enough(self, frames(self) - before) {
                return true;
            }
        }
    }

    /// Does nothing move by itself but what grows and what is being written?
    fn rests(&self, frames: u64) -> bool {
        let Some(lab) = &self.lab else { return true };
        let Host::Windowless(host) = &lab.host else {
            return true;
        };
        let goes_on = lab.runs() || lab.out.is_busy() || lab.under_way.is_some();
        let is_due = self.wake.is_some_and(|wake| wake <= lab.host.now());
        let moves = host.needs_frame || host.has_input() || is_due && !goes_on;
        let most = match host.held.is_empty() {
            true => MOST_FRAMES,
            false => FRAMES_WHILE_HELD,
        };
        frames >= 1 && (!moves || frames >= most)
    }

    fn take_event(&mut self, event: Event) -> Result<bool> {
        let Some(lab) = &mut self.lab else {
            return Ok(true);
        };
        match event {
            Event::Close => return Ok(!lab.ask_to_close()),
            Event::Drop(path) => {
                lab.drop_file(path);
                return Ok(true);
            }
            _ => {}
        }
        let Host::Windowless(host) = &mut lab.host else {
            return Ok(true);
        };
        let point = 1.0 / host.pixels_per_point();
        match event {
            Event::Move([x, y]) => host.move_to(point * egui::pos2(x, y)),
            Event::MoveBy([x, y]) => host.move_to(host.pointer + point * egui::vec2(x, y)),
            Event::Press(number) => host.press(number, true)?,
            Event::Release(number) => host.press(number, false)?,
            Event::Wheel(notches) => host.push(Input::MouseWheel {
                unit: MouseWheelUnit::Line,
                delta: egui::vec2(0.0, notches),
                phase: TouchPhase::Move,
                modifiers: host.modifiers,
            }),
            Event::KeyDown(name) => host.key(&name, true)?,
            Event::KeyUp(name) => host.key(&name, false)?,
            Event::Text(text) => host.type_text(&text),
            Event::Copied(text) => host.clipboard = text,
            Event::Scale(scale) => host.scale = scale,
            Event::Minimize(is) => host.is_minimized = is,
            Event::Resize(size) => {
                host.size = size;
                lab.resize(size);
            }
            Event::Close | Event::Drop(_) => {}
        }
        lab.host.request_redraw();
        Ok(true)
    }
}
