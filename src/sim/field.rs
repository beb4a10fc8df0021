//! Fields, which have a value for each texel: places in the atlas, reading between texel centres, and filling the gutters.
//! Twin of `shaders/include/field.glsl`, `bilinear.glsl`, `atlas.glsl`, `distances.glsl` and `across.glsl`.

use crate::mesh::surface::{AtlasMap, Seam};
use crate::strict::reciprocal;

/// Atlas position, in texels, of a point on the surface.
#[must_use]
pub fn atlas_position(map: &AtlasMap, u: f32, v: f32) -> [f32; 2] {
    [
        (map.origin.x + u * map.du.x) + v * map.dv.x,
        (map.origin.y + u * map.du.y) + v * map.dv.y,
    ]
}

/// The weights of B and C at an atlas position.
#[must_use]
pub fn weights_at(map: &AtlasMap, position: [f32; 2]) -> [f32; 2] {
    let way = [position[0] - map.origin.x, position[1] - map.origin.y];
    let area = map.du.x * map.dv.y - map.du.y * map.dv.x;
    let by = reciprocal(area);
    [
        (way[0] * map.dv.y - way[1] * map.dv.x) * by,
        (map.du.x * way[1] - map.du.y * way[0]) * by,
    ]
}

/// The texel that holds a point. Negative coordinates and NaN count as 0.
#[must_use]
pub fn texel_at(position: [f32; 2], pitch: u32) -> u32 {
    position[1] as u32 * pitch + position[0] as u32
}

fn parts_of_texel(pitch: u32) -> f32 {
    if pitch > 16384 { 2.0 } else { 4.0 }
}

/// A position packed into a word: quarters of a texel, or halves in the largest atlases.
#[must_use]
pub fn packed_position(position: [f32; 2], pitch: u32) -> u32 {
    let [x, y] = position.map(|x| (x * parts_of_texel(pitch)) as u32);
    x | y << 16
}

/// The middle of that part.
#[must_use]
pub fn unpacked_position(word: u32, pitch: u32) -> [f32; 2] {
    let size = if pitch > 16384 { 0.5 } else { 0.25 };
    [word & 0xffff, word >> 16].map(|x| (x as f32 + 0.5) * size)
}

/// The upper left one of the four texels round a position, and how far right of its centre and below it the position is.
#[must_use]
pub fn blend_at(position: [f32; 2], pitch: u32) -> (usize, [f32; 2]) {
    let corner = position.map(|x| x - 0.5);
    let low = corner.map(f32::floor);
    let texel = low[1] as u32 * pitch + low[0] as u32;
    (texel as usize, [corner[0] - low[0], corner[1] - low[1]])
}

/// Bilinear over the four texels around.
#[must_use]
pub fn trail_at(trail: &[f32], position: [f32; 2], pitch: u32) -> f32 {
    let (texel, f) = blend_at(position, pitch);
    let pitch = pitch as usize;
    let top = trail[texel] + f[0] * (trail[texel + 1] - trail[texel]);
    let bottom = trail[texel + pitch] + f[0] * (trail[texel + pitch + 1] - trail[texel + pitch]);
    top + f[1] * (bottom - top)
}

/// Fills the gutter texels of a field from the owned texels across the seams.
pub fn fill_gutters(seams: &[Seam], field: &mut [f32]) {
    for seam in seams {
        let units = seam.units().map(|units| units as f32);
        let mut value = units[0] * field[seam.source[0] as usize];
        for k in 1..4 {
            value += units[k] * field[seam.source[k] as usize];
        }
        field[seam.texel as usize] = value * (1.0 / Seam::UNITS as f32);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_come_back_from_their_words() {
        for (pitch, off) in [(512, 0.13), (16384, 0.13), (16388, 0.26), (32768, 0.26)] {
            let far = pitch as f32;
            for position in [[0.5, 0.5], [far - 0.1, 3.3], [7.9, far - 0.6]] {
                let back = unpacked_position(packed_position(position, pitch), pitch);
                let [x, y] = [0, 1].map(|k: usize| (back[k] - position[k]).abs());
                assert!(x < off && y < off, "{position:?} of {pitch}: {back:?}");
            }
        }
    }
}
