//! Directions of vectors that may have no length. Twin of `shaders/include/direction.glsl`.

use glam::{Vec2, Vec3};

/// The smallest number that every device calculates with: a smaller square may count as zero.
pub(super) const LEAST_SQUARE: f32 = f32::MIN_POSITIVE;

/// The direction of a vector, or another one if the vector is too short to have one.
pub(super) fn direction_or(way: Vec3, other: Vec3) -> Vec3 {
    if way.length_squared() >= LEAST_SQUARE {
        way.normalize()
    } else {
        other
    }
}

/// In a triangle's tangent frame: along AB if the vector is too short.
pub(super) fn flat_direction(way: Vec2) -> Vec2 {
    if way.length_squared() >= LEAST_SQUARE {
        way.normalize()
    } else {
        Vec2::X
    }
}

/// Some direction that is at right angles to another one.
pub(super) fn perpendicular(direction: Vec3) -> Vec3 {
    let axis = if direction.x.abs() < 0.5 {
        Vec3::X
    } else {
        Vec3::Y
    };
    direction.cross(axis).normalize()
}
