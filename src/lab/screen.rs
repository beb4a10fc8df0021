//! What the lab draws its window with: a device, the window's images on it, and what draws the interface.

use std::sync::Arc;

use myxo::Result;
use myxo::gpu::{Context, ContextOptions, DeviceKind, Format, Frames, Swapchain};
use myxo::render::gui::Gui;
use raw_window_handle::{HasDisplayHandle, HasWindowHandle};
use winit::window::Window;

use super::LabOptions;
use super::window::no_window;

/// A device, and a window on it. Fields are dropped in this order: what lies on the device before the device.
pub struct Screen {
    /// Draws the interface.
    pub gui: Gui,
    /// The window's images.
    pub swapchain: Swapchain,
    /// What steps and pictures are recorded into.
    pub frames: Frames,
    /// For what is shown while steps are under way.
    pub answers: Frames,
    /// The format of pictures.
    pub format: Format,
    /// The device.
    pub ctx: Arc<Context>,
}

impl Screen {
    /// Opens a device for a window, which must outlive it.
    pub fn open(window: &Window, options: &LabOptions) -> Result<Self> {
        let display = window
            .display_handle()
            .map_err(|source| no_window(&source))?
            .as_raw();
        let handle = window
            .window_handle()
            .map_err(|source| no_window(&source))?
            .as_raw();
        let ctx = Context::new(&ContextOptions {
            device: options.device.clone(),
            validation: options.validation,
            window: Some(display),
            cache_folder: myxo::gpu::default_cache_folder(),
            ..ContextOptions::default()
        })?;
        let size: [u32; 2] = window.inner_size().into();
        let swapchain = Swapchain::new(&ctx, display, handle, size, true)?;
        // A device that is the CPU gains nothing from working ahead, and the hand would feel the delay.
        let in_flight = if ctx.info().kind == DeviceKind::Cpu {
            1
        } else {
            2
        };
        let frames = Frames::new(&ctx, in_flight)?;
        let answers = Frames::new(&ctx, 1)?;
        let format = swapchain.format().unwrap_or(Format::Bgra8);
        let gui = Gui::new(&ctx, format, in_flight)?;
        Ok(Self {
            gui,
            swapchain,
            frames,
            answers,
            format: picture_format(format),
            ctx,
        })
    }
}

/// The sRGB format with the same bytes: the picture is drawn in it, and its bytes are copied as they are.
fn picture_format(window: Format) -> Format {
    match window {
        Format::Rgba8 | Format::Rgba8Srgb => Format::Rgba8Srgb,
        _ => Format::Bgra8Srgb,
    }
}
