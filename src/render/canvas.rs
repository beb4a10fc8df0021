//! The images that pictures are drawn into.

use std::sync::Arc;

use super::develop::{Darkroom, Shape};
use crate::gpu::{Context, Format, GpuError, Image};

/// Samples a pixel, where the device has them.
const SAMPLES: u32 = 4;

/// The images that a picture is drawn into.
pub struct Canvas {
    /// The render target; several samples per pixel, if the device has them.
    pub(super) color: Image,
    /// One sample a pixel, if `color` has more.
    pub(super) resolved: Option<Image>,
    pub(super) depth: Image,
    /// Takes what was drawn, and gives the finished picture; none if the device has no buffers of so many pixels.
    pub(super) darkroom: Option<Darkroom>,
}

impl Canvas {
    /// Images of `size` pixels, each side at least 1, with smooth edges if the device has several samples per pixel.
    ///
    /// # Errors
    /// When the device has no images of that size, or no memory for them.
    pub fn new(ctx: &Arc<Context>, size: [u32; 2], format: Format) -> Result<Self, GpuError> {
        Self::with_quality(ctx, size, format, Quality::Smooth)
    }

    /// As [`new`](Self::new), with a given quality.
    ///
    /// # Errors
    /// As for [`Canvas::new`].
    pub fn with_quality(
        ctx: &Arc<Context>,
        size: [u32; 2],
        format: Format,
        quality: Quality,
    ) -> Result<Self, GpuError> {
        let samples = quality.samples(ctx);
        let resolved = match samples {
            1 => None,
            _ => Some(Image::new(ctx, "picture.resolved", size, format, 1)?),
        };
        let darkroom = match Darkroom::new(ctx, size, format, samples == 1) {
            Ok(darkroom) => Some(darkroom),
            Err(GpuError::Unsupported { .. } | GpuError::TooLarge { .. }) => None,
            Err(error) => return Err(error),
        };
        Ok(Self {
            darkroom,
            color: Image::new(ctx, "picture.color", size, format, samples)?,
            depth: Image::new(ctx, "picture.depth", size, Format::Depth32, samples)?,
            resolved,
        })
    }

    /// Bytes that a smooth canvas of this size takes on the device.
    pub(super) fn smooth_bytes(size: [u32; 2]) -> u64 {
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        // Four a sample, of colour and of depth; and four a pixel, resolved and developed.
        let images = pixels * (2 * 4 * u64::from(SAMPLES) + 2 * 4);
        images + Shape::of(size).map_or(0, |shape| Darkroom::buffer_bytes(&shape))
    }

    /// Width and height, pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.color.size()
    }

    /// The finished picture, one sample a pixel.
    #[must_use]
    pub fn image(&self) -> &Image {
        match &self.darkroom {
            Some(darkroom) => &darkroom.image,
            None => self.drawn(),
        }
    }

    /// What was drawn, before its development.
    pub(super) fn drawn(&self) -> &Image {
        self.resolved.as_ref().unwrap_or(&self.color)
    }

    /// A remark if pictures of this size are not developed, because the device has no buffers of so many pixels.
    #[must_use]
    pub fn warning(&self) -> Option<String> {
        let [width, height] = self.size();
        self.darkroom.is_none().then(|| {
            format!("pictures of {width} x {height} have no bloom on this device: it has no buffers of so many pixels")
        })
    }
}

/// The quality of a picture. On a device that is a CPU, smooth edges take about four times as long; quick pictures may use shared vertices
/// there, and show trails slightly softer from near.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quality {
    /// One sample a pixel.
    Quick,
    /// Four, or as many as the device has.
    Smooth,
}

impl Quality {
    pub(super) fn samples(self, ctx: &Context) -> u32 {
        match self {
            Self::Quick => 1,
            Self::Smooth => SAMPLES.min(ctx.info().max_samples),
        }
    }
}
