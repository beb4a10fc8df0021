//! What winit calls: from events of the system to frames of the lab.

use std::time::Instant;

use myxo::Error;
use winit::application::ApplicationHandler;
use winit::event::{StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::window::WindowId;

use super::LabOptions;
use super::loading::Opened;
use super::window::Lab;

/// Somebody outside the window asks that it be closed.
#[derive(Clone, Copy, Debug)]
pub struct Close;

/// What winit calls.
pub struct App {
    options: LabOptions,
    opened: Option<Opened>,
    lab: Option<Lab>,
    /// When to draw next, if nothing happens before.
    wake: Option<Instant>,
    /// What ended the lab, if not the user.
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
            error: None,
        }
    }

    /// After a device that was lost the lab goes on with another one; everything else ends it, and the scene is kept.
    fn survive(&mut self, events: &ActiveEventLoop, error: &Error) {
        let Some(mut lab) = self.lab.take() else {
            return;
        };
        if lab.can_begin_anew(error) {
            match lab.begin_anew(error, &self.options) {
                Ok(lab) => self.lab = Some(lab),
                Err(error) => self.fail(events, error),
            }
            return;
        }
        let error = lab.rescue(error);
        self.lab = Some(lab);
        self.fail(events, error);
    }

    fn fail(&mut self, events: &ActiveEventLoop, error: Error) {
        self.error = Some(error);
        events.exit();
    }
}

impl ApplicationHandler<Close> for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        let Some(opened) = self.opened.take() else {
            return;
        };
        match Lab::open(events, opened, &self.options) {
            Ok(lab) => self.lab = Some(lab),
            Err(error) => self.fail(events, error),
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(lab) = &mut self.lab else {
            return;
        };
        let wants_repaint = lab.take_in(&event);
        match event {
            WindowEvent::CloseRequested if lab.ask_to_close() => events.exit(),
            WindowEvent::CloseRequested => lab.window.request_redraw(),
            WindowEvent::Resized(size) => lab.resize(size.into()),
            WindowEvent::DroppedFile(path) => lab.drop_file(path),
            WindowEvent::RedrawRequested => match lab.frame() {
                Ok(_) if lab.has_closed() => events.exit(),
                Ok(next) => self.wake = next,
                Err(error) => self.survive(events, &error),
            },
            _ if wants_repaint => lab.window.request_redraw(),
            _ => {}
        }
    }

    fn user_event(&mut self, events: &ActiveEventLoop, _: Close) {
        events.exit();
    }

    fn new_events(&mut self, _: &ActiveEventLoop, cause: StartCause) {
        if let (StartCause::ResumeTimeReached { .. }, Some(lab)) = (cause, &self.lab) {
            lab.window.request_redraw();
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        events.set_control_flow(match self.wake {
            Some(wake) if wake <= Instant::now() => {
                if let Some(lab) = &self.lab {
                    lab.window.request_redraw();
                }
                ControlFlow::Wait
            }
            Some(wake) => ControlFlow::WaitUntil(wake),
            None => ControlFlow::Wait,
        });
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        if let Some(lab) = self.lab.take()
            && let Err(error) = lab.close()
            && self.error.is_none()
        {
            self.error = Some(error);
        }
    }
}
