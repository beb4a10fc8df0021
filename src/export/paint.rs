//! The trail's colours as pictures have them, at a texel and as a whole texture.

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use crate::mesh::atlas::Atlas;
use crate::mesh::surface::NONE;
use crate::render::View;
use crate::render::colormap::srgb_from_linear;
use crate::render::exposure::{self, BIN_COUNT, Exposure, tone};

/// The material under the trail, as in `shaders/include/shading.glsl`.
const BARE: Vec3 = Vec3::new(0.014, 0.015, 0.017);

/// Converts trail values to colours.
pub struct Paint {
    /// Linear light, from no trail to the brightest, and the opacity over the material.
    table: Vec<Vec4>,
    /// Those of the second look, if it has its own.
    second_table: Option<Vec<Vec4>>,
    /// The trail value of the brightest colour.
    pub brightest: f32,
}

impl Paint {
    /// The colours of a picture with this view; `density` is 0 for texels that belong to no triangle.
    #[must_use]
    pub fn new(view: &View, trail: &[f32], density: &[f32]) -> Self {
        Self {
            table: view.color_map.table(view.darkest),
            second_table: view.second_colors.map(|map| map.table(view.darkest)),
            brightest: match view.exposure {
                Exposure::Fixed(brightest) => brightest.max(f32::MIN_POSITIVE),
                Exposure::Auto { clipped_share, .. } => exposed(clipped_share, trail, density),
            },
        }
    }

    /// The light that both looks make of their colours of a trail, by the weight of the second look. In pictures it is laid over the first.
    fn mixed(&self, trail: f32, weight: f32, light: impl Fn(Vec4) -> Vec3) -> Vec3 {
        let brightness = tone(trail, self.brightest);
        let first = light(color_of(&self.table, brightness));
        match &self.second_table {
            Some(table) if weight > 0.0 => {
                first * (1.0 - weight) + light(color_of(table, brightness)) * weight
            }
            _ => first,
        }
    }

    /// The colour of the surface under white light, in linear light: bare material where there is no trail. `second_look` is the weight of
    /// the second look there, 0 to 1.
    #[must_use]
    pub fn color(&self, trail: f32, second_look: f32) -> Vec3 {
        self.mixed(trail, second_look, |color| {
            BARE * (1.0 - color.w) + color.truncate()
        })
    }

    /// The light of the trail alone, which the surface emits.
    #[must_use]
    pub fn glow(&self, trail: f32, second_look: f32) -> Vec3 {
        self.mixed(trail, second_look, Vec4::truncate)
    }

    /// The surface's colour as three bytes of a file.
    #[must_use]
    pub fn srgb(&self, trail: f32, second_look: f32) -> [u8; 3] {
        bytes(self.color(trail, second_look))
    }

    /// The surface's colours in the whole atlas, as an image of `size * size` pixels. Pixels beyond all charts and gutters
    /// continue the nearest ones, so that filtering or shrinking the image mixes in no foreign colour. `looks` has the weight of the second
    /// look for each texel, or is empty without one.
    #[must_use]
    pub fn texture(&self, atlas: &Atlas, trail: &[f32], looks: &[f32]) -> image::RgbImage {
        texture(atlas, |texel| {
            self.color(trail[texel], weight_of(looks, texel))
        })
    }

    /// As [`texture`](Self::texture), with the light that the surface emits.
    #[must_use]
    pub fn glow_texture(&self, atlas: &Atlas, trail: &[f32], looks: &[f32]) -> image::RgbImage {
        texture(atlas, |texel| {
            self.glow(trail[texel], weight_of(looks, texel))
        })
    }
}

/// Twin of `color_of` in `shaders/include/colormap.glsl`.
fn color_of(table: &[Vec4], brightness: f32) -> Vec4 {
    let last = table.len() - 1;
    let place = brightness.clamp(0.0, 1.0) * last as f32;
    let entry = (place as usize).min(last - 1);
    table[entry].lerp(table[entry + 1], place - entry as f32)
}

/// The weight of the second look at a texel.
fn weight_of(looks: &[f32], texel: usize) -> f32 {
    looks.get(texel).copied().unwrap_or(0.0)
}

fn bytes(light: Vec3) -> [u8; 3] {
    let channel = |light: f32| (255.0 * srgb_from_linear(light)).round() as u8;
    light.to_array().map(channel)
}

