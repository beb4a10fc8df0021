//! Pictures without a window: a canvas and the readback of its pixels.

use std::sync::Arc;

use image::RgbaImage;

use super::camera::Camera;
use super::colormap::{linear_from_srgb, srgb_from_linear};
use super::exposure::Exposure;
use super::mean;
use super::renderer::{Canvas, Quality};
use super::view::View;
use crate::error::Error;
use crate::gpu::{Buffer, Context, Domain, Format, GpuError, Recorder};
use crate::sim::memory;

/// The format of offscreen pictures: red first, as files have it, and sRGB.
pub const FORMAT: Format = Format::Rgba8Srgb;

/// Divides the light of a picture with a transparent background by its alpha, as files have it. Pixels without alpha have no colour.
pub fn unmultiply(picture: &mut RgbaImage) {
    for pixel in picture.pixels_mut() {
        match pixel.0 {
            [.., 0] => pixel.0 = [0; 4],
            [.., 255] => {}
            [.., alpha] => {
                let alpha = f32::from(alpha) / 255.0;
                for channel in &mut pixel.0[..3] {
                    let light = linear_from_srgb(f32::from(*channel) / 255.0) / alpha;
                    *channel = (255.0 * srgb_from_linear(light)).round() as u8;
                }
            }
        }
    }
}

/// The error for a picture that the device cannot hold, with advice: `option` is what says its size.
#[must_use]
pub fn too_large([width, height]: [u32; 2], option: &str, error: GpuError) -> Error {
    match error {
        GpuError::OutOfMemory { object, size, .. } => Error::Invalid(format!(
            "the device has no room for a picture of {width} x {height} ({object} alone takes {}): use a smaller {option}",
            memory::human(size)
        )),
        error @ GpuError::TooLarge { .. } => Error::Invalid(format!(
            "a picture of {width} x {height} is too large: {error}: use a smaller {option}"
        )),
        error => Error::Gpu(error),
    }
}

/// The views of the pictures of a mean, of `size` pixels, one for each camera: each a part of a pixel beside the others. The first one
/// chooses the exposure, and the others have the same.
pub fn passes(
    mut view: View,
    cameras: impl IntoIterator<Item = Camera>,
    size: [u32; 2],
) -> impl Iterator<Item = View> {
    (0..).zip(cameras).map(move |(number, camera)| {
        view.camera = mean::within_pixel(&camera, size, number);
        if number > 0
            && let Exposure::Auto { adaptation, .. } = &mut view.exposure
        {
            *adaptation = 0.0;
        }
        view
    })
}

/// A canvas whose picture can be read.
pub struct Offscreen {
    canvas: Canvas,
    pixels: Buffer<[u8; 4]>,
}

impl Offscreen {
    /// A canvas of `size` pixels, each side at least 1, for smooth pictures.
    ///
    /// # Errors
    /// When the device has no images of that size, or no memory for them.
    pub fn new(ctx: &Arc<Context>, size: [u32; 2]) -> Result<Self, GpuError> {
        Self::with_quality(ctx, size, Quality::Smooth)
    }

    /// About how many bytes a smooth one of this size takes on the device.
    #[must_use]
    pub fn bytes(size: [u32; 2]) -> u64 {
        Canvas::smooth_bytes(size) + 4 * u64::from(size[0]) * u64::from(size[1])
    }

    /// As [`new`](Self::new), with a given quality.
    ///
    /// # Errors
    /// As for [`Offscreen::new`].
    pub fn with_quality(
        ctx: &Arc<Context>,
        size: [u32; 2],
        quality: Quality,
    ) -> Result<Self, GpuError> {
        let canvas = Canvas::with_quality(ctx, size, FORMAT, quality)?;
        let pixel_count = size[0] as usize * size[1] as usize;
        let pixels = Buffer::new(ctx, "picture.pixels", pixel_count, Domain::Readback)?;
        Ok(Self { canvas, pixels })
    }

    /// The canvas to draw on.
    #[must_use]
    pub fn canvas(&self) -> &Canvas {
        &self.canvas
    }

    /// Records that the host will read the picture, after everything that was drawn.
    pub fn record_readback(&self, rec: &mut Recorder) {
        rec.copy_image(self.canvas.image(), &self.pixels);
    }

    /// The picture, top row first, sRGB.
    ///
    /// # Panics
    /// While a frame that draws it has not finished.
    #[must_use]
    pub fn image(&self) -> RgbaImage {
        let [width, height] = self.canvas.size();
        let bytes = bytemuck::cast_slice(&self.pixels.as_slice()).to_vec();
        RgbaImage::from_raw(width, height, bytes)
            .expect("the buffer has a pixel for each of the canvas")
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;
    use crate::scene::{Overrides, Scene};

    /// Would catch: a mean whose pictures lie on each other, and one whose brightness changes from picture to picture.
    #[test]
    fn the_first_picture_of_a_mean_chooses_the_exposure() {
        let scene = Scene::load("cube".as_ref(), &Overrides::default()).expect("it is built in");
        let mut view = View::of(&scene, Vec2::new(40.0, 30.0));
        view.exposure = Exposure::default();
        let views: Vec<View> = passes(view, [view.camera; 3], [40, 30]).collect();
        assert_eq!((views.len(), views[0]), (3, view));
        for (number, later) in (1..).zip(&views[1..]) {
            let camera = mean::within_pixel(&view.camera, [40, 30], number);
            assert_eq!(later.camera, camera);
            assert_ne!(later.camera, view.camera);
            assert!(
                matches!(later.exposure, Exposure::Auto { adaptation, .. } if adaptation == 0.0),
                "{:?}",
                later.exposure
            );
        }
    }
}
