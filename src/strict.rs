//! Arithmetic that gives the same bits on every processor and every graphics card: sums, differences and products by IEEE 754, and
//! functions made of these. Twin of `shaders/include/strict.glsl` and `shaders/include/vectors.glsl`, which have the reasons.
//!
//! Everything that decides the state of a simulation while it runs is calculated by these functions and by `+`, `-` and `*`.

use glam::{Vec2, Vec3};

const SIGN: u32 = 0x8000_0000;
/// The upper 12 of 24 digits: products of two such are exact.
const UPPER: u32 = 0xffff_f000;
/// Bits of 2^-100 and 2^100. As divisors, numbers beyond these count as these.
const LEAST: u32 = 0x0d80_0000;
const MOST: u32 = 0x7180_0000;
/// 2^-100 itself: smaller rates, volumes and the like count as zero.
pub const LEAST_SIZE: f32 = f32::from_bits(LEAST);

/// A number as it is stored: no zero has a sign, and numbers that devices may flush to zero are zero.
#[inline]
#[must_use]
pub fn settled(x: f32) -> f32 {
    let bits = x.to_bits();
    f32::from_bits(if bits & !SIGN < 0x0080_0000 { 0 } else { bits })
}

/// [`settled`] for each component.
#[inline]
#[must_use]
pub fn settled2(v: Vec2) -> Vec2 {
    Vec2::new(settled(v.x), settled(v.y))
}

/// [`settled`] for each component.
#[inline]
#[must_use]
pub fn settled3(v: Vec3) -> Vec3 {
    Vec3::new(settled(v.x), settled(v.y), settled(v.z))
}

/// `x`, or 0 if it is negative or no number. `max` may take either of two zeros.
#[inline]
#[must_use]
pub fn positive(x: f32) -> f32 {
    if x > 0.0 { x } else { 0.0 }
}

/// `x` from `low` to `high`. Of two zeros it takes `low`.
#[inline]
#[must_use]
pub fn within(x: f32, low: f32, high: f32) -> f32 {
    if x > low {
        if x < high { x } else { high }
    } else {
        low
    }
}

/// 1 / x, off by 0.56 units in the last place.
#[inline]
#[must_use]
pub fn reciprocal(x: f32) -> f32 {
    let bits = x.to_bits();
    let size = (bits & !SIGN).clamp(LEAST, MOST);
    let a = f32::from_bits(size);
    let guess = f32::from_bits(0x7ef3_3400 - size);
    let better = guess * (2.0013 - a * guess);
    let r = f32::from_bits(better.to_bits() & UPPER);
    let high = f32::from_bits(size & UPPER);
    let low = a - high;
    let wrong = (1.0 - high * r) - low * r;
    let result = r + r * (wrong + wrong * wrong);
    f32::from_bits(result.to_bits() | (bits & SIGN))
}

/// n / d, off by 1.6 units in the last place.
#[inline]
#[must_use]
pub fn quotient(n: f32, d: f32) -> f32 {
    n * reciprocal(d)
}

/// n / d from 0 to 1: exactly 1 where they are equal.
#[inline]
#[must_use]
pub fn share(n: f32, d: f32) -> f32 {
    if n <= 0.0 {
        0.0
    } else if n >= d {
        1.0
    } else {
        quotient(n, d).min(1.0)
    }
}

/// 1 / sqrt(x), off by 1.5 units in the last place.
#[inline]
#[must_use]
pub fn inverse_root(x: f32) -> f32 {
    let size = x.to_bits().clamp(LEAST, MOST);
    let a = f32::from_bits(size);
    let guess = f32::from_bits(0x5f37_7800 - (size >> 1));
    let half_a = 0.5 * a;
    let r = guess * (1.5009 - (half_a * guess) * guess);
    let wrong = 1.0 - (a * r) * r;
    r + r * (wrong * (0.5 + 0.375 * wrong))
}

