//! Named images to draw into: colour and depth targets with one view each.

use std::sync::{Arc, Mutex};

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};

use super::context::Context;
use super::deletion_queue::Deletion;
use super::error::{Check, GpuError, GpuResult};

/// The format of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// Four bytes, red first; shaders write linear colours, which are stored as sRGB.
    Rgba8Srgb,
    /// Four bytes, red first, stored as they are.
    Rgba8,
    /// Four bytes, blue first; shaders write linear colours, which are stored as sRGB.
    Bgra8Srgb,
    /// Four bytes, blue first, stored as they are.
    Bgra8,
    /// Four floats.
    Rgba32Float,
    /// One float.
    R32Float,
    /// One whole number; cleared to 0.
    R32Uint,
    /// Depth, 0 to 1.
    Depth32,
}

impl Format {
    pub(crate) fn raw(self) -> vk::Format {
        match self {
            Format::Rgba8Srgb => vk::Format::R8G8B8A8_SRGB,
            Format::Rgba8 => vk::Format::R8G8B8A8_UNORM,
            Format::Bgra8Srgb => vk::Format::B8G8R8A8_SRGB,
            Format::Bgra8 => vk::Format::B8G8R8A8_UNORM,
            Format::Rgba32Float => vk::Format::R32G32B32A32_SFLOAT,
            Format::R32Float => vk::Format::R32_SFLOAT,
            Format::R32Uint => vk::Format::R32_UINT,
            Format::Depth32 => vk::Format::D32_SFLOAT,
        }
    }

    /// The format with equal bytes and without sRGB encoding.
    fn layout(self) -> Self {
        match self {
            Format::Rgba8Srgb => Format::Rgba8,
            Format::Bgra8Srgb => Format::Bgra8,
            other => other,
        }
    }

    /// Have both the same bytes in the same order, so that pixels can be copied as they are?
    #[must_use]
    pub fn matches(self, other: Self) -> bool {
        self.layout() == other.layout()
    }

    /// Bytes of a pixel.
    #[must_use]
    pub fn pixel_size(self) -> usize {
        if self == Format::Rgba32Float { 16 } else { 4 }
    }

    fn is_depth(self) -> bool {
        self == Format::Depth32
    }
}

/// A two-dimensional image with its memory and its view.
pub struct Image {
    ctx: Arc<Context>,
    name: String,
    size: [u32; 2],
    format: Format,
    samples: u32,
    raw: vk::Image,
    view: vk::ImageView,
    /// Taken by `drop` only.
    allocation: Option<Allocation>,
    /// Belongs to a window, which destroys it.
    foreign: bool,
    state: Arc<Mutex<ImageState>>,
}

/// A change of an image's state, which is taken back if it was recorded and never happens.
pub(crate) struct Transition {
    state: Arc<Mutex<ImageState>>,
    before: ImageState,
    /// The slice of the recording that it is in.
    pub(crate) slice: usize,
}

impl Transition {
    pub(crate) fn take_back(&self) {
        *self.state.lock().unwrap_or_else(|e| e.into_inner()) = self.before;
    }
}

/// The last use of an image.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ImageState {
    pub(crate) layout: vk::ImageLayout,
    pub(crate) stage: vk::PipelineStageFlags,
    pub(crate) access: vk::AccessFlags,
}

