//! The application that winit calls: its events become frames, and it handles errors.

use std::time::{Duration, Instant};

use myxo::{Error, Result};
use winit::application::ApplicationHandler;
use winit::event::{StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::window::WindowId;

use crate::lab::host::Host;
use crate::lab::loading::Opened;
use crate::lab::options::LabOptions;
use crate::lab::window::Lab;

/// If a requested frame does not come within this time, the window cannot be seen: Wayland's compositors stop asking for frames.
const UNSEEN_AFTER: Duration = Duration::from_secs(1);

/// A request from outside the window to close it.
#[derive(Clone, Copy, Debug)]
pub struct Close;

/// An open lab, from its first frame to its end.
pub struct App {
    options: LabOptions,
    opened: Option<Opened>,
    /// None before it is opened, and after it has ended.
    pub lab: Option<Lab>,
    /// When to draw next, if nothing happens before.
    pub wake: Option<Instant>,
    /// Since when a requested frame has not come.
    asked: Option<Instant>,
    /// The last picture did not reach the window. On Wayland no frame comes before one does.
    has_missed: bool,
    /// The error that ended the lab, if the user did not end it.
    pub error: Option<Error>,
}

impl App {
    /// An app that opens its window when the event loop runs.
    pub fn new(opened: Opened, options: LabOptions) -> Self {
        Self {
            options,
            opened: Some(opened),
            lab: None,
            wake: None,
            asked: None,
            has_missed: false,
            error: None,
        }
    }

    /// Opens the lab the first time. Returns false if that fails.
    pub fn open(&mut self, host: impl FnOnce(&str, [u32; 2]) -> Result<Host>) -> bool {
        let Some(opened) = self.opened.take() else {
            return true;
        };
        match Lab::open(host, opened, &self.options) {
            Ok(lab) => self.lab = Some(lab),
            Err(error) => self.error = Some(error),
        }
        self.error.is_none()
    }

    /// Draws a frame. Returns false if it was the last one.
    pub fn draw(&mut self) -> bool {
        let Some(lab) = &mut self.lab else {
            return true;
        };
        match lab.frame() {
            Ok(_) if lab.has_closed() => return false,
            Ok(next) => {
                self.wake = next;
                self.has_missed |= lab.take_missed();
            }
            Err(error) => self.survive(&error),
        }
        self.error.is_none()
    }

    /// After a lost device the lab continues with another one; all other errors end it, and the scene is kept.
    fn survive(&mut self, error: &Error) {
        let Some(mut lab) = self.lab.take() else {
            return;
        };
        if lab.can_change_device(error) {
            match lab.change_device(error, &self.options) {
                Ok(lab) => {
                    self.lab = Some(lab);
                    self.has_missed = true;
                }
                Err(error) => self.error = Some(error),
            }
            return;
        }
        self.error = Some(lab.rescue(error));
        self.lab = Some(lab);
    }

    /// Ends the lab, and keeps what is to be kept.
    pub fn close(&mut self) {
        if let Some(lab) = self.lab.take()
            && let Err(error) = lab.close()
            && self.error.is_none()
        {
            self.error = Some(error);
        }
    }
}

impl ApplicationHandler<Close> for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        let size = self.options.size;
        if !self.open(|title, last| Host::window(events, title, size, last)) {
            events.exit();
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(lab) = &mut self.lab else {
            return;
        };
        let wants_repaint = lab.take_in(&event);
        if matches!(event, WindowEvent::RedrawRequested) {
            self.asked = None;
            lab.host.set_unseen(false);
            if !self.draw() {
                events.exit();
            }
            return;
        }
        match event {
            WindowEvent::CloseRequested if lab.ask_to_close() => events.exit(),
            WindowEvent::CloseRequested => lab.host.request_redraw(),
            WindowEvent::Resized(size) => lab.resize(size.into()),
            WindowEvent::DroppedFile(path) => lab.drop_file(path),
            _ if wants_repaint => lab.host.request_redraw(),
            _ => {}
        }
    }

    fn user_event(&mut self, events: &ActiveEventLoop, _: Close) {
        events.exit();
    }

    fn new_events(&mut self, _: &ActiveEventLoop, cause: StartCause) {
        if let (StartCause::ResumeTimeReached { .. }, Some(lab)) = (cause, &mut self.lab) {
            lab.host.request_redraw();
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        let now = Instant::now();
        let is_due = self.wake.is_some_and(|wake| wake <= now);
        let mut next = self.wake;
        if let Some(lab) = self.lab.as_mut().filter(|_| is_due) {
            lab.host.request_redraw();
            let unseen_at = *self.asked.get_or_insert(now) + UNSEEN_AFTER;
            next = Some(unseen_at);
            if unseen_at <= now {
                // Steps, films and whatever else is under way go on without the system.
                lab.host.set_unseen(!std::mem::take(&mut self.has_missed));
                if !self.draw() {
                    events.exit();
                }
                next = self.wake;
            }
        }
        events.set_control_flow(next.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        self.close();
    }
}
