//! Colour maps: the colours of trail values between 0 and 1.
//!
//! A map is a few control points in sRGB, evenly spaced, joined by a smooth curve in OKLab, where equal steps look
//! equal (Ottosson, "A perceptual color space for image processing", 2020). It reaches the shaders as a table of
//! [`LENGTH`] colours in LINEAR light, so that mixing and lighting are sums of light; the picture is encoded to sRGB
//! once, by the format of the image that is drawn to.

use glam::{Mat3, Vec3, Vec4};

use super::exposure::tone;
use crate::scene::settings::ColorMap;

/// Entries of a table.
pub const LENGTH: usize = 256;

impl ColorMap {
    /// The map after this one, round and round.
    #[must_use]
    pub fn next(self) -> Self {
        let place = Self::ALL.iter().position(|map| *map == self).unwrap_or(0);
        Self::ALL[(place + 1) % Self::ALL.len()]
    }

    /// Control points, `0xRRGGBB` in sRGB, evenly spaced from 0 to 1.
    ///
    /// Viridis, Magma, Inferno and Plasma are samples of the maps by Smith, van der Walt and Firing
    /// (matplotlib, released as CC0); the others are this project's own.
    fn control_points(self) -> &'static [u32] {
        match self {
            Self::Myxo => &[
                0x0b0c0e, 0x1f1a10, 0x3d2e10, 0x66460c, 0x936409, 0xbf850a, 0xe2aa12, 0xf7cd28,
                0xffe663, 0xfff8c9,
            ],
            Self::Viridis => &[
                0x440154, 0x482475, 0x414487, 0x355f8d, 0x2a788e, 0x21918c, 0x22a884, 0x44bf70,
                0x7ad151, 0xbddf26, 0xfde725,
            ],
            Self::Magma => &[
                0x000004, 0x140e36, 0x3b0f70, 0x641a80, 0x8c2981, 0xb73779, 0xde4968, 0xf7705c,
                0xfe9f6d, 0xfecf92, 0xfcfdbf,
            ],
            Self::Inferno => &[
                0x000004, 0x160b39, 0x420a68, 0x6a176e, 0x932667, 0xbc3754, 0xdd513a, 0xf37819,
                0xfca50a, 0xf6d746, 0xfcffa4,
            ],
            Self::Plasma => &[
                0x0d0887, 0x41049d, 0x6a00a8, 0x8f0da4, 0xb12a90, 0xcc4778, 0xe16462, 0xf2844b,
                0xfca636, 0xfcce25, 0xf0f921,
            ],
            Self::Ice => &[
                0x04070d, 0x0b1a33, 0x10335f, 0x15538c, 0x2277b0, 0x429dc9, 0x75c1da, 0xaee0e8,
                0xf2fdfd,
            ],
            Self::Moss => &[
                0x080c0a, 0x10201a, 0x17392c, 0x22563c, 0x3b7644, 0x62964a, 0x94b457, 0xc7d277,
                0xf3f3bd,
            ],
            Self::Grayscale => &[0x000000, 0xffffff],
        }
    }

    /// The background that goes with the map, in linear light: dark, and of a hue that the bright trail stands out from.
    #[must_use]
    pub fn background(self) -> Vec3 {
        linear_from_hex(match self {
            Self::Myxo => 0x1b2429,
            Self::Viridis => 0x221b33,
            Self::Magma => 0x1b1726,
            Self::Inferno => 0x1f1724,
            Self::Plasma => 0x1a1733,
            Self::Ice => 0x15202e,
            Self::Moss => 0x1a231f,
            Self::Grayscale => 0x1e1f22,
        })
    }

    /// The colour for a value between 0 and 1 (clamped), in linear light.
    #[must_use]
    pub fn color(self, value: f32) -> Vec3 {
        let points = self.control_points();
        let place = value.clamp(0.0, 1.0) * (points.len() - 1) as f32;
        let i = (place as usize).min(points.len() - 2);
        let point = |k: isize| {
            // Beyond an end the curve continues straight.
            let last = points.len() as isize - 1;
            let lab = |k: isize| oklab_from_linear(linear_from_hex(points[k as usize]));
            match k {
                k if k < 0 => 2.0 * lab(0) - lab(1),
                k if k > last => 2.0 * lab(last) - lab(last - 1),
                k => lab(k),
            }
        };
        let i = i as isize;
        let lab = catmull_rom(
            [point(i - 1), point(i), point(i + 1), point(i + 2)],
            place - i as f32,
        );
        linear_from_oklab(lab).clamp(Vec3::ZERO, Vec3::ONE)
    }

    /// The table for the shaders: linear light, and in `w` the opacity, 0 to 1. Up to a share `darkest` of the brightest trail, 0 to below
    /// 1, the trail has the first colour and is transparent.
    #[must_use]
    pub fn table(self, darkest: f32) -> Vec<Vec4> {
        (0..LENGTH)
            .map(|i| {
                let brightness = above(i as f32 / (LENGTH - 1) as f32, darkest);
                self.color(brightness).extend(brightness)
            })
            .collect()
    }
}