impl ImageState {
    const UNUSED: Self = Self {
        layout: vk::ImageLayout::UNDEFINED,
        stage: vk::PipelineStageFlags::TOP_OF_PIPE,
        access: vk::AccessFlags::empty(),
    };
    pub(crate) const COLOR_TARGET: Self = Self {
        layout: vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL,
        stage: vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT,
        access: vk::AccessFlags::from_raw(
            vk::AccessFlags::COLOR_ATTACHMENT_READ.as_raw()
                | vk::AccessFlags::COLOR_ATTACHMENT_WRITE.as_raw(),
        ),
    };
    pub(crate) const DEPTH_TARGET: Self = Self {
        layout: vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
        stage: vk::PipelineStageFlags::from_raw(
            vk::PipelineStageFlags::EARLY_FRAGMENT_TESTS.as_raw()
                | vk::PipelineStageFlags::LATE_FRAGMENT_TESTS.as_raw(),
        ),
        access: vk::AccessFlags::from_raw(
            vk::AccessFlags::DEPTH_STENCIL_ATTACHMENT_READ.as_raw()
                | vk::AccessFlags::DEPTH_STENCIL_ATTACHMENT_WRITE.as_raw(),
        ),
    };
    pub(crate) const COPY_TARGET: Self = Self {
        layout: vk::ImageLayout::TRANSFER_DST_OPTIMAL,
        stage: vk::PipelineStageFlags::TRANSFER,
        access: vk::AccessFlags::TRANSFER_WRITE,
    };
    /// Presented. The next use waits for the image at these stages.
    pub(crate) const SHOWN: Self = Self {
        layout: vk::ImageLayout::PRESENT_SRC_KHR,
        stage: vk::PipelineStageFlags::from_raw(
            vk::PipelineStageFlags::COLOR_ATTACHMENT_OUTPUT.as_raw()
                | vk::PipelineStageFlags::TRANSFER.as_raw(),
        ),
        access: vk::AccessFlags::empty(),
    };
    /// Kernels sample it.
    pub(crate) const SAMPLED: Self = Self {
        layout: vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
        stage: vk::PipelineStageFlags::COMPUTE_SHADER,
        access: vk::AccessFlags::SHADER_READ,
    };
    pub(crate) const COPY_SOURCE: Self = Self {
        layout: vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
        stage: vk::PipelineStageFlags::TRANSFER,
        access: vk::AccessFlags::TRANSFER_READ,
    };
}

impl Image {
    /// A colour or depth target, by its format; `samples` is 1, 2, 4 or 8. Its pixels are undefined until a pass
    /// clears or draws them.
    ///
    /// # Errors
    /// A side or a number of samples that the device does not have, or no memory.
    pub fn new(
        ctx: &Arc<Context>,
        name: &str,
        size: [u32; 2],
        format: Format,
        samples: u32,
    ) -> GpuResult<Self> {
        let usage = match (format.is_depth(), samples) {
            (true, _) => vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT,
            (false, 1) => {
                vk::ImageUsageFlags::COLOR_ATTACHMENT
                    | vk::ImageUsageFlags::TRANSFER_SRC
                    | vk::ImageUsageFlags::TRANSFER_DST
            }
            (false, _) => vk::ImageUsageFlags::COLOR_ATTACHMENT,
        };
        Self::with_usage(ctx, name, size, format, samples, usage)
    }

