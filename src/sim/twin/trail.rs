//! Twin of `shaders/include/trail.glsl`, `atlas.glsl`, `distances.glsl` and `across.glsl`: places in the atlas, and
//! reading between texel centres.

use crate::mesh::surface::AtlasMap;

/// Atlas position, in texels, of a point on the surface.
#[must_use]
pub fn atlas_position(map: &AtlasMap, u: f32, v: f32) -> [f32; 2] {
    [
        (map.origin.x + u * map.du.x) + v * map.dv.x,
        (map.origin.y + u * map.du.y) + v * map.dv.y,
    ]
}

/// The texel that holds a point.
#[must_use]
pub fn texel_at(position: [f32; 2], pitch: u32) -> u32 {
    position[1] as u32 * pitch + position[0] as u32
}

/// A position packed into a word: quarters of a texel.
#[must_use]
pub fn packed_position(position: [f32; 2]) -> u32 {
    let [x, y] = position.map(|x| (x * 4.0) as u32);
    x | y << 16
}

/// The middle of that quarter.
#[must_use]
pub fn unpacked_position(word: u32) -> [f32; 2] {
    [word & 0xffff, word >> 16].map(|x| (x as f32 + 0.5) * 0.25)
}

/// Bilinear over the four texels around.
#[must_use]
pub fn trail_at(trail: &[f32], position: [f32; 2], pitch: u32) -> f32 {
    let corner = position.map(|x| x - 0.5);
    let low = corner.map(f32::floor);
    let f = [corner[0] - low[0], corner[1] - low[1]];
    let texel = (low[1] as u32 * pitch + low[0] as u32) as usize;
    let pitch = pitch as usize;
    let top = trail[texel] + f[0] * (trail[texel + 1] - trail[texel]);
    let bottom = trail[texel + pitch] + f[0] * (trail[texel + pitch + 1] - trail[texel + pitch]);
    top + f[1] * (bottom - top)
}
