//! Directions in and across tangent frames. Twin of `shaders/include/direction.glsl`.

use glam::{Vec2, Vec3};

use crate::strict::{cross3, direction2_or, direction3_or};

/// In a triangle's tangent frame: along AB if the vector is too short.
pub(super) fn flat_direction(way: Vec2) -> Vec2 {
    direction2_or(way, Vec2::X)
}

/// Some direction that is at right angles to another one.
pub(super) fn perpendicular(direction: Vec3) -> Vec3 {
    let axis = if direction.x.abs() < 0.5 {
        Vec3::X
    } else {
        Vec3::Y
    };
    direction3_or(cross3(direction, axis), axis)
}
