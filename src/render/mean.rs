//! The mean of pictures, as light: of a lens that sees from many places, and of a picture that is drawn again and again a little beside
//! itself, for edges and fine lines without steps. All is done by integers, which give the same bits on every device.

use std::sync::{Arc, LazyLock};

use glam::{UVec2, Vec2};

use super::camera::Camera;
use super::colormap::linear_from_srgb;
use crate::gpu::{
    Buffer, Context, Domain, Fate, GpuError, Image, Pipeline, Recorder, Texels, Threads,
};
use crate::sim::kernels::{Average, AverageArgs, AverageParams};

/// Pictures that make a mean with smooth edges and lines.
pub const FINE: u32 = 8;

/// The parts of a pixel by which each picture of a mean is farther to the right and higher than the one before: so they cover the pixel
/// evenly, however many there are (Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018).
const APART: Vec2 = Vec2::new(0.754_877_7, 0.569_840_3);

/// The camera of one of the pictures of a mean, of `size` pixels: a part of a pixel beside `camera`, which is that of number 0.
#[must_use]
pub fn within_pixel(camera: &Camera, size: [u32; 2], number: u32) -> Camera {
    let part = (0.5 + number as f32 * APART).fract_gl() - 0.5;
    Camera {
        shift: camera.shift + 2.0 * part / UVec2::from_array(size).as_vec2(),
        ..*camera
    }
}

/// The most pictures of a mean.
pub const MOST_PICTURES: u32 = 65_536;

/// The light of each byte of sRGB, 0 to 65,535; each larger than the one before.
#[must_use]
pub fn light() -> &'static [u32; 256] {
    static LIGHT: LazyLock<[u32; 256]> = LazyLock::new(|| {
        std::array::from_fn(|byte| {
            (65_535.0 * linear_from_srgb(byte as f32 / 255.0)).round() as u32
        })
    });
    &LIGHT
}

/// Sums of pictures of one size.
pub struct Mean {
    size: [u32; 2],
    average: Pipeline<Average>,
    light: Texels<u32>,
    sums: Texels<u32>,
    words: Buffer<u32>,
    picture: Texels<u32>,
    count: u32,
    /// The recording of the latest pictures, and the number of pictures before it.
    latest: Option<(Fate, u32)>,
}

impl Mean {
    /// Of no pictures yet, of `size` pixels.
    ///
    /// # Errors
    /// When the device has no memory for 20 bytes a pixel, or no buffers of so many pixels.
    pub fn new(ctx: &Arc<Context>, size: [u32; 2]) -> Result<Self, GpuError> {
        let pixel_count = size[0] as usize * size[1] as usize;
        let light = Buffer::from_slice(ctx, "picture.light", light())?;
        // The first picture of a mean writes them.
        let sums = Buffer::<u32>::new(ctx, "picture.sums", 4 * pixel_count, Domain::Texels)?;
        let words = Buffer::<u32>::zeroed(ctx, "picture.mean", pixel_count)?;
        Ok(Self {
            size,
            average: Pipeline::new(ctx, &())?,
            light: Texels::new(&light, 1)?,
            sums: Texels::new(&sums, 4)?,
            picture: Texels::new(&words, 1)?,
            words,
            count: 0,
            latest: None,
        })
    }

    /// Width and height, pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The number of pictures; those of a recording that was dropped count until the next one is recorded.
    #[must_use]
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Forgets all pictures.
    pub fn restart(&mut self) {
        (self.count, self.latest) = (0, None);
    }

    /// Pictures of a recording that was dropped are not in the sums.
    fn take_back_what_was_dropped(&mut self) {
        if let Some((_, before)) = self.latest.take_if(|(fate, _)| fate.was_dropped()) {
            self.count = before;
        }
    }

