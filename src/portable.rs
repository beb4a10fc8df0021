//! Sines, angles and powers with the same bits on every machine, for computations on the host: shapes, layouts, poses, starts. Those of the
//! standard library are the system's, which differ in their last bits.
//!
//! Sums, products, quotients and roots are exact by IEEE 754. Functions that are computed in every step, on the device, too, are in
//! `strict.rs`.

use glam::{DQuat, DVec2, DVec3};

/// Sine and cosine of an angle.
#[must_use]
pub fn sin_cos(angle: f64) -> (f64, f64) {
    libm::sincos(angle)
}

/// The sine of an angle.
#[must_use]
pub fn sin(angle: f64) -> f64 {
    libm::sin(angle)
}

/// The cosine of an angle.
#[must_use]
pub fn cos(angle: f64) -> f64 {
    libm::cos(angle)
}

/// The tangent of an angle.
#[must_use]
pub fn tan(angle: f64) -> f64 {
    libm::tan(angle)
}

/// The angle, 0 to pi, that has a cosine.
#[must_use]
pub fn acos(cosine: f64) -> f64 {
    libm::acos(cosine)
}

/// The angle of the vector `(x, y)`, -pi to pi.
#[must_use]
pub fn atan2(y: f64, x: f64) -> f64 {
    libm::atan2(y, x)
}

/// e to the power of `x`.
#[must_use]
pub fn exp(x: f64) -> f64 {
    libm::exp(x)
}

/// The natural logarithm.
#[must_use]
pub fn ln(x: f64) -> f64 {
    libm::log(x)
}

/// The decimal logarithm.
#[must_use]
pub fn log10(x: f64) -> f64 {
    libm::log10(x)
}

/// 10 to the power of a whole number that is not negative; exact up to 22.
#[must_use]
pub fn power_of_ten(exponent: u32) -> f64 {
    (0..exponent).fold(1.0, |power, _| 10.0 * power)
}

/// 2 to the power of a whole number; if the power is no normal number, the nearest normal one.
#[must_use]
pub fn power_of_two(exponent: i64) -> f64 {
    f64::from_bits(((1023 + exponent.clamp(-1022, 1023)) as u64) << 52)
}

/// The exponent of the greatest power of two that a normal positive number reaches.
#[must_use]
pub fn exponent_of(x: f64) -> i64 {
    (x.to_bits() >> 52 & 0x7ff) as i64 - 1023
}

/// The smallest power of two that is not less than a normal positive number.
#[must_use]
pub fn power_of_two_from(x: f64) -> f64 {
    let reached = exponent_of(x);
    power_of_two(reached + i64::from(x > power_of_two(reached)))
}

/// The unit vector at an angle from X.
#[must_use]
pub fn direction(angle: f64) -> DVec2 {
    let (sin, cos) = sin_cos(angle);
    DVec2::new(cos, sin)
}

/// The angle between two vectors; NaN where one is zero.
#[must_use]
pub fn angle_between(a: DVec3, b: DVec3) -> f64 {
    let cosine = a.dot(b) / (a.length_squared() * b.length_squared()).sqrt();
    acos(cosine.clamp(-1.0, 1.0))
}

/// A rotation about a unit vector.
#[must_use]
pub fn turn_about(axis: DVec3, angle: f64) -> DQuat {
    let (sin, cos) = sin_cos(0.5 * angle);
    let v = axis * sin;
    DQuat::from_xyzw(v.x, v.y, v.z, cos)
}

/// Rotations about X, then Y, then Z, each about the fixed axis.
#[must_use]
pub fn turn_about_axes(angles: DVec3) -> DQuat {
    turn_about(DVec3::Z, angles.z) * turn_about(DVec3::Y, angles.y) * turn_about(DVec3::X, angles.x)
}

