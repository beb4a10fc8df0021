//! Facts about the surroundings of each texel, packed so that one read returns all. Twin of `shaders/include/surroundings.glsl`.

use super::kernels::UnfoldParams;
use crate::mesh::atlas::{Atlas, Outlooks};
use crate::mesh::surface::NONE;

/// The bits of the outlook: the distance up to which places of the texel's hue can be reached straight, in the atlas's
/// [`outlook_unit`](Atlas::outlook_unit).
pub const OUTLOOK: u16 = 255;
/// A step from here may lead to a place where particles change objects.
pub const NEAR: u16 = 256;
/// Walks that get here continue on another object.
pub const COVERED: u16 = 512;
/// Sensors that walk from here may get to where another object covers the surface.
pub const IN_SIGHT: u16 = 1024;
/// The bits that change when objects move.
pub const MARKS: u16 = NEAR | COVERED | IN_SIGHT;
/// The bits of the hue, which differs between charts that lie near each other.
pub const HUE: u16 = 31 << 11;

/// One per texel, before any distance is known. Texels without an owner have no distances of their own, and count as near.
#[must_use]
pub fn surroundings(atlas: &Atlas, outlooks: &Outlooks) -> Vec<u16> {
    let marks = atlas.owner.iter().map(|&owner| match owner {
        NONE => NEAR | IN_SIGHT,
        _ => 0,
    });
    let looks = outlooks.hues.iter().zip(&outlooks.distances);
    let looks = looks.map(|(&hue, &distance)| u16::from(hue) << 11 | u16::from(distance));
    marks.zip(looks).map(|(marks, look)| marks | look).collect()
}

/// Does the straight path between two such places, of this squared length in texels, stay on the surface? It does if both have the same hue
/// and one end is within the other's outlook.
#[must_use]
pub fn is_clear(length_squared: f32, unit: f32, start: u16, end: u16) -> bool {
    let farthest = unit * f32::from((start & OUTLOOK).max(end & OUTLOOK));
    start & HUE != 0 && (start ^ end) & HUE == 0 && length_squared <= farthest * farthest
}

/// Marks of a texel at a distance: places as deep as `deepest` or deeper, and those not below the threshold,
/// are not covered.
#[must_use]
pub fn marks_at(distance: f32, params: &UnfoldParams) -> u16 {
    let near = if distance < params.near { NEAR } else { 0 };
    let in_sight = if distance < params.sight { IN_SIGHT } else { 0 };
    let is_covered = params.deepest < distance && distance < params.threshold;
    near | in_sight | if is_covered { COVERED } else { 0 }
}