/// sqrt(x), off by 0.51 units in the last place; 0 below 2^-100.
#[inline]
#[must_use]
pub fn root(x: f32) -> f32 {
    let size = x.to_bits().clamp(LEAST, MOST);
    let a = f32::from_bits(size);
    let r = inverse_root(a);
    let about = a * r;
    let s = f32::from_bits(about.to_bits() & UPPER);
    let rest = a - s * s;
    let t = (0.5 * r) * rest;
    let result = s + (t + (0.5 * r) * (t * t));
    if x >= f32::from_bits(LEAST) {
        result
    } else {
        0.0
    }
}

/// Cosine and sine of `word / 2^32` turns, by its upper 24 bits, off by 1.1e-7 (polynomials of Moshier's, Cephes).
#[inline]
#[must_use]
pub fn turn_of(word: u32) -> Vec2 {
    let k = (word >> 8) as i32;
    let quarter = (k + 0x20_0000) >> 22;
    let rest = (k - (quarter << 22)) as f32;
    let x = rest * 3.745_070_3e-7;
    let z = x * x;
    let s = x + x * (z * (-1.666_665_5e-1 + z * (8.332_161e-3 + z * -1.951_529_6e-4)));
    let c =
        (1.0 - 0.5 * z) + (z * z) * (4.166_664_6e-2 + z * (-1.388_731_6e-3 + z * 2.443_315_7e-5));
    let (along, across) = if quarter & 1 != 0 { (s, c) } else { (c, s) };
    let is_left = quarter == 1 || quarter == 2;
    let is_lower = quarter & 2 != 0;
    settled2(Vec2::new(
        if is_left { -along } else { along },
        if is_lower { -across } else { across },
    ))
}

/// The natural logarithm of a normal positive number, off by 0.9 units in the last place (Moshier, Cephes).
#[inline]
#[must_use]
pub fn logarithm(x: f32) -> f32 {
    let bits = x.to_bits();
    let mut exponent = (bits >> 23) as i32 - 127;
    let m = f32::from_bits((bits & 0x007f_ffff) | 0x3f80_0000);
    let is_high = m > std::f32::consts::SQRT_2;
    exponent += i32::from(is_high);
    let y = if is_high { 0.5 * m } else { m } - 1.0;
    let e = exponent as f32;
    let z = y * y;
    let mut p: f32 = 7.037_683_6e-2;
    for factor in [
        -1.151_461e-1,
        1.167_699_8e-1,
        -1.242_014_1e-1,
        1.424_932_3e-1,
        -1.666_805_8e-1,
        2.000_071_4e-1,
        -2.499_999_4e-1,
        3.333_333e-1,
    ] {
        p = p * y + factor;
    }
    let rest = ((p * y) * z - 2.121_944_4e-4 * e) - 0.5 * z;
    (y + rest) + 0.693_359_4 * e
}

/// The arctangent of 0 to 1, off by 3.1 units in the last place (Moshier, Cephes).
#[inline]
fn arc_of(x: f32) -> f32 {
    let is_wide = x > 0.414_213_57;
    let t = if is_wide {
        quotient(x - 1.0, x + 1.0)
    } else {
        x
    };
    let z = t * t;
    let mut sum: f32 = 8.053_744_6e-2;
    for factor in [-1.387_768_6e-1, 1.997_771_1e-1, -3.333_295e-1] {
        sum = sum * z + factor;
    }
    let angle = (sum * z) * t + t;
    if is_wide {
        angle + std::f32::consts::FRAC_PI_4
    } else {
        angle
    }
}

/// The angle of the vector `(x, y)`, from -pi to pi, as by `atan2`. That of the zero vector is 0.
#[inline]
#[must_use]
pub fn angle_of_vector(y: f32, x: f32) -> f32 {
    let (side_x, side_y) = (x.abs(), y.abs());
    let is_steep = side_y > side_x;
    let (less, more) = if is_steep {
        (side_x, side_y)
    } else {
        (side_y, side_x)
    };
    let mut angle = arc_of(share(less, more));
    if is_steep {
        angle = std::f32::consts::FRAC_PI_2 - angle;
    }
    if x < 0.0 {
        angle = std::f32::consts::PI - angle;
    }
    if y < 0.0 { -angle } else { angle }
}

/// The product of two vectors.
#[inline]
#[must_use]
pub fn dot2(a: Vec2, b: Vec2) -> f32 {
    a.x * b.x + a.y * b.y
}