    /// An image with these usages.
    pub(crate) fn with_usage(
        ctx: &Arc<Context>,
        name: &str,
        size: [u32; 2],
        format: Format,
        samples: u32,
        usage: vk::ImageUsageFlags,
    ) -> GpuResult<Self> {
        let info = ctx.info();
        let unsupported = |missing: String| GpuError::Unsupported {
            what: format!("the image {name:?} of {} x {} pixels", size[0], size[1]),
            missing,
            device: info.name.clone(),
        };
        if size
            .iter()
            .any(|&side| side == 0 || side > info.max_image_side)
        {
            return Err(unsupported(format!(
                "sides of that length (it has 1 to {})",
                info.max_image_side
            )));
        }
        if !samples.is_power_of_two() || samples > info.max_samples {
            return Err(unsupported(format!(
                "{samples} samples (it has up to {})",
                info.max_samples
            )));
        }
        let create = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(format.raw())
            .extent(vk::Extent3D {
                width: size[0],
                height: size[1],
                depth: 1,
            })
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::from_raw(samples))
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(usage);
        let device = &ctx.device.raw;
        // SAFETY: the device is alive; so below.
        let raw = unsafe { device.create_image(&create, None) }.check("vkCreateImage", name)?;
        let mut image = Self {
            ctx: Arc::clone(ctx),
            name: name.to_owned(),
            size,
            format,
            samples,
            raw,
            view: vk::ImageView::null(),
            allocation: None,
            foreign: false,
            state: Arc::new(Mutex::new(ImageState::UNUSED)),
        };
        ctx.device.set_name(raw, name);
        // SAFETY: `raw` was made just now.
        let requirements = unsafe { device.get_image_memory_requirements(raw) };
        let description = AllocationCreateDesc {
            name,
            requirements,
            location: MemoryLocation::GpuOnly,
            linear: false,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        };
        let allocation = ctx.lock_allocator().allocate(&description);
        let allocation = allocation.map_err(|source| GpuError::OutOfMemory {
            object: name.to_owned(),
            size: requirements.size,
            source,
        })?;
        let (memory, offset) = {
            let allocation = image.allocation.insert(allocation);
            // SAFETY: the memory is not freed before the allocation is.
            (unsafe { allocation.memory() }, allocation.offset())
        };
        // SAFETY: the allocation fits the image's requirements and is used by nothing else.
        unsafe { device.bind_image_memory(raw, memory, offset) }
            .check("vkBindImageMemory", name)?;
        image.add_view()?;
        Ok(image)
    }

    /// An image of a window.
    pub(crate) fn foreign(
        ctx: &Arc<Context>,
        name: &str,
        raw: vk::Image,
        size: [u32; 2],
        format: Format,
    ) -> GpuResult<Self> {
        let mut image = Self {
            ctx: Arc::clone(ctx),
            name: name.to_owned(),
            size,
            format,
            samples: 1,
            raw,
            view: vk::ImageView::null(),
            allocation: None,
            foreign: true,
            state: Arc::new(Mutex::new(ImageState {
                layout: vk::ImageLayout::UNDEFINED,
                ..ImageState::SHOWN
            })),
        };
        image.add_view()?;
        Ok(image)
    }

    fn add_view(&mut self) -> GpuResult<()> {
        let info = vk::ImageViewCreateInfo::default()
            .image(self.raw)
            .view_type(vk::ImageViewType::TYPE_2D)
            .format(self.format.raw())
            .subresource_range(self.range());
        // SAFETY: the image is alive and has memory.
        self.view = unsafe { self.ctx.device.raw.create_image_view(&info, None) }
            .check("vkCreateImageView", &self.name)?;
        Ok(())
    }

    /// The name it was made with.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Width and height in pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The format of a pixel.
    #[must_use]
    pub fn format(&self) -> Format {
        self.format
    }

    /// Samples of a pixel.
    #[must_use]
    pub fn samples(&self) -> u32 {
        self.samples
    }

    pub(crate) fn raw(&self) -> vk::Image {
        self.raw
    }

    pub(crate) fn view(&self) -> vk::ImageView {
        self.view
    }

    pub(crate) fn ctx(&self) -> &Arc<Context> {
        &self.ctx
    }

    /// Panics unless it was made in this context.
    pub(crate) fn assert_of(&self, ctx: &Context) {
        assert!(
            std::ptr::eq(Arc::as_ptr(&self.ctx), ctx),
            "`{}` belongs to another context",
            self.name
        );
    }

    pub(crate) fn range(&self) -> vk::ImageSubresourceRange {
        let aspect = if self.format.is_depth() {
            vk::ImageAspectFlags::DEPTH
        } else {
            vk::ImageAspectFlags::COLOR
        };
        vk::ImageSubresourceRange::default()
            .aspect_mask(aspect)
            .level_count(1)
            .layer_count(1)
    }

    /// The state until now, which `next` follows, in a slice of a recording.
    pub(crate) fn exchange_state(
        &self,
        next: ImageState,
        slice: usize,
    ) -> (ImageState, Transition) {
        let mut state = self.state.lock().unwrap_or_else(|e| e.into_inner());
        let before = std::mem::replace(&mut *state, next);
        let transition = Transition {
            state: Arc::clone(&self.state),
            before,
            slice,
        };
        (before, transition)
    }
}

impl Format {
    /// Can the device blend what is drawn into such images?
    #[must_use]
    pub fn blends(self, ctx: &Context) -> bool {
        self.has(ctx, vk::FormatFeatureFlags::COLOR_ATTACHMENT_BLEND)
    }

    pub(crate) fn has(self, ctx: &Context, features: vk::FormatFeatureFlags) -> bool {
        let instance = &ctx.device.instance.raw;
        // SAFETY: the physical device is from this instance.
        let all = unsafe {
            instance.get_physical_device_format_properties(ctx.info().physical, self.raw())
        };
        all.optimal_tiling_features.contains(features)
    }
}

impl std::fmt::Debug for Image {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [width, height] = self.size;
        write!(
            f,
            "Image({:?}, {width} x {height} {:?}, {} samples)",
            self.name, self.format, self.samples
        )
    }
}

impl Drop for Image {
    fn drop(&mut self) {
        let raw = if self.foreign {
            vk::Image::null()
        } else {
            self.raw
        };
        self.ctx
            .deletion_queue
            .add(Deletion::Image(self.view, raw, self.allocation.take()));
    }
}
