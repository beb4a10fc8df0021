//! The lab's means of drawing: a device, the images that are shown, and the painter of the interface.

use std::sync::Arc;

use myxo::Result;
use myxo::gpu::{
    Context, ContextOptions, DeviceKind, Format, Frames, GpuResult, Image, Recorder, Swapchain,
    WindowImage,
};
use myxo::render::gui::Gui;

use crate::lab::host::Host;
use crate::lab::options::LabOptions;

/// A device, and a window on it. Fields are dropped in this order: what lies on the device before the device.
pub struct Screen {
    /// Draws the interface.
    pub gui: Gui,
    /// The images that are shown.
    pub front: Front,
    /// Frames into which steps and pictures are recorded.
    pub frames: Frames,
    /// For what is shown while steps are under way.
    pub answers: Frames,
    /// The format of pictures.
    pub format: Format,
    /// The device.
    pub ctx: Arc<Context>,
}

impl Screen {
    /// Opens a device for a window, which must outlive it: the lab drops its host last, after it has closed.
    pub fn open(host: &Host, options: &LabOptions) -> Result<Self> {
        let handles = host.handles()?;
        let ctx = Context::new(&ContextOptions {
            device: options.device.clone(),
            validation: options.validation,
            window: handles.map(|(display, _)| display),
            cache_folder: myxo::gpu::default_cache_folder(),
            ..ContextOptions::default()
        })?;
        let size = host.size();
        let front = match handles {
            Some((display, window)) => {
                // SAFETY: the handles are of one window, which lives as long as the host, and its display longer. The lab drops the
                // host after all that has the device, and waits for the threads that have it; after a loss it does so for a while,
                // and then the program ends.
                let swapchain = unsafe { Swapchain::new(&ctx, display, window, size, true) }?;
                Front::Window(Box::new(swapchain))
            }
            None => Front::Unseen(Unseen::new(&ctx, size)),
        };
        // A device that is the CPU gains nothing from working ahead, and the user would notice the delay.
        let in_flight = if ctx.info().kind == DeviceKind::Cpu {
            1
        } else {
            2
        };
        let frames = Frames::new(&ctx, in_flight)?;
        let answers = Frames::new(&ctx, 1)?;
        let format = front.format();
        let gui = Gui::new(&ctx, format, in_flight)?;
        Ok(Self {
            gui,
            front,
            frames,
            answers,
            format: picture_format(format),
            ctx,
        })
    }
}

/// The sRGB format with equal bytes: the picture is drawn in it, and its bytes are copied unchanged.
fn picture_format(window: Format) -> Format {
    match window {
        Format::Rgba8 | Format::Rgba8Srgb => Format::Rgba8Srgb,
        _ => Format::Bgra8Srgb,
    }
}

/// The images that frames end in.
pub enum Front {
    /// A window's.
    Window(Box<Swapchain>),
    /// One of as many pixels that is never shown.
    Unseen(Unseen),
}

/// The image that a frame draws into.
#[must_use = "an image that was acquired has to be presented"]
pub enum FrontImage {
    Window(WindowImage),
    Unseen(Arc<Image>),
}

/// Stands for the images of a window.
pub struct Unseen {
    ctx: Arc<Context>,
    size: [u32; 2],
    image: Option<Arc<Image>>,
}

impl Unseen {
    /// As most systems have it.
    const FORMAT: Format = Format::Bgra8;

    fn new(ctx: &Arc<Context>, size: [u32; 2]) -> Self {
        Self {
            ctx: Arc::clone(ctx),
            size,
            image: None,
        }
    }

    /// None if the window has no size.
    fn image(&mut self) -> GpuResult<Option<Arc<Image>>> {
        if self.size.contains(&0) {
            return Ok(None);
        }
        let fits = |image: &Arc<Image>| image.size() == self.size;
        if !self.image.as_ref().is_some_and(fits) {
            let image = Image::new(&self.ctx, "window", self.size, Self::FORMAT, 1)?;
            self.image = Some(Arc::new(image));
        }
        Ok(self.image.clone())
    }
}

impl Front {
    /// The format of their pixels.
    fn format(&self) -> Format {
        match self {
            Self::Window(swapchain) => swapchain.format().unwrap_or(Format::Bgra8),
            Self::Unseen(_) => Unseen::FORMAT,
        }
    }

    /// The window has this size now.
    pub fn resize(&mut self, size: [u32; 2]) {
        match self {
            Self::Window(swapchain) => swapchain.resize(size),
            Self::Unseen(unseen) => unseen.size = size,
        }
    }

    /// The next one; `None` skips the frame.
    pub fn acquire(&mut self) -> GpuResult<Option<FrontImage>> {
        Ok(match self {
            Self::Window(swapchain) => swapchain.acquire()?.map(FrontImage::Window),
            Self::Unseen(unseen) => unseen.image()?.map(FrontImage::Unseen),
        })
    }

    /// The image to draw into.
    pub fn image<'a>(&'a self, image: &'a FrontImage) -> &'a Image {
        match (self, image) {
            (Self::Window(swapchain), FrontImage::Window(image)) => swapchain.image(image),
            (_, FrontImage::Unseen(image)) => image,
            (Self::Unseen(_), FrontImage::Window(_)) => {
                unreachable!("a window's image comes from a window")
            }
        }
    }

    /// Was a picture not shown, since this was last asked?
    pub fn take_missed(&mut self) -> bool {
        match self {
            Self::Window(swapchain) => swapchain.take_missed(),
            Self::Unseen(_) => false,
        }
    }

    /// Submits the frame that drew into the image, and shows it.
    pub fn present(
        &mut self,
        frames: &mut Frames,
        rec: Recorder,
        image: FrontImage,
    ) -> GpuResult<()> {
        match (self, image) {
            (Self::Window(swapchain), FrontImage::Window(image)) => {
                swapchain.present(frames, rec, image)
            }
            _ => frames.submit(rec),
        }
    }
}
