//! Twin of `shaders/depth_queries.comp` and of `shaders/include/depth.glsl`: from signed distances to depths.

use super::kernels::{DepthQueriesConstants, DepthQueriesParams};

/// By the bits of the float.
pub const DEPTH_ORDERED: u32 = 0;
/// As a projection makes it.
pub const DEPTH_CLIP: u32 = 1;
/// By the logistic curve.
pub const DEPTH_LOGISTIC: u32 = 2;
/// By the arctangent.
pub const DEPTH_ARCTANGENT: u32 = 3;
/// Straight.
pub const DEPTH_LINEAR: u32 = 4;

/// The greatest float below 1.
const BELOW_ONE: f32 = 0.999_999_94;

/// The depths of distances.
pub fn depth_queries(
    constants: &DepthQueriesConstants,
    params: &DepthQueriesParams,
    distances: &[f32],
    depths: &mut [f32],
) {
    for i in 0..params.query_count as usize {
        depths[i] = depth_of(
            constants.depth,
            distances[i],
            params.reach,
            params.near_plane,
            params.scale,
        );
    }
}

/// The depth of a distance by one of the mappings, in [0, 1). The near plane is that of a projection; the scale is what the curves take
/// as 1.
#[must_use]
pub fn depth_of(mapping: u32, distance: f32, reach: f32, near_plane: f32, scale: f32) -> f32 {
    match mapping {
        DEPTH_CLIP => depth_clip(distance, reach, near_plane),
        DEPTH_LOGISTIC => depth_logistic(distance, scale),
        DEPTH_ARCTANGENT => depth_arctangent(distance, scale),
        DEPTH_LINEAR => depth_linear(distance, reach),
        _ => depth_ordered(distance),
    }
}

fn share_of(distance: f32, whole: f32) -> f32 {
    (distance / whole.max(1.0e-30)).clamp(-1.0e30, 1.0e30)
}

fn depth_ordered(distance: f32) -> f32 {
    let bits = distance.to_bits();
    let key = if bits & 0x8000_0000 != 0 {
        !bits
    } else {
        bits ^ 0x8000_0000
    };
    0.5 * f32::from_bits(key >> 2)
}

fn depth_linear(distance: f32, reach: f32) -> f32 {
    let share = share_of(distance, reach).clamp(-1.0, 1.0);
    (0.5 + 0.5 * share).min(BELOW_ONE)
}

fn depth_clip(distance: f32, reach: f32, near_plane: f32) -> f32 {
    let most = reach.max(1.0e-6 * near_plane).max(1.0e-30);
    let way = distance.clamp(-most, most) + most;
    let part = near_plane / (near_plane + way);
    let factor = (near_plane + 2.0 * most) / (2.0 * most);
    ((1.0 - part) * factor).clamp(0.0, BELOW_ONE)
}

/// e to the power of x, |x| up to 80.
fn growth(x: f32) -> f32 {
    let power = std::f32::consts::LOG2_E * x;
    let whole = power.floor();
    let part = power - whole;
    let mut sum: f32 = 1.321_548_7e-6;
    for factor in [
        1.525_273_4e-5,
        1.540_353e-4,
        1.333_355_8e-3,
        9.618_129e-3,
        5.550_411e-2,
        2.402_265e-1,
        std::f32::consts::LN_2,
        1.0,
    ] {
        sum = sum * part + factor;
    }
    f32::from_bits(((whole as i32 + 127) as u32) << 23) * sum.min(2.0)
}

fn depth_logistic(distance: f32, scale: f32) -> f32 {
    let way = -share_of(distance, scale);
    (1.0 / (1.0 + growth(way.clamp(-80.0, 80.0)))).min(BELOW_ONE)
}

/// The arctangent of at most tan(pi / 8).
fn small_angle(x: f32) -> f32 {
    let z = x * x;
    let mut sum: f32 = 8.053_744_5e-2;
    sum = sum * z - 1.387_768_6e-1;
    sum = sum * z + 1.997_771_1e-1;
    sum = sum * z - 3.333_295e-1;
    sum * z * x + x
}

/// The arctangent of x, not negative.
fn angle_of(x: f32) -> f32 {
    use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, FRAC_PI_8};
    const THREE_EIGHTHS: f32 = 1.178_097_2;
    if x < 0.414_213_56 {
        small_angle(x).min(FRAC_PI_8)
    } else if x < 2.414_213_6 {
        let turned = 1.0 - 2.0 / (x + 1.0);
        (FRAC_PI_4 + small_angle(turned)).clamp(FRAC_PI_8, THREE_EIGHTHS)
    } else {
        (FRAC_PI_2 - small_angle(1.0 / x)).max(THREE_EIGHTHS)
    }
}

fn depth_arctangent(distance: f32, scale: f32) -> f32 {
    let way = share_of(distance, scale);
    let half_turns = std::f32::consts::FRAC_1_PI * angle_of(way.abs());
    let depth = if way < 0.0 {
        0.5 - half_turns
    } else {
        0.5 + half_turns
    };
    depth.clamp(0.0, BELOW_ONE)
}
