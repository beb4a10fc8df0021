//! The Vulkan surface of a window, and its formats and modes.

use std::sync::Arc;

use ash::{khr, vk};
use raw_window_handle::{RawDisplayHandle, RawWindowHandle};

use super::context::Context;
use super::deletion_queue::Deletion;
use super::error::{Check, GpuError, GpuResult};
use super::image::Format;

/// A window's surface; made again when the system takes it away.
pub(crate) struct Surface {
    ctx: Arc<Context>,
    loader: khr::surface::Instance,
    raw: vk::SurfaceKHR,
    display: RawDisplayHandle,
    window: RawWindowHandle,
}

/// The surface's parameters for a swapchain.
pub(crate) struct SurfaceOffer {
    pub(crate) capabilities: vk::SurfaceCapabilitiesKHR,
    pub(crate) format: Format,
    pub(crate) color_space: vk::ColorSpaceKHR,
    pub(crate) has_mailbox: bool,
}

impl Surface {
    /// The surface of a window.
    ///
    /// # Safety
    /// As for [`Swapchain::new`](super::Swapchain::new).
    pub(crate) unsafe fn new(
        ctx: &Arc<Context>,
        display: RawDisplayHandle,
        window: RawWindowHandle,
    ) -> GpuResult<Self> {
        let loader = khr::surface::Instance::new(ctx.entry(), ctx.raw_instance());
        let mut surface = Self {
            ctx: Arc::clone(ctx),
            loader,
            raw: vk::SurfaceKHR::null(),
            display,
            window,
        };
        surface.create()?;
        // SAFETY: surface and physical device are of one instance.
        let shows = unsafe {
            surface.loader.get_physical_device_surface_support(
                ctx.physical_device(),
                ctx.queue_family(),
                surface.raw,
            )
        };
        if shows.check("vkGetPhysicalDeviceSurfaceSupportKHR", "the window")? {
            Ok(surface)
        } else {
            Err(surface.unsupported("a queue that can show pictures in it"))
        }
    }

    /// Makes the surface again, after the system has lost it.
    pub(crate) fn recreate(&mut self) -> GpuResult<()> {
        self.retire();
        self.create()
    }

    pub(crate) fn raw(&self) -> vk::SurfaceKHR {
        self.raw
    }

    pub(crate) fn offer(&self) -> GpuResult<SurfaceOffer> {
        let (physical, raw) = (self.ctx.physical_device(), self.raw);
        // SAFETY: surface and physical device are of one instance; so below.
        let capabilities = unsafe {
            self.loader
                .get_physical_device_surface_capabilities(physical, raw)
        }
        .check("vkGetPhysicalDeviceSurfaceCapabilitiesKHR", "the window")?;
        // SAFETY: as above.
        let formats = unsafe {
            self.loader
                .get_physical_device_surface_formats(physical, raw)
        }
        .check("vkGetPhysicalDeviceSurfaceFormatsKHR", "the window")?;
        // SAFETY: as above.
        let modes = unsafe {
            self.loader
                .get_physical_device_surface_present_modes(physical, raw)
        }
        .check("vkGetPhysicalDeviceSurfacePresentModesKHR", "the window")?;
        // Interfaces blend in gamma space, so images that store what they are given come first.
        let wanted = [
            Format::Bgra8,
            Format::Rgba8,
            Format::Bgra8Srgb,
            Format::Rgba8Srgb,
        ];
        let offered = |format: &Format| {
            formats.iter().find(|f| {
                f.format == format.raw() && f.color_space == vk::ColorSpaceKHR::SRGB_NONLINEAR
            })
        };
        let found = wanted
            .into_iter()
            .find_map(|format| offered(&format).map(|f| (format, f)));
        let Some((format, found)) = found else {
            return Err(self.unsupported("pixels of four bytes in the sRGB colour space"));
        };
        let needed = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_DST;
        if !capabilities.supported_usage_flags.contains(needed) {
            return Err(self.unsupported("images that can be drawn into and copied to"));
        }
        Ok(SurfaceOffer {
            capabilities,
            format,
            color_space: found.color_space,
            has_mailbox: modes.contains(&vk::PresentModeKHR::MAILBOX),
        })
    }

    fn create(&mut self) -> GpuResult<()> {
        // SAFETY: the caller of `new` keeps window and display alive as long as the context.
        let made = unsafe {
            ash_window::create_surface(
                self.ctx.entry(),
                self.ctx.raw_instance(),
                self.display,
                self.window,
                None,
            )
        };
        self.raw = made.check("vkCreateSurfaceKHR", "the window")?;
        Ok(())
    }

    fn unsupported(&self, missing: &str) -> GpuError {
        GpuError::Unsupported {
            what: "the window".to_owned(),
            missing: missing.to_owned(),
            device: self.ctx.info().name.clone(),
        }
    }

    fn retire(&mut self) {
        let raw = std::mem::take(&mut self.raw);
        self.ctx
            .deletion_queue
            .add(Deletion::Surface(self.loader.clone(), raw));
    }
}

impl Drop for Surface {
    fn drop(&mut self) {
        self.retire();
    }
}