    /// Records that a picture, in sRGB and with premultiplied alpha, is added; the mean takes its place.
    ///
    /// # Panics
    /// If it has another size, or is one more than [`MOST_PICTURES`].
    pub fn record(&mut self, rec: &mut Recorder, image: &Image) {
        assert_eq!(image.size(), self.size, "pictures of one size");
        self.take_back_what_was_dropped();
        assert!(self.count < MOST_PICTURES, "too many pictures");
        if !(self.latest.as_ref()).is_some_and(|(fate, _)| fate.is(&rec.fate)) {
            self.latest = Some((rec.fate.clone(), self.count));
        }
        self.count += 1;
        rec.copy_image(image, &self.words);
        let pixel_count = self.size[0] * self.size[1];
        rec.dispatch(
            &self.average,
            Threads(pixel_count),
            AverageArgs {
                light: &self.light,
                sums: &self.sums,
                picture: &self.picture,
            },
            AverageParams {
                pixel_count,
                pictures: self.count,
            },
        );
        rec.copy_to_image(&self.words, image, self.size[0]);
    }
}

/// Twin of `shaders/average.comp`: adds `picture` to `sums`, of `pictures` with this one, and puts the mean in its place.
pub fn average(pictures: u32, sums: &mut [[u32; 4]], picture: &mut [u32]) {
    let light = light();
    let byte_of = |mean: u32| {
        let mut found = 0;
        for step in (0..8).rev().map(|bit| 1 << bit) {
            let next = found + step;
            if 2 * mean >= light[next - 1] + light[next] {
                found = next;
            }
        }
        found as u32
    };
    for (sum, word) in sums.iter_mut().zip(picture) {
        let [r, g, b, alpha] = word.to_le_bytes();
        let [r, g, b] = [r, g, b].map(|byte| light[usize::from(byte)]);
        let before = if pictures > 1 { *sum } else { [0; 4] };
        *sum = [r, g, b, u32::from(alpha)];
        for (sum, before) in sum.iter_mut().zip(before) {
            *sum += before;
        }
        let [r, g, b, alpha] = sum.map(|sum| (sum + pictures / 2) / pictures);
        *word = byte_of(r) | byte_of(g) << 8 | byte_of(b) << 16 | alpha << 24;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Would catch: a mean of encoded values in place of light, one without alpha, and one that changes what does not change.
    #[test]
    fn pictures_are_averaged_as_light() {
        let mut sums = [[0; 4]; 1];
        let mut word = [u32::from_le_bytes([0, 10, 255, 255])];
        average(1, &mut sums, &mut word);
        assert_eq!(word[0].to_le_bytes(), [0, 10, 255, 255]);
        word = [u32::from_le_bytes([255, 10, 255, 0])];
        average(2, &mut sums, &mut word);
        assert_eq!(word[0].to_le_bytes(), [188, 10, 255, 128]);
        for byte in 0..=255_u8 {
            let same = u32::from_le_bytes([byte; 4]);
            for pictures in 1..=40 {
                word = [same];
                average(pictures, &mut sums, &mut word);
                assert_eq!(word, [same], "{pictures} of {byte}");
            }
        }
    }

    /// Would catch: pictures that are farther than half a pixel away, or all on one side.
    #[test]
    fn pictures_lie_all_round_within_a_pixel() {
        let (size, camera) = ([64, 40], Camera::default());
        assert_eq!(within_pixel(&camera, size, 0), camera);
        let pixels = UVec2::from_array(size).as_vec2();
        let places: Vec<Vec2> = (0..FINE)
            .map(|number| 0.5 * within_pixel(&camera, size, number).shift * pixels)
            .collect();
        assert!(places.iter().all(|place| place.abs().max_element() <= 0.5));
        let mean = places.iter().sum::<Vec2>() / FINE as f32;
        assert!(mean.length() < 0.15, "{mean}");
        let apart = places.iter().enumerate().flat_map(|(i, one)| {
            let others = places[..i].iter();
            others.map(move |other| one.distance(*other))
        });
        assert!(apart.fold(1.0, f32::min) > 0.15);
    }
}
