//! Pictures in a window.
//!
//! A frame asks for an image, draws into it like into any other, and gives it back to be shown. Without an image (a
//! minimised window, a size that changes at this moment) the frame is skipped.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use ash::{khr, vk};
use raw_window_handle::{RawDisplayHandle, RawWindowHandle};

use super::context::Context;
use super::deletion_queue::Deletion;
use super::error::{Check, GpuResult};
use super::frame::Frames;
use super::image::{Format, Image, ImageState};
use super::recorder::Recorder;
use super::window_surface::Surface;

/// How long to wait for an image before the frame is skipped, nanoseconds.
const PATIENCE: u64 = 1_000_000_000;

/// The images of a window.
pub struct Swapchain {
    ctx: Arc<Context>,
    loader: khr::swapchain::Device,
    raw: vk::SwapchainKHR,
    images: Vec<Image>,
    /// The number of the images: those of each window, and those made later, have another one.
    generation: u64,
    /// Signalled when an image may be drawn into, used in turns.
    acquired: Vec<Semaphore>,
    turn: usize,
    /// Signalled when an image has been drawn, one an image.
    drawn: Vec<Semaphore>,
    wanted_size: [u32; 2],
    vsync: bool,
    /// Something has changed: make the images again before the next frame.
    stale: bool,
    /// A picture was not shown.
    has_missed: bool,
    /// Dropped last: the images belong to it.
    surface: Surface,
}

/// An image of the window, to be drawn into and shown by [`Swapchain::present`].
#[derive(Debug)]
#[must_use = "an image that was acquired has to be presented"]
pub struct WindowImage {
    index: usize,
    acquired: vk::Semaphore,
    /// That of the images that it is one of.
    generation: u64,
}

impl Swapchain {
    /// Opens the window's images; the context must have been made with its display. `size` is the window's in pixels.
    /// With `vsync` a picture is shown at the display's pace, otherwise the newest is, where the device can.
    ///
    /// # Errors
    /// The device cannot show pictures in this window.
    ///
    /// # Safety
    /// The handles must be valid, and the window must be of the display. Both must live until the context is dropped, which may be the
    /// last to use them.
    pub unsafe fn new(
        ctx: &Arc<Context>,
        display: RawDisplayHandle,
        window: RawWindowHandle,
        size: [u32; 2],
        vsync: bool,
    ) -> GpuResult<Self> {
        // SAFETY: the caller's.
        let surface = unsafe { Surface::new(ctx, display, window) }?;
        let mut swapchain = Self {
            ctx: Arc::clone(ctx),
            loader: khr::swapchain::Device::new(ctx.raw_instance(), ctx.raw_device()),
            raw: vk::SwapchainKHR::null(),
            images: Vec::new(),
            generation: next_generation(),
            acquired: Vec::new(),
            turn: 0,
            drawn: Vec::new(),
            wanted_size: size,
            vsync,
            stale: true,
            has_missed: false,
            surface,
        };
        swapchain.recreate()?;
        Ok(swapchain)
    }

    /// Sets the present size of the window. Call it on every resize event, because not every system reports the size otherwise.
    pub fn resize(&mut self, size: [u32; 2]) {
        if size != self.wanted_size {
            self.wanted_size = size;
            self.stale = true;
        }
    }

    /// Changes the pace of presentation.
    pub fn set_vsync(&mut self, vsync: bool) {
        self.stale |= vsync != self.vsync;
        self.vsync = vsync;
    }

    /// The format of the images; it may change when the window moves to another screen.
    #[must_use]
    pub fn format(&self) -> Option<Format> {
        self.images.first().map(Image::format)
    }

