//! Is the arithmetic of a device that of the host? Only then do steps give the same bits. Twin of `shaders/arithmetic.comp`.

use std::sync::Arc;

use bytemuck::Zeroable;
use glam::{UVec4, Vec2, Vec3, Vec4};

use super::kernels::{Arithmetic, ArithmeticArgs, ArithmeticParams};
use crate::error::Result;
use crate::gpu::{Buffer, Context, Frames, Pipeline, Threads};
use crate::rng::{Purpose, random};
use crate::strict;

/// Version of the arithmetic of steps. It is increased by changes with which runs end in other states. Checkpoints hold the version that
/// they were written with; those of earlier programs have none.
pub const VERSION: u32 = 1;

/// An operation in which the device deviates from IEEE 754.
#[derive(Clone, Debug, PartialEq)]
pub struct Broken {
    /// The rule, for people.
    pub rule: &'static str,
    /// The number of tested numbers for which it is broken.
    pub times: usize,
    /// The first ones, as bits.
    pub words: [u32; 4],
    /// The device's result.
    pub found: f32,
    /// The exact result.
    pub expected: f32,
}

/// The tested numbers: zeros and equal ones, some that are near 1, and others of all sizes that scenes have.
#[must_use]
pub fn numbers() -> Vec<UVec4> {
    let of = |i: u32| {
        let words = random(5, i, 0, Purpose::Start);
        UVec4::from_array(words.map(|word| {
            let (sign, mantissa) = (word & 0x8000_0000, word & 0x007f_ffff);
            let spread = if i.is_multiple_of(2) { 4 } else { 60 };
            let exponent = 127 - spread / 2 + (word >> 23 & 0xff) % spread;
            sign | exponent << 23 | mantissa
        }))
    };
    let [zero, one] = [0.0_f32, 1.0].map(f32::to_bits);
    let negative = 0x8000_0000;
    let odd = [
        [zero, one, zero, one],
        [negative, zero, negative, negative],
        [one, one, one | negative, one],
        [one | negative, negative, one, zero],
    ];
    let odd = odd.into_iter().map(UVec4::from_array);
    odd.chain((4..1 << 16).map(of)).collect()
}

/// Names of the results of [`arithmetic`], in order.
const RULES: [&str; 24] = [
    "products are rounded to nearest",
    "sums are rounded to nearest",
    "products and sums are not contracted",
    "products and differences are not contracted",
    "reciprocal",
    "quotient",
    "share",
    "inverse root",
    "root",
    "cosine of a turn",
    "sine of a turn",
    "logarithm",
    "angle of a vector",
    "direction, x",
    "direction, y",
    "direction, z",
    "product of vectors",
    "cross product",
    "length",
    "direction in a plane",
    "what is stored has no zero with a sign",
    "limits",
    "whole part",
    "cross product, z",
];

/// The results that the kernel must have.
#[must_use]
pub fn arithmetic(word: UVec4) -> [Vec4; 6] {
    let [x, y, z, w] = word.to_array().map(f32::from_bits);
    let (v, u) = (Vec3::new(x, y, z), Vec3::new(y, z, w));
    let turn = strict::turn_of(word.x.wrapping_mul(0x9e37_79b1));
    let direction = strict::direction3_or(v, Vec3::X);
    [
        Vec4::new(x * y, x + y, x * y + z, x * y - z * w),
        Vec4::new(
            strict::reciprocal(x),
            strict::quotient(x, y),
            strict::share(x, y),
            strict::inverse_root(x),
        ),
        Vec4::new(strict::root(x), turn.x, turn.y, strict::logarithm(x.abs())),
        Vec4::new(
            strict::angle_of_vector(x, y),
            direction.x,
            direction.y,
            direction.z,
        ),
        Vec4::new(
            strict::dot3(v, u),
            strict::cross3(v, u).y,
            strict::length3(v),
            strict::direction2_or(Vec2::new(z, w), Vec2::X).x,
        ),
        Vec4::new(
            strict::settled(y),
            strict::within(y, -1.0, 1.0),
            z.floor(),
            strict::cross3(v, u).z,
        ),
    ]
}

