//! How gutter texels are filled, for any layout.
//!
//! A gutter texel is a place beyond its chart's border. From the border point nearest to it, just inside, a straight
//! walk goes the way that the chart's map says, over the seam and on; where it ends, the trail is read bilinearly.
//! Texels of that read that are themselves gutter texels are replaced by their own rows, again and again, until only
//! owned texels remain. Open borders reflect the walk; at vertices the edge that the walk meets decides.

use glam::{DVec2, Vec2};
use rayon::prelude::*;

use super::super::surface::{AtlasMap, NONE, Seam, Surface};
use super::super::walk::{BorderRule, Frame, SurfacePoint, walk};
use super::rows::{Row, Rows, Taps};
use super::{GutterTexel, Layout};

/// How far inside its triangle a walk starts, as a share of the way to the centroid. Exactly on the border the walk
/// would meet that edge at distance 0, and a vertex would be on two edges at once.
const INSET: f64 = 1e-6;

/// A gutter may reach over many small triangles; a walk that goes on for longer than this reads where it stands.
const MAX_CROSSINGS: u32 = 4096;

/// Lighter taps are dropped: the margin that the maps keep makes such taps where a walk really ends on a texel's
/// centre.
const LEAST_TAP: f64 = 1.0 / 256.0;

/// An [`AtlasMap`] in double precision, with its inverse.
#[derive(Clone, Copy, Debug)]
pub(super) struct Affine {
    origin: DVec2,
    du: DVec2,
    dv: DVec2,
}

impl Affine {
    pub(super) fn of(map: &AtlasMap) -> Self {
        Self {
            origin: map.origin.as_dvec2(),
            du: map.du.as_dvec2(),
            dv: map.dv.as_dvec2(),
        }
    }

    fn position_of(&self, uv: DVec2) -> DVec2 {
        self.origin + uv.x * self.du + uv.y * self.dv
    }

    /// Whether the triangle has area in the texture; without, no `uv` belongs to a position.
    fn has_area(&self) -> bool {
        self.du.perp_dot(self.dv) != 0.0
    }

    /// Of a triangle with area in the texture.
    fn uv_of(&self, position: DVec2) -> DVec2 {
        let offset = position - self.origin;
        DVec2::new(offset.perp_dot(self.dv), self.du.perp_dot(offset)) / self.du.perp_dot(self.dv)
    }

    /// The `uv` of the point of the triangle that is nearest to a position, in texels.
    pub(super) fn nearest_uv(&self, position: DVec2) -> DVec2 {
        if self.has_area() {
            let uv = self.uv_of(position);
            if uv.min_element() >= 0.0 && uv.x + uv.y <= 1.0 {
                return uv;
            }
        }
        self.nearest_border_point(position)
    }

    /// The distance of the triangle from a position, in texels.
    pub(super) fn distance(&self, position: DVec2) -> f64 {
        (self.position_of(self.nearest_uv(position)) - position).length()
    }

    /// The `uv` of the point of the triangle's border that is nearest to a position, in texels.
    fn nearest_border_point(&self, position: DVec2) -> DVec2 {
        let corners = [DVec2::ZERO, DVec2::X, DVec2::Y];
        let mut nearest = (DVec2::ZERO, f64::INFINITY);
        for corner in 0..3 {
            let (start, end) = (corners[corner], corners[(corner + 1) % 3]);
            let (a, b) = (self.position_of(start), self.position_of(end));
            let squared = (b - a).length_squared();
            let along = match squared {
                0.0 => 0.0,
                _ => ((position - a).dot(b - a) / squared).clamp(0.0, 1.0),
            };
            let distance = (a + along * (b - a) - position).length_squared();
            if distance < nearest.1 {
                nearest = (start + along * (end - start), distance);
            }
        }
        nearest.0
    }
}

/// One row for each gutter texel of a layout, in the same order.
///
/// # Panics
/// When a read anywhere on the surface touches a texel that is neither owned nor gutter: then the layout is wrong.
pub(super) fn seams(surface: &Surface, layout: &Layout, pitch: u32) -> Vec<Seam> {
    let finder = Finder::new(&layout.gutter_texels, pitch, layout.owner.len());
    let taps: Vec<Taps> = layout
        .gutter_texels
        .par_iter()
        .map(|&gutter_texel| {
            let position = unfold(surface, &layout.maps, pitch, gutter_texel);
            read_at(position, pitch, &layout.owner, &finder)
        })
        .collect();
    let rows = Rows::resolve(&taps);
    layout
        .gutter_texels
        .par_iter()
        .enumerate()
        .map(|(k, &gutter_texel)| {
            let row = rows.row(k as u32);
            if row.is_empty() {
                Row::one(nearest_owned(layout, pitch, gutter_texel)).into_seam(gutter_texel.texel)
            } else {
                row.into_seam(gutter_texel.texel)
            }
        })
        .collect()
}