/// The product of two vectors.
#[inline]
#[must_use]
pub fn dot3(a: Vec3, b: Vec3) -> f32 {
    (a.x * b.x + a.y * b.y) + a.z * b.z
}

/// The area that two vectors span.
#[inline]
#[must_use]
pub fn cross2(a: Vec2, b: Vec2) -> f32 {
    a.x * b.y - a.y * b.x
}

/// The vector that is perpendicular to two.
#[inline]
#[must_use]
pub fn cross3(a: Vec3, b: Vec3) -> Vec3 {
    Vec3::new(
        a.y * b.z - a.z * b.y,
        a.z * b.x - a.x * b.z,
        a.x * b.y - a.y * b.x,
    )
}

/// Its length; 0 below 2^-50.
#[inline]
#[must_use]
pub fn length3(a: Vec3) -> f32 {
    root(dot3(a, a))
}

/// The power of two that brings a number to between 1 and 2.
#[inline]
fn scale_of(most: f32) -> f32 {
    f32::from_bits(0x7f00_0000 - (most.to_bits().clamp(LEAST, MOST) & 0x7f80_0000))
}

/// Components below this count as zero: 2^-60.
const LEAST_COMPONENT: f32 = 8.673_617_4e-19;

/// The direction of a vector, or `or` if the vector is too short.
#[inline]
#[must_use]
pub fn direction3_or(way: Vec3, other: Vec3) -> Vec3 {
    let most = way.x.abs().max(way.y.abs()).max(way.z.abs());
    if most < LEAST_COMPONENT {
        return other;
    }
    let scaled = way * scale_of(most);
    settled3(scaled * inverse_root(dot3(scaled, scaled)))
}