/// Calculates at these numbers on the device.
///
/// # Errors
/// When the device fails or has too little memory.
pub fn on_device(ctx: &Arc<Context>, numbers: &[UVec4]) -> Result<Vec<[Vec4; 6]>> {
    let pipeline = Pipeline::<Arithmetic>::new(ctx, &())?;
    let words = Buffer::from_slice(ctx, "arithmetic.words", numbers)?;
    let found = Buffer::<Vec4>::zeroed(ctx, "arithmetic.found", 6 * numbers.len())?;
    Frames::new(ctx, 1)?.run(|rec| {
        let args = ArithmeticArgs {
            words: &words,
            found: &found,
        };
        let params = ArithmeticParams {
            count: numbers.len() as u32,
        };
        rec.dispatch(&pipeline, Threads::of(numbers.len()), args, params);
    })?;
    let found = ctx.download(&found)?;
    let mut rows = vec![[Vec4::zeroed(); 6]; numbers.len()];
    for (row, found) in rows.iter_mut().zip(found.chunks(6)) {
        row.copy_from_slice(found);
    }
    Ok(rows)
}

/// Does a device have the arithmetic of all others, as far as a few numbers show?
///
/// # Errors
/// When the device fails or has too little memory.
pub fn is_everywhere(ctx: &Arc<Context>) -> Result<bool> {
    let mut numbers = numbers();
    numbers.truncate(1 << 12);
    let found = on_device(ctx, &numbers)?;
    Ok(compared(&numbers, &found).is_empty())
}

/// Every rule that a device breaks; none if its states are those of other devices.
///
/// # Errors
/// When the device fails or has too little memory.
pub fn broken(ctx: &Arc<Context>) -> Result<Vec<Broken>> {
    let numbers = numbers();
    let found = on_device(ctx, &numbers)?;
    Ok(compared(&numbers, &found))
}

/// Every rule that the results break.
#[must_use]
pub fn compared(numbers: &[UVec4], found: &[[Vec4; 6]]) -> Vec<Broken> {
    let mut broken: Vec<Broken> = Vec::new();
    for (&word, found) in numbers.iter().zip(found) {
        let expected = arithmetic(word);
        let both = expected.iter().zip(found);
        let both = both
            .flat_map(|(expected, found)| (expected.to_array().into_iter()).zip(found.to_array()));
        for (rule, (expected, found)) in RULES.iter().zip(both) {
            if expected.to_bits() == found.to_bits() {
                continue;
            }
            match broken.iter_mut().find(|other| other.rule == *rule) {
                Some(other) => other.times += 1,
                None => broken.push(Broken {
                    rule,
                    times: 1,
                    words: word.to_array(),
                    found,
                    expected,
                }),
            }
        }
    }
    broken
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Would catch: a comparison that overlooks a device that contracts, or one number of many.
    #[test]
    fn a_device_that_contracts_is_found() {
        let numbers = numbers();
        let right: Vec<[Vec4; 6]> = numbers.iter().map(|&word| arithmetic(word)).collect();
        assert_eq!(compared(&numbers, &right), []);
        let contracted = numbers.iter().zip(&right).map(|(word, row)| {
            let [x, y, z, _] = word.to_array().map(f32::from_bits);
            let mut row = *row;
            row[0].z = x.mul_add(y, z);
            row
        });
        let contracted: Vec<[Vec4; 6]> = contracted.collect();
        let broken = compared(&numbers, &contracted);
        assert_eq!(broken.len(), 1, "{broken:?}");
        assert_eq!(broken[0].rule, "products and sums are not contracted");
        assert!(broken[0].times > 1000, "{broken:?}");
        let mut one = right;
        one[77][4].y = one[77][4].y.next_up();
        let broken = compared(&numbers, &one);
        assert_eq!((broken.len(), broken[0].times), (1, 1));
        assert_eq!(broken[0].words, numbers[77].to_array());
    }
}