fn texture(atlas: &Atlas, color: impl Fn(usize) -> Vec3 + Sync) -> image::RgbImage {
    let (size, pitch) = (atlas.size as usize, atlas.pitch as usize);
    let mut pixels: Vec<[u8; 3]> = vec![[0; 3]; size * size];
    let rows = pixels.par_chunks_mut(size).enumerate();
    rows.for_each(|(row, pixels)| {
        for (pixel, texel) in pixels.iter_mut().zip(row * pitch..) {
            *pixel = bytes(color(texel));
        }
    });
    let mut is_known: Vec<bool> = (0..size * size)
        .map(|i| atlas.owner[i / size * pitch + i % size] != NONE)
        .collect();
    for gutter in &atlas.gutter_texels {
        let texel = gutter.texel as usize;
        is_known[texel / pitch * size + texel % pitch] = true;
    }
    spread(&mut pixels, &mut is_known, size);
    let side = atlas.size;
    image::RgbImage::from_raw(side, side, pixels.into_flattened())
        .expect("there is a pixel for each texel")
}

/// Gives every unknown pixel the colour of a nearest known one, by a flood fill over shared sides.
fn spread(pixels: &mut [[u8; 3]], is_known: &mut [bool], size: usize) {
    let neighbours = |i: usize| {
        let (x, y) = (i % size, i / size);
        [
            (x > 0).then(|| i - 1),
            (x + 1 < size).then_some(i + 1),
            (y > 0).then(|| i - size),
            (y + 1 < size).then_some(i + size),
        ]
    };
    let is_at_rim = |i: &usize| neighbours(*i).into_iter().flatten().any(|n| !is_known[n]);
    let known = (0..is_known.len()).filter(|&i| is_known[i]);
    let mut ring: Vec<usize> = known.filter(is_at_rim).collect();
    while !ring.is_empty() {
        let mut next = Vec::new();
        for i in ring {
            for neighbour in neighbours(i).into_iter().flatten() {
                if !std::mem::replace(&mut is_known[neighbour], true) {
                    pixels[neighbour] = pixels[i];
                    next.push(neighbour);
                }
            }
        }
        ring = next;
    }
}

/// The brightest value of a picture of this trail alone.
fn exposed(clipped_share: f32, trail: &[f32], density: &[f32]) -> f32 {
    let count = density.len() as u32;
    let stride = exposure::stride(count);
    let mut histogram = vec![0; BIN_COUNT as usize];
    exposure::trail_histogram(
        count.div_ceil(stride),
        stride,
        trail,
        density,
        &mut histogram,
    );
    let mut brightest = [1.0];
    exposure::expose(1, clipped_share, 1.0, &mut histogram, &mut brightest);
    brightest[0].max(f32::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::settings::ColorMap;

    /// Would catch: a second look in the colours of the first one, and weights that do not mix the two.
    #[test]
    fn looks_are_mixed_by_the_weight_of_the_second_one() {
        let paint = |first: ColorMap, second: Option<ColorMap>| Paint {
            table: first.table(0.0),
            second_table: second.map(|map| map.table(0.0)),
            brightest: 1.0,
        };
        let ice = paint(ColorMap::Ice, None);
        let moss = paint(ColorMap::Moss, None);
        let both = paint(ColorMap::Ice, Some(ColorMap::Moss));
        for trail in [0.0, 0.1, 0.4, 3.0] {
            for weight in [0.0, 0.25, 1.0] {
                for value in [Paint::color, Paint::glow] {
                    let [one, other] = [&ice, &moss].map(|paint| value(paint, trail, 0.0));
                    assert_ne!(one, other);
                    let mixed = one * (1.0 - weight) + other * weight;
                    assert_eq!(value(&both, trail, weight), mixed, "{trail}, {weight}");
                    // A look without colours of its own takes those of the first.
                    assert_eq!(value(&ice, trail, weight), one);
                }
            }
        }
    }

    #[test]
    fn colours_spread_from_the_nearest_pixel_to_all_others() {
        let size = 9;
        let mut pixels = vec![[0; 3]; size * size];
        let mut is_known = vec![false; size * size];
        for (x, y, color) in [(0, 4, [1; 3]), (8, 4, [2; 3])] {
            pixels[y * size + x] = color;
            is_known[y * size + x] = true;
        }
        spread(&mut pixels, &mut is_known, size);
        assert!(is_known.iter().all(|&known| known));
        for (i, pixel) in pixels.iter().enumerate() {
            match i % size {
                0..=3 => assert_eq!(*pixel, [1; 3], "pixel {i}"),
                5.. => assert_eq!(*pixel, [2; 3], "pixel {i}"),
                _ => assert!(*pixel == [1; 3] || *pixel == [2; 3]),
            }
        }
    }

    /// Terminates if no pixel is known.
    #[test]
    fn an_empty_texture_stays_as_it_is() {
        let mut pixels = vec![[7; 3]; 4];
        spread(&mut pixels, &mut [false; 4], 2);
        assert_eq!(pixels, [[7; 3]; 4]);
    }
}
