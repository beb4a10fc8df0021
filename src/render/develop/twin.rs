//! Twins of the kernels that develop a picture: `shaders/bloom_first.comp`, `shaders/bloom_down.comp`, `shaders/bloom_up.comp`,
//! `shaders/develop.comp` and `shaders/smooth_edges.comp`.

use glam::{IVec2, Vec3, ivec2};

use super::{Bloom, Level, Shape};
use crate::strict;

const PER_BYTE: f32 = 1.0 / 255.0;
/// Pixels along an edge that are looked at, each way.
const LONGEST: i32 = 12;
/// Differences from which on an edge is smoothed: of all steps of brightness, and of the brightest pixel, in sixteenths.
const LEAST_STEP: i32 = 40;
const LEAST_SHARE: i32 = 2;

fn bytes_of(word: u32) -> Vec3 {
    let byte = |shift: u32| (word >> shift & 255) as f32;
    Vec3::new(byte(0), byte(8), byte(16))
}

fn brightness_of(word: u32) -> i32 {
    ((word & 255) + 2 * (word >> 8 & 255) + (word >> 16 & 255)) as i32
}

fn seen_of(light: f32) -> f32 {
    1.1 * strict::root(light) - 0.1 * light
}

fn with_bloom(seen: Vec3, alpha: u32, bloom: Vec3, noise: f32) -> u32 {
    let most = bloom.x.max(bloom.y.max(bloom.z));
    let cover = (255.0 - alpha as f32) * most;
    let white = match alpha {
        255 => 255.0,
        _ => 255.0 * seen_of(alpha as f32 * PER_BYTE),
    };
    let mut sum = seen + (Vec3::splat(white) - seen) * bloom;
    if cover > 0.0 {
        let beside = bloom * strict::quotient(255.0 * seen_of(cover * PER_BYTE), most);
        let both = sum * sum + beside * beside;
        sum = Vec3::from_array(both.to_array().map(strict::root));
    }
    let rounded = (sum + Vec3::splat(noise)) + Vec3::splat(0.5);
    let [r, g, b] = rounded.to_array().map(|x| (x as u32).min(255));
    let covered = alpha as f32 + cover;
    r | g << 8 | b << 16 | ((covered + 0.5) as u32).min(255) << 24
}

fn noise_of(x: u32, y: u32) -> f32 {
    let word = (x.wrapping_mul(3_242_174_889)).wrapping_add(y.wrapping_mul(2_447_445_414));
    (word >> 16) as f32 * (0.9 / 65_536.0) - 0.45
}

fn part_way(from: Vec3, to: Vec3, part: f32) -> Vec3 {
    from + (to - from) * part
}

/// Twin of `shaders/bloom_first.comp`; adds the number of marked pixels to `flaws`.
pub fn bloom_first(
    shape: &Shape,
    bloom: &Bloom,
    is_opaque: bool,
    picture: &[u32],
    levels: &mut [Vec3],
    flaws: &mut u32,
) {
    let [width, height] = shape.size;
    for (i, cell) in levels[..shape.levels[0].count()].iter_mut().enumerate() {
        let (column, row) = (i as u32 % shape.across, i as u32 / shape.across);
        let mut sum = Vec3::ZERO;
        let mut marked = 0;
        for y in 0..4 {
            let line = 4 * row + y;
            for x in 0..4 {
                let is_inside = line < height && 4 * column + x < width;
                let word =
                    picture[(line.min(height - 1) * shape.pitch() + 4 * column + x) as usize];
                let seen = bytes_of(word) * PER_BYTE;
                let light = seen * seen;
                let most = light.x.max(light.y.max(light.z));
                let rise = (most - bloom.threshold) * bloom.slope;
                let share = match is_inside {
                    true => strict::within(rise, 0.0, 1.0),
                    false => 0.0,
                };
                sum += light * (share * share);
                marked += u32::from(is_inside && word >> 24 != 255);
            }
        }
        *cell = sum * (1.0 / 16.0);
        *flaws += if is_opaque { marked } else { 0 };
    }
}