/// The brightness at which colours begin, where all up to a share `darkest` of the brightest trail is dark.
#[must_use]
pub fn ground(darkest: f32) -> f32 {
    tone(darkest, 1.0)
}

/// The brightness above that, scaled to 0 to 1.
#[must_use]
pub fn above(brightness: f32, darkest: f32) -> f32 {
    let ground = ground(darkest);
    ((brightness - ground) / (1.0 - ground)).max(0.0)
}

/// One channel of light as it is written to a file: the sRGB transfer function (IEC 61966-2-1).
#[must_use]
pub fn srgb_from_linear(linear: f32) -> f32 {
    let linear = linear.clamp(0.0, 1.0);
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

/// One channel of a file as light; the inverse of [`srgb_from_linear`].
#[must_use]
pub fn linear_from_srgb(srgb: f32) -> f32 {
    let srgb = srgb.clamp(0.0, 1.0);
    if srgb <= 0.040_45 {
        srgb / 12.92
    } else {
        ((srgb + 0.055) / 1.055).powf(2.4)
    }
}

/// A `0xRRGGBB` colour as light.
#[must_use]
pub fn linear_from_hex(hex: u32) -> Vec3 {
    let channel = |shift: u32| linear_from_srgb(((hex >> shift) & 0xff) as f32 / 255.0);
    Vec3::new(channel(16), channel(8), channel(0))
}

/// A uniform Catmull-Rom segment from `points[1]` to `points[2]`.
fn catmull_rom(points: [Vec3; 4], t: f32) -> Vec3 {
    let [a, b, c, d] = points;
    0.5 * (2.0 * b
        + (c - a) * t
        + (2.0 * a - 5.0 * b + 4.0 * c - d) * t * t
        + (3.0 * b - a - 3.0 * c + d) * t * t * t)
}

/// Ottosson's matrices, stored by columns.
const LMS_FROM_RGB: Mat3 = Mat3::from_cols_array(&[
    0.412_221_46,
    0.211_903_5,
    0.088_302_46, //
    0.536_332_55,
    0.680_699_5,
    0.281_718_85, //
    0.051_445_995,
    0.107_396_96,
    0.629_978_7,
]);
const LAB_FROM_LMS_ROOTS: Mat3 = Mat3::from_cols_array(&[
    0.210_454_26,
    1.977_998_5,
    0.025_904_037, //
    0.793_617_8,
    -2.428_592_2,
    0.782_771_77, //
    -0.004_072_047,
    0.450_593_7,
    -0.808_675_77,
]);

fn oklab_from_linear(rgb: Vec3) -> Vec3 {
    let lms = LMS_FROM_RGB * rgb;
    LAB_FROM_LMS_ROOTS * Vec3::new(lms.x.cbrt(), lms.y.cbrt(), lms.z.cbrt())
}

pub(super) fn linear_from_oklab(lab: Vec3) -> Vec3 {
    let roots = LAB_FROM_LMS_ROOTS.inverse() * lab;
    LMS_FROM_RGB.inverse() * (roots * roots * roots)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The largest difference of a channel, in steps of an 8-bit file.
    fn difference(linear: Vec3, hex: u32) -> f32 {
        let channel = |value: f32, shift: u32| {
            (255.0 * srgb_from_linear(value) - ((hex >> shift) & 0xff) as f32).abs()
        };
        channel(linear.x, 16)
            .max(channel(linear.y, 8))
            .max(channel(linear.z, 0))
    }

    #[test]
    fn published_maps_are_met_between_the_control_points() {
        // Values of the published tables at quarters, which are not control points.
        for (map, first, quarter, three_quarters, last) in [
            (ColorMap::Viridis, 0x440154, 0x3b528b, 0x5dc863, 0xfde725),
            (ColorMap::Magma, 0x000004, 0x51127c, 0xfb8861, 0xfcfdbf),
            (ColorMap::Inferno, 0x000004, 0x56106e, 0xf98c0a, 0xfcffa4),
            (ColorMap::Plasma, 0x0d0887, 0x7e03a8, 0xf89441, 0xf0f921),
        ] {
            for (value, hex) in [
                (0.0, first),
                (0.25, quarter),
                (0.75, three_quarters),
                (1.0, last),
            ] {
                let off = difference(map.color(value), hex);
                assert!(off < 6.0, "{map:?} at {value} is {off} steps off");
            }
        }
    }

    #[test]
    fn every_map_grows_lighter_all_the_way() {
        for map in ColorMap::ALL {
            let lightness: Vec<f32> = map
                .table(0.0)
                .iter()
                .map(|c| oklab_from_linear(c.truncate()).x)
                .collect();
            for (i, pair) in lightness.windows(2).enumerate() {
                assert!(pair[1] > pair[0] - 2e-4, "{map:?} darkens at {i}: {pair:?}");
            }
            assert!(lightness[LENGTH - 1] - lightness[0] > 0.5, "{map:?}");
        }
    }

    #[test]
    fn what_is_below_the_darkest_trail_has_the_first_colour() {
        for darkest in [0.0, 0.1, 0.5, 0.99] {
            let table = ColorMap::Myxo.table(darkest);
            let first = ColorMap::Myxo.color(0.0);
            for (i, color) in table.iter().enumerate() {
                let brightness = i as f32 / (LENGTH - 1) as f32;
                let is_dark = color.truncate().distance(first) < 1e-6;
                assert_eq!(is_dark, brightness <= tone(darkest, 1.0), "{darkest}: {i}");
            }
            let last = table[LENGTH - 1].truncate();
            assert!(last.distance(ColorMap::Myxo.color(1.0)) < 1e-4, "{last}");
        }
    }

    #[test]
    fn tables_hold_light_and_not_code_values() {
        // Half of grayscale LOOKS half as light: OKLab lightness 0.5 is 0.125 of white's light, 99 of 255 in sRGB.
        let middle = ColorMap::Grayscale.color(0.5);
        assert!(
            (middle - Vec3::splat(0.125)).abs().max_element() < 1e-4,
            "{middle}"
        );
        assert!(difference(middle, 0x636363) < 1.0);
        for map in ColorMap::ALL {
            let table = map.table(0.0);
            assert_eq!(table.len(), LENGTH);
            assert!(
                table
                    .iter()
                    .all(|c| c.is_finite() && c.min_element() >= 0.0 && c.max_element() <= 1.0)
            );
        }
    }

    #[test]
    fn srgb_there_and_back_returns() {
        for byte in 0..=255_u32 {
            let linear = linear_from_srgb(byte as f32 / 255.0);
            assert!((255.0 * srgb_from_linear(linear) - byte as f32).abs() < 1e-3);
        }
        assert!((linear_from_srgb(0.5) - 0.214_041).abs() < 1e-5);
        assert!((linear_from_srgb(0.02) - 0.02 / 12.92).abs() < 1e-7);
    }

    #[test]
    fn next_visits_every_map() {
        let mut map = ColorMap::default();
        let mut seen = std::collections::HashSet::new();
        for _ in 0..ColorMap::ALL.len() {
            seen.insert(map);
            map = map.next();
        }
        assert_eq!(
            (seen.len(), map),
            (ColorMap::ALL.len(), ColorMap::default())
        );
    }
}
