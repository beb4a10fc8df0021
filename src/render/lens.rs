//! Depth of field: a lens of some width sees each picture from many places at once. Pictures from places spread over the lens, all
//! aimed at the point in focus, are averaged as light, which is exact up to their number and needs no blur.

use std::f32::consts::TAU;
use std::sync::LazyLock;

use glam::Vec2;
use image::RgbaImage;

use super::camera::{Camera, MAX_PITCH};
use super::colormap::{linear_from_srgb, srgb_from_linear};

/// Places on the lens.
pub const PLACES: u32 = 32;

/// The cameras of one picture: spread over a lens of this diameter, world units, and aimed at what is at this distance before the middle
/// of the picture.
#[must_use]
pub fn cameras(camera: &Camera, diameter: f32, focus: f32) -> Vec<Camera> {
    let target = camera.eye() - focus * camera.backward();
    (0..PLACES)
        .map(|i| {
            // A spiral that covers the disc evenly (Vogel, 1979).
            let radius = 0.5 * diameter * ((i as f32 + 0.5) / PLACES as f32).sqrt();
            let angle = TAU * (i as f32 * 0.618_034).fract();
            let Vec2 { x, y } = radius * Vec2::from_angle(angle);
            let eye = camera.eye() + x * camera.right() + y * camera.up();
            let from_target = eye - target;
            let distance = from_target.length();
            let pitch = (from_target.y / distance).clamp(-1.0, 1.0).asin();
            Camera {
                target,
                distance,
                yaw: from_target.x.atan2(from_target.z),
                pitch: pitch.clamp(-MAX_PITCH, MAX_PITCH),
                ..*camera
            }
        })
        .collect()
}

/// The mean of pictures of one size, as light.
#[derive(Clone, Debug)]
pub struct Mean {
    size: [u32; 2],
    /// Four for each pixel: light with premultiplied alpha, and alpha.
    sums: Vec<f32>,
    count: u32,
}

impl Mean {
    /// Of no pictures yet.
    #[must_use]
    pub fn new(size: [u32; 2]) -> Self {
        Self {
            size,
            sums: vec![0.0; 4 * size[0] as usize * size[1] as usize],
            count: 0,
        }
    }

    /// One picture more, with premultiplied alpha, in sRGB.
    ///
    /// # Panics
    /// If it has another size.
    pub fn add(&mut self, picture: &RgbaImage) {
        assert_eq!(
            picture.dimensions(),
            self.size.into(),
            "pictures of one size"
        );
        static LIGHT: LazyLock<[f32; 256]> =
            LazyLock::new(|| std::array::from_fn(|i| linear_from_srgb(i as f32 / 255.0)));
        let light = &*LIGHT;
        for (sums, pixel) in self.sums.chunks_exact_mut(4).zip(picture.pixels()) {
            let [r, g, b, alpha] = pixel.0;
            for (sum, channel) in sums.iter_mut().zip([r, g, b]) {
                *sum += light[usize::from(channel)];
            }
            sums[3] += f32::from(alpha);
        }
        self.count += 1;
    }

    /// Their mean, in sRGB; black and transparent if there were none.
    #[must_use]
    pub fn picture(&self) -> RgbaImage {
        let share = 1.0 / self.count.max(1) as f32;
        let [width, height] = self.size;
        RgbaImage::from_fn(width, height, |x, y| {
            let first = 4 * (y as usize * width as usize + x as usize);
            let light = |k: usize| (255.0 * srgb_from_linear(share * self.sums[first + k])).round();
            let alpha = (share * self.sums[first + 3]).round();
            image::Rgba([light(0), light(1), light(2), alpha].map(|byte| byte as u8))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// Would catch: a lens that moves what is in focus, and one that does not move what is not.
    #[test]
    fn what_is_in_focus_stays_and_the_rest_moves() {
        let size = Vec2::new(640.0, 400.0);
        let camera = Camera {
            distance: 4.0,
            yaw: 0.7,
            pitch: 0.3,
            ..Camera::default()
        };
        let focus = 3.0;
        let at = |distance: f32| camera.eye() - distance * camera.backward();
        let spread = |point: Vec3| {
            let pixels = cameras(&camera, 0.2, focus).into_iter();
            let pixels = pixels.map(|camera| camera.pixel(point, size).unwrap());
            let from_middle = pixels.map(|pixel| pixel.distance(0.5 * size));
            from_middle.fold(0.0, f32::max)
        };
        assert!(spread(at(focus)) < 0.1, "{}", spread(at(focus)));
        assert!(spread(at(2.0)) > 10.0 && spread(at(6.0)) > 5.0);
        let all = cameras(&camera, 0.2, focus);
        let mean = all.iter().map(Camera::eye).sum::<Vec3>() / PLACES as f32;
        assert!(mean.distance(camera.eye()) < 0.01, "{mean}");
    }

    /// Would catch: a mean of encoded values in place of light, and one without alpha.
    #[test]
    fn pictures_are_averaged_as_light() {
        let of = |bytes| RgbaImage::from_pixel(2, 1, image::Rgba(bytes));
        let mut mean = Mean::new([2, 1]);
        assert_eq!(mean.picture(), of([0; 4]));
        mean.add(&of([0, 10, 255, 255]));
        mean.add(&of([255, 10, 255, 0]));
        assert_eq!(mean.picture(), of([188, 10, 255, 128]));
    }
}
