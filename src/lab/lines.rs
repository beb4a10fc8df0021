//! Runs the lab without a window: lines of events come in by standard input, and each is answered by one line.

use crate::lab::app::App;
use crate::lab::host::Host;
use crate::lab::loading::Opened;
use crate::lab::options::LabOptions;
use crate::lab::windowless::*;
use egui::{Event as Input, MouseWheelUnit, TouchPhase};
use myxo::Result;
use std::io::{BufRead as _, Write as _};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{sleep, spawn};

/// Messages from other threads.
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
            let continues = match moments.is_empty() {
                true => self.wait_a_frame(),
                false => self.take_moments(moments)?,
            };
            if !continues {
                return Ok(());
            }
            self.answer();
        }
        Ok(())
    }

    /// Writes what is seen.
    fn answer(&self) {
        let Some(lab) = &self.lab else { return };
        let Host::Windowless(host) = &lab.host else {
            return;
        };
        let seen = lab.places.as_ref().map_or("", |places| places.last().0);
        let seen = if seen.is_empty() { "null" } else { seen };
        let clipboard = serde_json::Value::from(host.clipboard.as_str());
        let mut out = std::io::stdout().lock();
        // A closed output is no reason to stop: the next line will not come.
        let _ = writeln!(out, "{{\"clipboard\":{clipboard},\"seen\":{seen}}}");
        let _ = out.flush();
    }

    /// Waits a frame, because pending work may be done with the next one.
    fn wait_a_frame(&mut self) -> bool {
        let now = self.lab.as_ref().map(|lab| lab.host.now());
        let due = self.wake.zip(now);
        let due = due.map_or(PAUSE, |(wake, now)| wake.saturating_duration_since(now));
        sleep(due.min(PAUSE));
        self.draw_until(|_, frames| frames >= 1)
    }

    /// Takes in the events. Returns false if the lab is to close.
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

    /// Draws frames until `is_enough` holds for their number; frames that show nothing do not count. Returns false if the lab
    /// is to close.
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
            // A window that shows nothing has no places to write.
            let is_hidden = (self.lab.as_ref())
                .is_none_or(|lab| lab.host.is_unseen() || lab.host.size().contains(&0));
            if is_hidden || is_enough(self, frames(self) - before) {
                return true;
            }
        }
    }

    /// Is nothing in motion except the simulation and files that are being written?
    fn rests(&self, frames: u64) -> bool {
        let Some(lab) = &self.lab else { return true };
        let Host::Windowless(host) = &lab.host else {
            return true;
        };
        let advances = lab.runs() || lab.jobs.exports.is_busy() || lab.runner.is_within_slices();
        let is_due = self.wake.is_some_and(|wake| wake <= lab.host.now());
        let moves = host.needs_frame || host.has_input() || is_due && !advances;
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
            Event::Hide(is) => host.is_unseen = is,
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