/// A part of the shorter way from one rotation to another, at an even rate (Shoemake 1985).
#[must_use]
pub fn turn_between(from: DQuat, to: DQuat, share: f64) -> DQuat {
    let cosine = from.dot(to);
    let (to, cosine) = if cosine < 0.0 {
        (-to, -cosine)
    } else {
        (to, cosine)
    };
    // The sine of so small an angle is zero.
    if cosine > 1.0 - f64::EPSILON {
        return (from * (1.0 - share) + to * share).normalize();
    }
    let angle = acos(cosine);
    let (before, after) = (sin(angle * (1.0 - share)), sin(angle * share));
    (from * before + to * after) * (1.0 / sin(angle))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::EulerRot;

    /// Catches bits that another version of the crate, or other instructions by the compiler, would change.
    #[test]
    fn the_last_bits_are_known() {
        let mut bits = 0_u64;
        let mut take = |x: f64| bits = bits.rotate_left(5).wrapping_add(x.to_bits());
        for i in 1..2000 {
            let x = 0.013 * f64::from(i);
            let (sine, cosine) = sin_cos(x);
            take(sine);
            take(cosine);
            take(sin(-x));
            take(cos(-x));
            take(tan(x));
            take(acos(sine));
            take(atan2(x, cosine));
            take(exp(sine * x));
            take(ln(x));
            take(log10(x));
        }
        assert_eq!(format!("{bits:016x}"), KNOWN);
    }
    const KNOWN: &str = "bb3a4d0b4ce15132";

    #[test]
    fn they_are_those_of_the_standard_library_but_for_the_last_bits() {
        for i in -500..500 {
            let x = 0.017 * f64::from(i);
            let near = |a: f64, b: f64| (a - b).abs() <= 4.0 * f64::EPSILON * b.abs().max(1e-3);
            let (sine, cosine) = sin_cos(x);
            assert!(near(sine, x.sin()) && near(sin(x), x.sin()), "{x}");
            assert!(near(cosine, x.cos()) && near(cos(x), x.cos()), "{x}");
            assert!(near(tan(x), x.tan()) && near(exp(x), x.exp()), "{x}");
            assert!(near(acos(sine), sine.acos()), "{x}");
            assert!(near(atan2(x, cosine), x.atan2(cosine)), "{x}");
            assert!(i <= 0 || near(ln(x), x.ln()), "{x}");
        }
    }

    #[test]
    fn powers_of_two_are_exact() {
        for e in [-1022, -30, -1, 0, 1, 52, 1023] {
            let power = power_of_two(e);
            assert_eq!(power, 2.0_f64.powi(e as i32));
            assert_eq!(exponent_of(power), e);
            assert_eq!(exponent_of(power.next_up()), e);
            assert_eq!(power_of_two_from(power), power);
            if e < 1023 {
                assert_eq!(power_of_two_from(power.next_up()), 2.0 * power);
            }
        }
        assert_eq!(power_of_two(2000), power_of_two(1023));
        assert_eq!(power_of_ten(15), 1e15);
    }

    #[test]
    fn turns_are_those_of_glam() {
        let near = |a: DQuat, b: DQuat| a.dot(b).abs() > 1.0 - 1e-14;
        for k in 0..50 {
            let angles = DVec3::new(0.3, -1.1, 2.3) * 0.1 * f64::from(k);
            let DVec3 { x, y, z } = angles;
            let turn = turn_about_axes(angles);
            assert!(near(turn, DQuat::from_euler(EulerRot::ZYX, z, y, x)));
            let axis = DVec3::new(0.6, 0.0, -0.8);
            let other = turn_about(axis, 0.2 * f64::from(k));
            assert!(near(
                other,
                DQuat::from_axis_angle(axis, 0.2 * f64::from(k))
            ));
            let between = turn_between(turn, other, 0.3);
            assert!(near(between, turn.slerp(other, 0.3)), "{k}");
            assert!(near(turn_between(turn, turn, 0.3), turn));
            let (a, b) = (turn * DVec3::X, other * DVec3::X);
            assert!((angle_between(a, b) - a.angle_between(b)).abs() < 1e-12);
        }
        assert_eq!(turn_about_axes(DVec3::ZERO), DQuat::IDENTITY);
    }
}