    /// The next image; `None` skips the frame: the window has no size, or it changes just now.
    ///
    /// # Errors
    /// The device was lost, or the window can no longer be drawn into.
    pub fn acquire(&mut self) -> GpuResult<Option<WindowImage>> {
        // Out of date is answered once by new images; a second time the window is still changing.
        for _ in 0..2 {
            if self.stale {
                self.recreate()?;
            }
            if self.raw == vk::SwapchainKHR::null() {
                return Ok(None);
            }
            let semaphore = self.acquired[self.turn].raw;
            // SAFETY: the semaphore's last use was more frames ago than can be in flight.
            let next = unsafe {
                self.loader
                    .acquire_next_image(self.raw, PATIENCE, semaphore, vk::Fence::null())
            };
            match next {
                Ok((index, suboptimal)) => {
                    self.turn = (self.turn + 1) % self.acquired.len();
                    self.stale = suboptimal;
                    return Ok(Some(WindowImage {
                        index: index as usize,
                        acquired: semaphore,
                        generation: self.generation,
                    }));
                }
                Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => self.stale = true,
                Err(vk::Result::ERROR_SURFACE_LOST_KHR) => self.lose_surface()?,
                Err(vk::Result::TIMEOUT | vk::Result::NOT_READY) => return Ok(None),
                Err(error) => self
                    .ctx
                    .heard(Err(error))
                    .check("vkAcquireNextImageKHR", "the window")?,
            }
        }
        Ok(None)
    }

    /// The image to draw into. Its pixels are undefined until a pass clears it or a picture is copied to it.
    ///
    /// # Panics
    /// If the window's images were made again since it was acquired, or it is of another window.
    #[must_use]
    pub fn image(&self, image: &WindowImage) -> &Image {
        assert!(
            image.generation == self.generation,
            "the window's images were made again since this one was acquired, or it is of another window"
        );
        &self.images[image.index]
    }

    /// Was a picture not shown because the window changed, since this was last asked?
    pub fn take_missed(&mut self) -> bool {
        std::mem::take(&mut self.has_missed)
    }

    /// Submits the frame that drew into the image, and shows it.
    ///
    /// # Errors
    /// The device was lost, or the window can no longer be drawn into.
    ///
    /// # Panics
    /// As [`Swapchain::image`].
    pub fn present(
        &mut self,
        frames: &mut Frames,
        mut rec: Recorder,
        image: WindowImage,
    ) -> GpuResult<()> {
        rec.transition(self.image(&image), ImageState::SHOWN, true);
        let drawn = [self.drawn[image.index].raw];
        // Whatever first touches the image waits: a pass, or a copy.
        let stages =
            vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT | vk::PipelineStageFlags::TRANSFER;
        frames.submit_with(rec, &[(image.acquired, stages)], &drawn)?;
        let (swapchains, indices) = ([self.raw], [image.index as u32]);
        let info = vk::PresentInfoKHR::default()
            .wait_semaphores(&drawn)
            .swapchains(&swapchains)
            .image_indices(&indices);
        // SAFETY: the image was acquired from this swapchain and is presented once.
        match unsafe { self.loader.queue_present(*self.ctx.queue(), &info) } {
            Ok(suboptimal) => self.stale |= suboptimal,
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => {
                self.stale = true;
                self.has_missed = true;
            }
            Err(vk::Result::ERROR_SURFACE_LOST_KHR) => {
                self.has_missed = true;
                self.lose_surface()?;
            }
            Err(error) => self
                .ctx
                .heard(Err(error))
                .check("vkQueuePresentKHR", "the window")?,
        }
        Ok(())
    }

    fn lose_surface(&mut self) -> GpuResult<()> {
        self.retire();
        self.stale = true;
        self.surface.recreate()
    }

