//! Images that kernels sample: filled by a copy, read by `texelFetch` or, between texel centres, by the device's own
//! bilinear sampler. The shader declares `sampler2D`.

use std::sync::Arc;

use ash::vk;

use super::context::Context;
use super::deletion_queue::Deletion;
use super::error::{Check, GpuError, GpuResult};
use super::image::{Format, Image, ImageState};

/// An image of single floats with a sampler: bilinear, clamped to its edges. It has to be filled before it is bound.
pub struct Sampled {
    image: Image,
    sampler: vk::Sampler,
}

impl Sampled {
    /// An image of this size, whose pixels are undefined.
    ///
    /// # Errors
    /// A side that the device does not have, no bilinear sampling of floats, or no memory.
    pub fn new(ctx: &Arc<Context>, name: &str, size: [u32; 2]) -> GpuResult<Self> {
        let format = Format::R32Float;
        if !format.has(ctx, vk::FormatFeatureFlags::SAMPLED_IMAGE_FILTER_LINEAR) {
            return Err(GpuError::Unsupported {
                what: format!("the image {name:?}"),
                missing: "bilinear sampling of 32-bit floats".to_owned(),
                device: ctx.info().name.clone(),
            });
        }
        let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
        let image = Image::with_usage(ctx, name, size, format, 1, usage)?;
        let info = vk::SamplerCreateInfo::default()
            .mag_filter(vk::Filter::LINEAR)
            .min_filter(vk::Filter::LINEAR)
            .address_mode_u(vk::SamplerAddressMode::CLAMP_TO_EDGE)
            .address_mode_v(vk::SamplerAddressMode::CLAMP_TO_EDGE)
            .address_mode_w(vk::SamplerAddressMode::CLAMP_TO_EDGE);
        // SAFETY: the device is alive.
        let sampler =
            unsafe { ctx.device.raw.create_sampler(&info, None) }.check("vkCreateSampler", name)?;
        Ok(Self { image, sampler })
    }

    /// The image itself.
    #[must_use]
    pub fn image(&self) -> &Image {
        &self.image
    }

    pub(crate) fn descriptor(&self) -> vk::DescriptorImageInfo {
        vk::DescriptorImageInfo::default()
            .image_layout(ImageState::SAMPLED.layout)
            .image_view(self.image.view())
            .sampler(self.sampler)
    }
}

impl Drop for Sampled {
    fn drop(&mut self) {
        let deletion = Deletion::Sampler(self.sampler);
        self.image.ctx().deletion_queue.add(deletion);
    }
}
