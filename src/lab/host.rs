//! The place where the lab is shown: a window of the system or, for tests, no window. All requests to a window pass through
//! here; everything else is equal for both.

use std::time::{Duration, Instant};

use egui_winit::State;
use myxo::{Error, Result};
use raw_window_handle::{HasDisplayHandle, HasWindowHandle, RawDisplayHandle, RawWindowHandle};
use winit::dpi::{LogicalSize, PhysicalSize, Size};
use winit::event::WindowEvent;
use winit::event_loop::ActiveEventLoop;
use winit::window::{Fullscreen, Window};

use crate::lab::preferences::Preferences;
use crate::lab::windowless::{self, Windowless};

/// A window, or what stands for one.
pub enum Host {
    /// A window of the system.
    Window(Box<SystemWindow>),
    /// Input comes from elsewhere, and nothing is seen.
    Windowless(Box<Windowless>),
}

/// Fields are dropped in this order: the clipboard before the window.
pub struct SystemWindow {
    egui: State,
    window: Window,
    /// It cannot be seen; to present a picture could block for as long as that lasts.
    is_unseen: bool,
}

impl Host {
    /// Opens a window of this size in pixels, else as large as last time.
    pub fn window(
        events: &ActiveEventLoop,
        title: &str,
        size: Option<[u32; 2]>,
        last: [u32; 2],
    ) -> Result<Self> {
        let attributes = Window::default_attributes()
            .with_title(title)
            .with_inner_size(first_size(events, size, last))
            .with_min_inner_size(LogicalSize::new(480, 320));
        let window = events
            .create_window(attributes)
            .map_err(|source| no_window(&source))?;
        let egui = State::new(
            egui::Context::default(),
            egui::ViewportId::ROOT,
            &window,
            Some(window.scale_factor() as f32),
            None,
            None,
        );
        Ok(Self::Window(Box::new(SystemWindow {
            egui,
            window,
            is_unseen: false,
        })))
    }

    /// The window's handles for Vulkan; the window must outlive the objects made with them. None without a window.
    pub fn handles(&self) -> Result<Option<(RawDisplayHandle, RawWindowHandle)>> {
        let Self::Window(shown) = self else {
            return Ok(None);
        };
        let display = shown.window.display_handle();
        let display = display.map_err(|source| no_window(&source))?.as_raw();
        let window = shown.window.window_handle();
        let window = window.map_err(|source| no_window(&source))?.as_raw();
        Ok(Some((display, window)))
    }

    /// The interface.
    pub fn context(&self) -> &egui::Context {
        match self {
            Self::Window(shown) => shown.egui.egui_ctx(),
            Self::Windowless(shown) => shown.context(),
        }
    }

    /// Width and height in pixels; 0 where it is hidden on some systems.
    pub fn size(&self) -> [u32; 2] {
        match self {
            Self::Window(shown) => shown.window.inner_size().into(),
            Self::Windowless(shown) => shown.size(),
        }
    }

    /// Is it minimised or unseen, as far as that is known?
    pub fn is_hidden(&self) -> bool {
        let is_minimized = match self {
            Self::Window(shown) => shown.window.is_minimized() == Some(true),
            Self::Windowless(_) => false,
        };
        is_minimized || self.is_unseen()
    }

    /// Is nothing shown, because the system wants no pictures? Windows of Wayland that are on another workspace are an example.
    pub fn is_unseen(&self) -> bool {
        match self {
            Self::Window(shown) => shown.is_unseen,
            Self::Windowless(shown) => shown.is_unseen,
        }
    }

    /// The system wants no pictures, or wants them again.
    pub fn set_unseen(&mut self, is_unseen: bool) {
        match self {
            Self::Window(shown) => shown.is_unseen = is_unseen,
            Self::Windowless(shown) => shown.is_unseen = is_unseen,
        }
    }

    /// A picture is about to be shown. After this, Wayland asks for the next one when it can be seen.
    pub fn will_present(&self) {
        if let Self::Window(shown) = self {
            shown.window.pre_present_notify();
        }
    }

    /// A frame is wanted soon.
    pub fn request_redraw(&mut self) {
        match self {
            Self::Window(shown) => shown.window.request_redraw(),
            Self::Windowless(shown) => shown.request_redraw(),
        }
    }

    /// Names the window.
    pub fn set_title(&mut self, title: &str) {
        match self {
            Self::Window(shown) => shown.window.set_title(title),
            Self::Windowless(_) => {}
        }
    }

    /// Does it fill the screen?
    pub fn is_full_screen(&self) -> bool {
        match self {
            Self::Window(shown) => shown.window.fullscreen().is_some(),
            Self::Windowless(shown) => shown.is_full_screen(),
        }
    }