    /// Makes the images for the size that the window has now; none for a window without a size.
    fn recreate(&mut self) -> GpuResult<()> {
        const WHAT: &str = "the window";
        // Presentation is not in any fence, so this waits for everything; it happens when the window changes only.
        self.ctx.wait_idle()?;
        let offer = self.surface.offer()?;
        let capabilities = &offer.capabilities;
        let [width, height] = if capabilities.current_extent.width == u32::MAX {
            let (least, most) = (capabilities.min_image_extent, capabilities.max_image_extent);
            let [width, height] = self.wanted_size;
            [
                width.clamp(least.width, most.width),
                height.clamp(least.height, most.height),
            ]
        } else {
            [
                capabilities.current_extent.width,
                capabilities.current_extent.height,
            ]
        };
        if width == 0 || height == 0 || self.wanted_size.contains(&0) {
            // Stays stale: the window may come back at any time.
            self.retire();
            return Ok(());
        }
        let most = if capabilities.max_image_count == 0 {
            u32::MAX
        } else {
            capabilities.max_image_count
        };
        let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT
            | vk::ImageUsageFlags::TRANSFER_DST
            | (vk::ImageUsageFlags::TRANSFER_SRC & capabilities.supported_usage_flags);
        let alpha = [
            vk::CompositeAlphaFlagsKHR::OPAQUE,
            vk::CompositeAlphaFlagsKHR::INHERIT,
        ]
        .into_iter()
        .find(|flag| capabilities.supported_composite_alpha.contains(*flag))
        .unwrap_or(vk::CompositeAlphaFlagsKHR::PRE_MULTIPLIED);
        let mode = if self.vsync || !offer.has_mailbox {
            vk::PresentModeKHR::FIFO
        } else {
            vk::PresentModeKHR::MAILBOX
        };
        let old = std::mem::take(&mut self.raw);
        let info = vk::SwapchainCreateInfoKHR::default()
            .surface(self.surface.raw())
            .min_image_count((capabilities.min_image_count + 1).clamp(2, most))
            .image_format(offer.format.raw())
            .image_color_space(offer.color_space)
            .image_extent(vk::Extent2D { width, height })
            .image_array_layers(1)
            .image_usage(usage)
            .pre_transform(capabilities.current_transform)
            .composite_alpha(alpha)
            .present_mode(mode)
            .clipped(true)
            .old_swapchain(old);
        // SAFETY: the surface is alive and `old` is this surface's, or null.
        let made = unsafe { self.loader.create_swapchain(&info, None) };
        // The old one is retired in any case.
        self.raw = old;
        self.retire();
        self.raw = made.check("vkCreateSwapchainKHR", WHAT)?;
        // SAFETY: made just now.
        let raw_images = unsafe { self.loader.get_swapchain_images(self.raw) }
            .check("vkGetSwapchainImagesKHR", WHAT)?;
        for raw in raw_images {
            self.images.push(Image::foreign(
                &self.ctx,
                "window",
                raw,
                [width, height],
                offer.format,
            )?);
            self.drawn.push(Semaphore::new(&self.ctx, "window.drawn")?);
        }
        // As many as frames can wait for, and one more.
        while self.acquired.len() < self.images.len() + 2 {
            self.acquired
                .push(Semaphore::new(&self.ctx, "window.acquired")?);
        }
        self.stale = false;
        Ok(())
    }

    /// Gives up the images.
    fn retire(&mut self) {
        self.images.clear();
        self.generation = next_generation();
        self.drawn.clear();
        // An acquired image that was never presented leaves its semaphore signalled: begin with fresh ones.
        self.acquired.clear();
        self.turn = 0;
        let raw = std::mem::take(&mut self.raw);
        if raw != vk::SwapchainKHR::null() {
            self.ctx
                .deletion_queue
                .add(Deletion::Swapchain(self.loader.clone(), raw));
        }
    }
}

impl Drop for Swapchain {
    fn drop(&mut self) {
        self.retire();
    }
}

/// A number that no images have had.
fn next_generation() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    NEXT.fetch_add(1, Ordering::Relaxed)
}

struct Semaphore {
    ctx: Arc<Context>,
    raw: vk::Semaphore,
}

impl Semaphore {
    fn new(ctx: &Arc<Context>, name: &str) -> GpuResult<Self> {
        // SAFETY: the device is alive.
        let raw = unsafe {
            ctx.raw_device()
                .create_semaphore(&vk::SemaphoreCreateInfo::default(), None)
        }
        .check("vkCreateSemaphore", name)?;
        ctx.device.set_name(raw, name);
        Ok(Self {
            ctx: Arc::clone(ctx),
            raw,
        })
    }
}

impl Drop for Semaphore {
    fn drop(&mut self) {
        self.ctx.deletion_queue.add(Deletion::Semaphore(self.raw));
    }
}