fn at(levels: &[Vec3], level: Level, x: i32, y: i32) -> Vec3 {
    let column = x.clamp(0, level.across as i32 - 1) as u32;
    let row = y.clamp(0, level.down as i32 - 1) as u32;
    levels[(level.first + row * level.across + column) as usize]
}

fn mean_of([a, b, c, d]: [Vec3; 4]) -> Vec3 {
    (a + d) * 0.125 + (b + c) * 0.375
}

/// Twin of `shaders/bloom_down.comp`: fills the level after `fine`.
pub fn bloom_down(fine: Level, coarse: Level, levels: &mut [Vec3]) {
    for i in 0..coarse.count() as u32 {
        let (x, y) = (
            2 * (i % coarse.across) as i32,
            2 * (i / coarse.across) as i32,
        );
        let row = |y| mean_of([x - 1, x, x + 1, x + 2].map(|x| at(levels, fine, x, y)));
        levels[(coarse.first + i) as usize] = mean_of([y - 1, y, y + 1, y + 2].map(row));
    }
}

/// Twin of `shaders/bloom_up.comp`: adds the level `coarse` to `fine`.
pub fn bloom_up(
    [fine, coarse]: [Level; 2],
    [kept, spread]: [f32; 2],
    strength: f32,
    is_last: bool,
    levels: &mut [Vec3],
) {
    let between = |near: Vec3, far: Vec3| near * 0.75 + far * 0.25;
    for i in 0..fine.count() as u32 {
        let (column, row) = ((i % fine.across) as i32, (i / fine.across) as i32);
        let (x, y) = (column >> 1, row >> 1);
        let beside_x = if column & 1 == 0 { x - 1 } else { x + 1 };
        let beside_y = if row & 1 == 0 { y - 1 } else { y + 1 };
        let along = |y| between(at(levels, coarse, x, y), at(levels, coarse, beside_x, y));
        let sum = between(along(y), along(beside_y));
        let own = &mut levels[(fine.first + i) as usize];
        *own = (*own * kept + sum * spread) * strength;
        if is_last {
            *own = Vec3::from_array(own.to_array().map(|x| strict::root(x.min(1.0))));
        }
    }
}

/// The bloom at a pixel.
fn bloom_of(shape: &Shape, levels: &[Vec3], place: IVec2) -> Vec3 {
    let finest = shape.levels[0];
    let cell: IVec2 = place >> 2;
    let eighths: IVec2 = 2 * (place & 3) - 3;
    let beside = |axis: usize| cell[axis] + if eighths[axis] < 0 { -1 } else { 1 };
    let [right, down] = [0, 1].map(|axis| eighths[axis].abs() as f32 * 0.125);
    let column = |x| {
        part_way(
            at(levels, finest, x, cell.y),
            at(levels, finest, x, beside(1)),
            down,
        )
    };
    part_way(column(cell.x), column(beside(0)), right)
}

fn word_at(shape: &Shape, picture: &[u32], place: IVec2) -> u32 {
    let [width, height] = shape.size.map(|side| side as i32);
    let inside = place.clamp(IVec2::ZERO, ivec2(width, height) - 1);
    picture[(inside.y as u32 * shape.pitch() + inside.x as u32) as usize]
}

