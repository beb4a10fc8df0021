//! What there is round each texel, so that one look tells all. Twin of `shaders/include/surroundings.glsl`.

use super::kernels::UnfoldParams;
use crate::mesh::atlas::Atlas;
use crate::mesh::surface::NONE;

/// The bits that tell how many half texels far straight lines stay on the surface around.
pub const CLEARANCE: u16 = 255;
/// A step from here may lead to where particles change objects.
pub const NEAR: u16 = 256;
/// Walks that get here go on on another object.
pub const COVERED: u16 = 512;
/// Sensors that walk from here may get to where another object covers the surface.
pub const IN_SIGHT: u16 = 1024;

/// One a texel, before any distance is known. Texels that nobody owns have no distances of their own, and count as near.
#[must_use]
pub fn surroundings(atlas: &Atlas, clearance: &[u8]) -> Vec<u16> {
    let texels = atlas.owner.iter().zip(clearance);
    texels
        .map(|(&owner, &clear)| u16::from(clear) | if owner == NONE { NEAR | IN_SIGHT } else { 0 })
        .collect()
}

/// What a texel at a distance is marked with: places as deep as `deepest` or deeper, and those not below the threshold,
/// are not covered.
#[must_use]
pub fn marks_at(distance: f32, params: &UnfoldParams) -> u16 {
    let near = if distance < params.near { NEAR } else { 0 };
    let in_sight = if distance < params.sight { IN_SIGHT } else { 0 };
    let is_covered = params.deepest < distance && distance < params.threshold;
    near | in_sight | if is_covered { COVERED } else { 0 }
}