/// As [`direction3_or`], in a plane.
#[inline]
#[must_use]
pub fn direction2_or(way: Vec2, other: Vec2) -> Vec2 {
    let most = way.x.abs().max(way.y.abs());
    if most < LEAST_COMPONENT {
        return other;
    }
    let scaled = way * scale_of(most);
    settled2(scaled * inverse_root(dot2(scaled, scaled)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, random};

    /// The difference of a number from the exact one, in units in the last place of the latter.
    fn units(found: f32, exact: f64) -> f64 {
        let exponent = exact.abs().to_bits() >> 52;
        let unit = f64::from_bits((exponent - 23) << 52);
        (f64::from(found) - exact).abs() / unit
    }

    /// All numbers from 1 to 4 but for a few.
    fn mantissas() -> impl Iterator<Item = f32> {
        (0..1_u32 << 24)
            .step_by(7)
            .map(|i| f32::from_bits(0x3f80_0000 + i))
    }

    fn worst(found: fn(f32) -> f32, exact: fn(f64) -> f64) -> f64 {
        let off = mantissas().map(|x| units(found(x), exact(x.into())));
        off.fold(0.0, f64::max)
    }

    #[test]
    fn reciprocals_and_roots_are_as_near_as_promised() {
        let cases: [(&str, f64, f64); 3] = [
            ("reciprocal", worst(reciprocal, |x| 1.0 / x), 0.56),
            ("root", worst(root, f64::sqrt), 0.51),
            ("inverse_root", worst(inverse_root, |x| 1.0 / x.sqrt()), 1.5),
        ];
        for (name, off, bound) in cases {
            assert!(off < bound, "{name} is off by {off} units");
        }
        let mut off: f64 = 0.0;
        for i in 0..1 << 18 {
            let [n, d, ..] = random(1, i, 0, Purpose::Start)
                .map(|word| f32::from_bits(0x3f80_0000 | (word >> 9)));
            off = off.max(units(quotient(n, d), f64::from(n) / f64::from(d)));
        }
        assert!(off < 1.6, "a quotient is off by {off} units");
    }

    #[test]
    fn powers_of_two_are_exact_and_scale_everything() {
        for e in -99..=99_i32 {
            let power = f32::from_bits(((127 + e) as u32) << 23);
            let other = f32::from_bits(((127 - e) as u32) << 23);
            assert_eq!(reciprocal(power), other);
            assert_eq!(reciprocal(-power), -other);
            assert_eq!(reciprocal(1.37), reciprocal(1.37 * other) * other);
            if e % 2 == 0 {
                let half = f32::from_bits(((127 + e / 2) as u32) << 23);
                assert_eq!(root(power), half);
                assert_eq!(root(1.37 * power), root(1.37) * half);
            }
        }
    }

    #[test]
    fn everything_has_a_result() {
        let odd = [
            0.0,
            -0.0,
            1e-45,
            f32::MIN_POSITIVE,
            f32::MAX,
            f32::INFINITY,
            -f32::INFINITY,
            f32::NAN,
        ];
        for x in odd {
            assert!(reciprocal(x).is_finite() && reciprocal(x) != 0.0, "{x}");
            assert!(inverse_root(x).is_finite() && root(x).is_finite(), "{x}");
        }
        assert_eq!(root(0.0), 0.0);
        assert_eq!(root(-1.0), 0.0);
        assert_eq!(angle_of_vector(0.0, 0.0), 0.0);
        assert_eq!(direction3_or(Vec3::ZERO, Vec3::Y), Vec3::Y);
        assert_eq!([settled(-0.0), settled(-1e-40)].map(f32::to_bits), [0; 2]);
        assert_eq!(within(-0.0, 0.0, 1.0).to_bits(), 0);
        assert_eq!(
            [positive(-0.0), positive(f32::NAN)].map(f32::to_bits),
            [0; 2]
        );
        // As the shaders write it.
        assert_eq!(LEAST_SIZE, 7.888_609e-31);
        assert_eq!(share(0.3, 0.3), 1.0);
        for i in 1..1000 {
            let d = i as f32 * 0.37;
            assert!(share(d.next_down(), d) <= 1.0);
        }
    }

    #[test]
    fn turns_and_logarithms_and_angles_are_as_near_as_promised() {
        let (mut off, mut length): (f64, f64) = (0.0, 0.0);
        for word in (0..=u32::MAX).step_by(9973) {
            let angle = f64::from(word >> 8) / 16_777_216.0 * std::f64::consts::TAU;
            let found = turn_of(word).as_dvec2();
            off = off.max(
                (found.x - angle.cos())
                    .abs()
                    .max((found.y - angle.sin()).abs()),
            );
            length = length.max((found.length() - 1.0).abs());
        }
        assert!(off < 1.2e-7 && length < 9e-8, "{off}, {length}");
        for (word, turn) in [(0, Vec2::X), (1 << 30, Vec2::Y), (1 << 31, Vec2::NEG_X)] {
            assert_eq!(turn_of(word), turn);
        }

        let mut off: f64 = 0.0;
        for m in (1..1 << 24).step_by(97) {
            let x = m as f32 / 16_777_216.0;
            off = off.max(units(logarithm(x), f64::from(x).ln()));
        }
        assert!(off < 0.9, "a logarithm is off by {off} units");
        assert_eq!(logarithm(1.0), 0.0);

        let mut off: f64 = 0.0;
        for i in 0..100_000 {
            let [y, x, ..] = random(2, i, 0, Purpose::Start)
                .map(|word| (word as i32 as f32) * (1.0 / 2_147_483_648.0));
            let exact = f64::from(y).atan2(x.into());
            off = off.max((f64::from(angle_of_vector(y, x)) - exact).abs());
        }
        assert!(off < 5e-7, "an angle is off by {off}");
    }

    #[test]
    fn directions_have_length_one_however_long_vectors_are() {
        for e in (-59..60).step_by(7) {
            let power = f32::from_bits(((127 + e) as u32) << 23);
            for i in 0..100 {
                let [x, y, z, _] = random(3, i, 0, Purpose::Start)
                    .map(|word| (word as i32 as f32) * (1.0 / 2_147_483_648.0));
                let way = Vec3::new(x, y, z) + Vec3::splat(1.25);
                let direction = direction3_or(way * power, Vec3::ZERO);
                assert_eq!(direction, direction3_or(way, Vec3::ZERO));
                let exact = way.as_dvec3().normalize();
                assert!(direction.as_dvec3().distance(exact) < 2.5e-7);
            }
        }
    }
}