/// Twin of `shaders/develop.comp`: the developed picture, and the pixels at edges. `levels` is empty where there is no bloom.
#[must_use]
pub fn develop(
    shape: &Shape,
    is_opaque: bool,
    picture: &[u32],
    levels: &[Vec3],
) -> (Vec<u32>, Vec<u32>) {
    let pitch = shape.pitch();
    let mut edges = Vec::new();
    let developed = picture.iter().enumerate().map(|(i, &word)| {
        let (x, y) = (i as u32 % pitch, i as u32 / pitch);
        let place = ivec2(x as i32, y as i32);
        let alpha = if is_opaque { 255 } else { word >> 24 };
        let glow = match levels {
            [] => Vec3::ZERO,
            levels => bloom_of(shape, levels, place),
        };
        let around = [(0, 0), (0, -1), (0, 1), (-1, 0), (1, 0)];
        let around = around.map(|(x, y)| {
            let beside = place + ivec2(x, y);
            // Pixels between the picture's edge and the end of the row are never listed.
            let last = ivec2(pitch as i32 - 1, shape.size[1] as i32 - 1);
            let at = beside.clamp(IVec2::ZERO, last);
            brightness_of(picture[(at.y as u32 * pitch + at.x as u32) as usize])
        });
        let most = *around.iter().max().expect("there are five");
        let step = most - *around.iter().min().expect("there are five");
        if x + 1 < shape.size[0] && step >= LEAST_STEP && 16 * step >= LEAST_SHARE * most {
            edges.push(i as u32);
        }
        with_bloom(bytes_of(word), alpha, glow, noise_of(x, y))
    });
    (developed.collect(), edges)
}

/// Twin of `shaders/smooth_edges.comp`.
pub fn smooth_edges(
    shape: &Shape,
    is_opaque: bool,
    edges: &[u32],
    picture: &[u32],
    levels: &[Vec3],
    developed: &mut [u32],
) {
    for &pixel in edges {
        let place = ivec2(
            (pixel % shape.pitch()) as i32,
            (pixel / shape.pitch()) as i32,
        );
        let word_at = |place: IVec2| word_at(shape, picture, place);
        let bright = |x: i32, y: i32| brightness_of(word_at(place + ivec2(x, y)));
        let bend = |a: i32, b: i32, middle: i32| (a + b - 2 * middle).abs();
        let own = bright(0, 0);
        let (above, below, left, right) =
            (bright(0, -1), bright(0, 1), bright(-1, 0), bright(1, 0));
        let [left_above, right_above] = [bright(-1, -1), bright(1, -1)];
        let [left_below, right_below] = [bright(-1, 1), bright(1, 1)];
        let changes_down = 2 * bend(above, below, own)
            + bend(left_above, left_below, left)
            + bend(right_above, right_below, right);
        let changes_across = 2 * bend(left, right, own)
            + bend(left_above, right_above, above)
            + bend(left_below, right_below, below);
        let is_level = changes_down >= changes_across;
        let (along, across) = match is_level {
            true => (IVec2::X, IVec2::Y),
            false => (IVec2::Y, IVec2::X),
        };
        let (before, after) = if is_level {
            (above, below)
        } else {
            (left, right)
        };
        let is_before = (before - own).abs() >= (after - own).abs();
        let (other, side) = match is_before {
            true => (before, -across),
            false => (after, across),
        };
        let contrast = (other - own).abs();
        let length = |along: IVec2| {
            let mut end = 0;
            for k in 1..=LONGEST {
                let at = k * along;
                let beside = at + side;
                end = bright(at.x, at.y) + bright(beside.x, beside.y) - (own + other);
                if 2 * end.abs() >= contrast {
                    return (k, end);
                }
            }
            (LONGEST, end)
        };
        let (back, end_back) = length(-along);
        let (ahead, end_ahead) = length(along);
        let end = if back < ahead { end_back } else { end_ahead };
        let is_reached = contrast > 0 && (end < 0) != (own - other < 0);
        let part = 0.5 - strict::quotient(back.min(ahead) as f32, (back + ahead) as f32);
        let share = if is_reached { part } else { 0.0 };
        let (word, beyond) = (word_at(place), word_at(place + side));
        let seen = part_way(bytes_of(word), bytes_of(beyond), share);
        let [alpha, other_alpha] = [word, beyond].map(|word| Vec3::splat((word >> 24) as f32));
        let alpha = (part_way(alpha, other_alpha, share).x + 0.5) as u32;
        let alpha = if is_opaque { 255 } else { alpha };
        let glow = match levels {
            [] => Vec3::ZERO,
            levels => bloom_of(shape, levels, place),
        };
        let noise = noise_of(place.x as u32, place.y as u32);
        developed[pixel as usize] = with_bloom(seen, alpha, glow, noise);
    }
}
