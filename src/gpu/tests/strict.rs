//! Strict arithmetic on the device is that of the host, bit by bit.

use super::selftest::*;
use super::*;
use crate::rng::{Purpose, random};
use crate::strict;
use glam::{UVec4, Vec2, Vec3, Vec4};

/// Bits of numbers of all sizes within the promised range, and of numbers that are near 1.
fn words() -> Vec<UVec4> {
    let of = |i: u32| {
        let words = random(5, i, 0, Purpose::Start);
        UVec4::from_array(words.map(|word| {
            let (sign, mantissa) = (word & 0x8000_0000, word & 0x007f_ffff);
            let spread = if i.is_multiple_of(2) { 4 } else { 60 };
            let exponent = 127 - spread / 2 + (word >> 23 & 0xff) % spread;
            sign | exponent << 23 | mantissa
        }))
    };
    (0..1 << 16).map(of).collect()
}

fn found_by_twins(word: &UVec4) -> [Vec4; 4] {
    let [x, y, z, w] = word.to_array().map(f32::from_bits);
    let (v, u) = (Vec3::new(x, y, z), Vec3::new(y, z, w));
    let turn = strict::turn_of(word.x);
    let direction = strict::direction3_or(v, Vec3::X);
    [
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
    ]
}

#[test]
fn strict_arithmetic_is_that_of_the_host() {
    let Some(ctx) = context() else { return };
    let words = words();
    let pipeline = Pipeline::<Strict>::new(&ctx, &()).unwrap();
    let source = Buffer::from_slice(&ctx, "words", &words).unwrap();
    let target = Buffer::<Vec4>::zeroed(&ctx, "found", 4 * words.len()).unwrap();
    let mut frames = Frames::new(&ctx, 1).unwrap();
    let mut rec = frames.begin().unwrap();
    rec.dispatch(
        &pipeline,
        Threads::of(words.len()),
        StrictArgs {
            words: &source,
            found: &target,
        },
        StrictParams {
            count: words.len() as u32,
        },
    );
    frames.submit(rec).unwrap();
    let found = ctx.download(&target).unwrap();
    for (word, found) in words.iter().zip(found.chunks(4)) {
        let expected = found_by_twins(word);
        for (k, (expected, found)) in expected.iter().zip(found).enumerate() {
            let bits = |v: &Vec4| v.to_array().map(f32::to_bits);
            assert_eq!(
                bits(found),
                bits(expected),
                "{word}, {k}: {found}, and {expected}"
            );
        }
    }
    assert_silent(&ctx);
}