    /// Lets it fill the screen, or be a window again.
    pub fn fill_screen(&mut self, fills: bool) {
        match self {
            Self::Window(shown) => {
                let screen = fills.then_some(Fullscreen::Borderless(None));
                shown.window.set_fullscreen(screen);
            }
            Self::Windowless(shown) => shown.fill_screen(fills),
        }
    }

    /// How large a texture of the interface may be.
    pub fn set_max_texture_side(&mut self, side: usize) {
        match self {
            Self::Window(shown) => shown.egui.set_max_texture_side(side),
            Self::Windowless(shown) => shown.input().max_texture_side = Some(side),
        }
    }

    /// Takes an event of the system in. Does the window have to be drawn again?
    pub fn take_in(&mut self, event: &WindowEvent) -> bool {
        match self {
            Self::Window(shown) => shown.egui.on_window_event(&shown.window, event).repaint,
            Self::Windowless(_) => false,
        }
    }

    /// Has something come in that no frame has seen?
    pub fn has_input(&self) -> bool {
        match self {
            Self::Window(shown) => !shown.egui.egui_input().events.is_empty(),
            Self::Windowless(shown) => shown.has_input(),
        }
    }

    /// Takes the input since the last frame.
    pub fn take_input(&mut self) -> egui::RawInput {
        match self {
            Self::Window(shown) => shown.egui.take_egui_input(&shown.window),
            Self::Windowless(shown) => shown.take_input(),
        }
    }

    /// The time: without a window it goes by frames.
    pub fn now(&self) -> Instant {
        match self {
            Self::Window(_) => Instant::now(),
            Self::Windowless(shown) => shown.now(),
        }
    }

    /// The time that the simulation may take in a frame that comes this long after the one before.
    pub fn pace(&self, since_last: Duration) -> Duration {
        match self {
            Self::Window(_) => since_last,
            Self::Windowless(_) => windowless::PACE,
        }
    }

    /// The most steps of a frame while the simulation runs.
    pub fn most_steps(&self) -> u32 {
        match self {
            Self::Window(_) => u32::MAX,
            Self::Windowless(_) => windowless::MOST_STEPS,
        }
    }

    /// Is the interface of this frame drawn?
    pub fn draws_interface(&self) -> bool {
        match self {
            Self::Window(_) => true,
            Self::Windowless(shown) => shown.draws_interface(),
        }
    }

    /// Does what the interface asks of the system; it wants to be shown again after so long.
    pub fn take_output(&mut self, output: egui::PlatformOutput, repaint: Option<Duration>) {
        match self {
            Self::Window(shown) => shown.egui.handle_platform_output(&shown.window, output),
            Self::Windowless(shown) => shown.take_output(output, repaint),
        }
    }
}

/// The error with advice if no window opens. The system's reason comes without winit's place in its own source.
pub fn no_window(source: &dyn std::fmt::Display) -> Error {
    let text = source.to_string();
    let reason = text
        .split_once(".rs:")
        .and_then(|(_, rest)| rest.split_once(": "));
    let reason = reason
        .map_or(text.as_str(), |(_, reason)| reason)
        .trim_end_matches('.');
    #[cfg(target_os = "linux")]
    let hint = super::wayland::hint();
    #[cfg(not(target_os = "linux"))]
    let hint = String::new();
    Error::Invalid(format!(
        "no window can be opened ({reason}{hint}): where there is no display, `myxo render` draws without one"
    ))
}

/// How large the window is at first: as asked for, in pixels; else as it was last time, and the first time as large on screens
/// of every density; but no larger than the screen.
fn first_size(events: &ActiveEventLoop, asked: Option<[u32; 2]>, kept: [u32; 2]) -> Size {
    if let Some([width, height]) = asked {
        return PhysicalSize::new(width, height).into();
    }
    let monitor = events.primary_monitor();
    let monitor = monitor.or_else(|| events.available_monitors().next());
    let scale = monitor
        .as_ref()
        .map_or(1.0, |monitor| monitor.scale_factor());
    let [width, height] = match kept {
        usual if usual == Preferences::default().size => {
            usual.map(|side| (f64::from(side) * scale).round() as u32)
        }
        kept => kept,
    };
    let screen = monitor.map(|monitor| monitor.size());
    let screen = screen.filter(|size| size.width > 0 && size.height > 0);
    let screen = screen.unwrap_or(PhysicalSize::new(u32::MAX, u32::MAX));
    PhysicalSize::new(width.min(screen.width), height.min(screen.height)).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_display_is_reported_without_a_place_in_library_source() {
        let winit =
            "os error at /home/me/.cargo/winit-0.30/src/linux/mod.rs:765: DISPLAY is not set.";
        let message = no_window(&winit).to_string();
        assert!(
            message.contains("(DISPLAY is not set)") && !message.contains(".rs"),
            "{message}"
        );
        assert!(no_window(&"no memory").to_string().contains("(no memory)"));
    }
}