/// The owned texel of the same chart that is nearest along both axes: for gutter texels whose reads go round among gutter
/// texels for ever, in charts that are narrower than a texel.
fn nearest_owned(layout: &Layout, pitch: u32, gutter_texel: GutterTexel) -> u32 {
    let chart = layout.chart[gutter_texel.triangle as usize];
    let side = (layout.owner.len() / pitch as usize) as i64;
    let [x, y] = [gutter_texel.texel % pitch, gutter_texel.texel / pitch].map(i64::from);
    let owns = |x: i64, y: i64| {
        let inside = (0..side).contains(&x) && (0..side).contains(&y);
        let owner = if inside {
            layout.owner[(y * i64::from(pitch) + x) as usize]
        } else {
            NONE
        };
        owner != NONE && layout.chart[owner as usize] == chart
    };
    for ring in 1..side {
        for k in -ring..=ring {
            let places = [
                (x + k, y - ring),
                (x + k, y + ring),
                (x - ring, y + k),
                (x + ring, y + k),
            ];
            if let Some((x, y)) = places.into_iter().find(|&(x, y)| owns(x, y)) {
                return (y * i64::from(pitch) + x) as u32;
            }
        }
    }
    unreachable!("chart {chart} owns no texel");
}

/// Where in the texture the surface is that lies under a gutter texel's centre when its chart is carried on.
fn unfold(surface: &Surface, maps: &[AtlasMap], pitch: u32, gutter_texel: GutterTexel) -> DVec2 {
    let GutterTexel { texel, triangle } = gutter_texel;
    let centre = Vec2::new((texel % pitch) as f32, (texel / pitch) as f32).as_dvec2() + 0.5;
    let map = Affine::of(&maps[triangle as usize]);
    let border = map.nearest_border_point(centre);
    if !map.has_area() {
        // Its whole chart has none: there is no direction to walk in.
        return map.position_of(border);
    }
    let inside = border + INSET * (DVec2::splat(1.0 / 3.0) - border);
    let offset = map.uv_of(centre) - inside;
    let step = Frame::of(surface, triangle).position(offset.x, offset.y);
    let length = step.length();
    if !(length > 0.0 && length.is_finite()) {
        return map.position_of(border);
    }
    let start = SurfacePoint {
        triangle,
        u: inside.x,
        v: inside.y,
    };
    let end = walk(
        surface,
        start,
        step / length,
        length,
        Some(MAX_CROSSINGS),
        BorderRule::Reflect,
    )
    .point;
    Affine::of(&maps[end.triangle as usize]).position_of(DVec2::new(end.u, end.v))
}

/// Finds the place of a gutter texel in the ascending list of them.
struct Finder<'a> {
    gutter_texels: &'a [GutterTexel],
    pitch: u32,
    /// Per row of the texture: where it starts in the list; and the list's length.
    row_starts: Vec<usize>,
}

impl<'a> Finder<'a> {
    fn new(gutter_texels: &'a [GutterTexel], pitch: u32, texel_count: usize) -> Self {
        let row_starts = (0..=texel_count as u32 / pitch)
            .map(|y| gutter_texels.partition_point(|g| g.texel < y * pitch))
            .collect();
        Self {
            gutter_texels,
            pitch,
            row_starts,
        }
    }

    fn find(&self, texel: u32) -> Option<u32> {
        let y = (texel / self.pitch) as usize;
        let start = *self.row_starts.get(y)?;
        let row = &self.gutter_texels[start..*self.row_starts.get(y + 1)?];
        let found = row.binary_search_by_key(&texel, |g| g.texel).ok()?;
        Some((start + found) as u32)
    }
}

/// The texels that a bilinear read at a position of the texture touches.
fn read_at(position: DVec2, pitch: u32, owner: &[u32], finder: &Finder) -> Taps {
    let mut taps = Taps::default();
    let corner = (position - 0.5).floor();
    let far = position - 0.5 - corner;
    for (x, y) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let along = |far: f64, k: u32| if k == 1 { far } else { 1.0 - far };
        let weight = along(far.x, x) * along(far.y, y);
        if weight < LEAST_TAP {
            continue;
        }
        // Every texel read is in the texture: charts have a gutter all round.
        let texel = (corner.y as u32 + y) * pitch + corner.x as u32 + x;
        if owner[texel as usize] != NONE {
            taps.push_owned(texel, weight as f32);
        } else if let Some(index) = finder.find(texel) {
            taps.push_gutter(index, weight as f32);
        } else {
            panic!("texel {texel}, read at {position}, is neither owned nor gutter");
        }
    }
    taps
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unfolding_follows_the_surface_round_an_edge() {
        // Two triangles of equal height, in charts of different size.
        let mesh = crate::mesh::primitive::cube(1);
        let surface = Surface::build(&[(&mesh, 1.0)]);
        let twin = surface.halfedges[1].twin;
        let mut maps = vec![
            AtlasMap {
                origin: Vec2::ZERO,
                du: Vec2::X,
                dv: Vec2::Y
            };
            12
        ];
        maps[0] = AtlasMap {
            origin: Vec2::splat(4.0),
            du: Vec2::new(8.0, 0.0),
            dv: Vec2::new(0.0, 8.0),
        };
        // Its centre is beyond edge 1, the hypotenuse; the weight of corner 0 says how far.
        let gutter_texel = GutterTexel {
            texel: 8 * 64 + 8,
            triangle: 0,
        };
        let outside = (8.5 - 4.0) / 8.0 * 2.0 - 1.0;
        let end = unfold(&surface, &maps, 64, gutter_texel);
        let uv = Affine::of(&maps[twin as usize / 3]).uv_of(end);
        // The weight of the twin's apex is how far behind the shared edge the walk ended.
        let weights = [1.0 - uv.x - uv.y, uv.x, uv.y];
        let apex = weights[(twin as usize % 3 + 2) % 3];
        assert!((apex - outside).abs() < 1e-5, "{apex} instead of {outside}");
    }
}
