//! The lab without a window, for tests: `myxo lab --windowless`. Each line of standard input is a list of input events; the reply
//! is one line with the state of the interface. Between two lines nothing happens.
//!
//! A line is a list of moments in JSON, each a list of [`Event`]s that come in together; at least one frame shows them before
//! those of the next moment come. After the last one there are frames until animations have ended, such as a card that opens or
//! a camera on its way; a line without moments is a single frame. Time advances by [`FRAME`] with each frame, however long it
//! takes.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use egui::{Event as Input, Key, Modifiers, PointerButton, Pos2, Rect};
use myxo::{Error, Result};
use serde::Deserialize;

/// The time from one frame to the next. Most animations have ended after two.
pub const FRAME: Duration = Duration::from_millis(60);
/// Steps of a frame take about so long.
pub const PACE: Duration = Duration::from_millis(16);
/// Steps of a frame, at the most: tests wait for frames and not for steps, and a step takes the host longer than the device.
pub const MOST_STEPS: u32 = 2;
/// The interface of one frame in this many is drawn, for the validation layers; nothing else looks at it.
pub const DRAWN: u32 = 16;
/// An animation of more frames than this counts as endless. A look that changes within two seconds takes 42.
pub const MOST_FRAMES: u64 = 50;
/// While a button or a key is held, something may move; this many frames show its effect.
pub const FRAMES_WHILE_HELD: u64 = 2;
/// If no frame is due, pending work has this much time.
pub const PAUSE: Duration = Duration::from_millis(25);

/// Something that happens to a window.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Event {
    /// The pointer comes to this pixel.
    Move([f32; 2]),
    /// The pointer moves by this many pixels.
    MoveBy([f32; 2]),
    /// A button of the pointer goes down: 1 is the first, 2 the one in the middle, 3 the other one.
    Press(u8),
    /// It is released.
    Release(u8),
    /// The wheel is turned by this number of notches, away from the user.
    Wheel(f32),
    /// A key goes down: `ctrl`, `shift`, `alt`, or what egui calls it.
    KeyDown(String),
    /// It is released.
    KeyUp(String),
    /// Letters are typed.
    Text(String),
    /// Something else puts text into the clipboard.
    Copied(String),
    /// A file is dropped onto the window.
    Drop(PathBuf),
    /// The window has this size in pixels; none is as large as one that some systems hide.
    Resize([u32; 2]),
    /// Pixels per point.
    Scale(f32),
    /// The window cannot be seen, as on another workspace, or can be again.
    Hide(bool),
    /// The window is asked to close, as by its cross.
    Close,
}

/// The replacement of a window.
pub struct Windowless {
    pub context: egui::Context,
    pub input: egui::RawInput,
    pub begun: Instant,
    /// Since then.
    pub clock: Duration,
    pub frames: u32,
    pub size: [u32; 2],
    /// Pixels of a point, before the interface is zoomed.
    pub scale: f32,
    pub modifiers: Modifiers,
    pub pointer: Pos2,
    /// Buttons and keys that are down.
    pub held: Vec<String>,
    pub clipboard: String,
    pub fills_screen: bool,
    /// No pictures are wanted.
    pub is_unseen: bool,
    /// Another frame is wanted at once.
    pub needs_frame: bool,
}

impl Windowless {
    pub fn new(size: [u32; 2]) -> Self {
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
            is_unseen: false,
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

    /// The input of the next frame.
    pub fn input(&mut self) -> &mut egui::RawInput {
        &mut self.input
    }

    /// Has something come in that no frame has seen?
    pub fn has_input(&self) -> bool {
        !self.input.events.is_empty()
    }

    /// Takes the input since the last frame.
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

    pub fn pixels_per_point(&self) -> f32 {
        self.scale * self.context.zoom_factor()
    }

    pub fn push(&mut self, event: Input) {
        self.input.events.push(event);
    }

    pub fn move_to(&mut self, to: Pos2) {
        self.pointer = to;
        self.push(Input::PointerMoved(to));
    }

    pub fn press(&mut self, number: u8, pressed: bool) -> Result<()> {
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

    pub fn hold(&mut self, what: String, is_held: bool) {
        self.held.retain(|held| *held != what);
        if is_held {
            self.held.push(what);
        }
    }

    /// A key as egui has it from a system: some are commands, and others are letters, too.
    pub fn key(&mut self, name: &str, pressed: bool) -> Result<()> {
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

    pub fn other_key(&mut self, name: &str, pressed: bool) -> Result<()> {
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

    pub fn type_text(&mut self, text: &str) {
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

/// The letter that a key types.
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

pub fn unknown(what: &str) -> Error {
    Error::Invalid(format!("--windowless: {what}"))
}
