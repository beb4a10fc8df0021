//! The fixed-point grid that positions in the texture lie on, for all methods but `grid`.
//!
//! Positions are whole numbers of *units*, 2^22 or fewer of them a side. Therefore `origin`, `du` and `dv` of a map are exact in
//! single precision and give all three corners back, triangles agree bitwise on the corners that they share, and all decisions about
//! positions are made in whole numbers: they do not depend on where in the texture a chart is placed.

use glam::{IVec2, Vec2};

use super::super::surface::AtlasMap;

/// Units along the side of the texture, at the most.
const UNITS: u32 = 1 << 22;

/// The grid for one texture size and gutter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Fixed {
    /// Units a texel: a power of two, at least 128.
    pub texel: i32,
    /// The width of a chart's halo, in units: texels within this distance of it along both axes belong to the chart.
    pub reach: i32,
    /// Texels of gutter.
    pub gutter: u32,
}

impl Fixed {
    /// The reach is a little wider than the gutter: kernels compute positions in single precision, from `uv` that may be
    /// outside the triangle by 1e-6.
    pub(super) fn new(size: u32, gutter: u32) -> Self {
        let texel = (UNITS / size.next_power_of_two()) as i32;
        let reach = f64::from(gutter) + 0.02 + 1.2e-6 * f64::from(size);
        // The gutter in the options may be wider than any texture.
        let reach = (reach * f64::from(texel)).ceil().min(f64::from(UNITS));
        Self {
            texel,
            reach: reach as i32,
            gutter,
        }
    }

    /// Texels a unit; exact.
    fn unit(self) -> f32 {
        1.0 / self.texel as f32
    }

    /// The map that puts the corners of a triangle there.
    pub(super) fn map_of(self, [a, b, c]: [IVec2; 3]) -> AtlasMap {
        let unit = self.unit();
        AtlasMap {
            origin: a.as_vec2() * unit,
            du: (b - a).as_vec2() * unit,
            dv: (c - a).as_vec2() * unit,
        }
    }

    /// The corners of a map's triangle.
    pub(super) fn corners_of(self, map: &AtlasMap) -> [IVec2; 3] {
        let units = |position: Vec2| (position * self.texel as f32).round().as_ivec2();
        let origin = units(map.origin);
        [origin, origin + units(map.du), origin + units(map.dv)]
    }
}

/// Twice the signed area of a triangle, positive when it is counter-clockwise.
pub(super) fn twice_area([a, b, c]: [IVec2; 3]) -> i64 {
    let [ab, ac] = [(b - a).as_i64vec2(), (c - a).as_i64vec2()];
    ab.x * ac.y - ab.y * ac.x
}

/// The texel that a chart without a texel centre in it owns, and the triangle that owns it: the texel under the centroid of its largest
/// triangle, of equal ones the first.
pub(super) fn only_texel(
    fixed: Fixed,
    triangles: impl Iterator<Item = (u32, [IVec2; 3])>,
) -> (u32, IVec2) {
    let mut largest: Option<(i64, u32, [IVec2; 3])> = None;
    for (triangle, corners) in triangles {
        let area = twice_area(corners).abs();
        if largest.is_none_or(|(most, ..)| area > most) {
            largest = Some((area, triangle, corners));
        }
    }
    let (_, triangle, [a, b, c]) = largest.expect("a chart has triangles");
    (triangle, (a + b + c).map(|k| k.div_euclid(3 * fixed.texel)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_give_their_corners_back() {
        for size in [1, 37, 1000, 1024, 1025, 32_768] {
            let fixed = Fixed::new(size, 2);
            let far = size as i32 * fixed.texel;
            let corners = [
                IVec2::new(far, 1),
                IVec2::new(3, far - 1),
                IVec2::new(far - 7, far),
            ];
            let map = fixed.map_of(corners);
            assert_eq!(fixed.corners_of(&map), corners, "{size}");
            assert_eq!(
                map.origin + map.du,
                corners[1].as_vec2() / fixed.texel as f32
            );
        }
    }
}
