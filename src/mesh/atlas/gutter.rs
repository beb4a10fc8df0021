//! How gutter texels are filled, for any layout.
//!
//! A gutter texel is a place beyond its chart's border. A straight walk begins at the border point nearest to it, just inside, and goes
//! over the seam in the direction to the texel by the chart's map; at its end the trail is read bilinearly. Texels of that read that are
//! themselves gutter texels are replaced by their own rows, again and again, until only owned texels remain. Open borders reflect the walk;
//! at a vertex it crosses the edge that it meets first.

use std::sync::OnceLock;

use glam::{DMat2, DVec2, Mat2, Vec2};
use rayon::prelude::*;

use super::super::surface::{AtlasMap, NONE, Seam, Surface};
use super::super::walk::{BorderRule, Frame, SurfacePoint, WalkStatus, walk};
use super::rows::{Rows, Taps};
use super::{AtlasError, Control, GutterTexel, Layout};

/// How far inside its triangle a walk starts, as a share of the way to the centroid. Exactly on the border the walk
/// would meet that edge at distance 0, and a vertex would be on two edges at once.
const INSET: f64 = 1e-6;

/// A gutter may reach over many small triangles; a walk with more crossings than this reads at the place it has reached. In a sliver
/// between open borders it would be reflected thousands of times.
const MAX_CROSSINGS: u32 = 512;

/// Lighter taps are dropped: the margin of the maps causes such taps where a walk ends on a texel's centre.
const LEAST_TAP: f64 = 1.0 / 256.0;

/// Within so many texels of a gutter texel the nearest owned one is searched directly; farther ones are found by a flood fill.
const NEAR: i64 = 8;

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

    /// Does the triangle have area in the texture? Without, a position has no `uv`.
    fn has_area(&self) -> bool {
        self.du.perp_dot(self.dv) != 0.0
    }

    /// The uv of a position, for a triangle with area in the texture.
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

    /// The direction of the edge that a point of the border is on.
    fn edge_at(&self, uv: DVec2) -> DVec2 {
        let weights = [1.0 - uv.x - uv.y, uv.x, uv.y];
        let opposite = (0..3).min_by(|&i, &j| weights[i].total_cmp(&weights[j]));
        let edge = [self.dv - self.du, self.dv, self.du][opposite.unwrap_or(0)];
        edge.normalize_or_zero()
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

/// How the surface beyond a chart's border continues the chart, at a gutter texel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Way {
    /// Texture position of the surface point under the gutter texel's centre, texels.
    pub position: Vec2,
    /// The chart there; [`NONE`] if the walk was reflected or had no direction.
    pub chart: u32,
    /// From steps there to steps in the gutter texel's chart, texels.
    pub back: Mat2,
    /// The direction of the open border that reflected the walk, in the gutter texel's chart; otherwise zero.
    pub border: Vec2,
}

/// One row for each gutter texel of a layout, in the same order, and the way to the texels that fill it.
///
/// # Errors
/// [`AtlasError::Cancelled`].
///
/// # Panics
/// When a read anywhere on the surface touches a texel that is neither owned nor gutter: then the layout is wrong.
pub(super) fn seams(
    surface: &Surface,
    layout: &Layout,
    pitch: u32,
    control: &Control<'_>,
) -> Result<(Vec<Seam>, Vec<Way>), AtlasError> {
    control.step("filling gutters", 0.75)?;
    let finder = Finder::new(&layout.gutter_texels, pitch, layout.owner.len());
    let (taps, ways): (Vec<Taps>, Vec<Way>) = layout
        .gutter_texels
        .par_iter()
        .map(|&gutter_texel| {
            control.check()?;
            let unfolded = unfold(surface, &layout.maps, pitch, gutter_texel);
            let taps = read_at(unfolded.position, pitch, &layout.owner, &finder);
            Ok((taps, unfolded.way(&layout.chart)))
        })
        .collect::<Result<_, AtlasError>>()?;
    let far = OnceLock::new();
    let rows = Rows::resolve(&taps, control, |k| {
        nearest_owned(layout, pitch, layout.gutter_texels[k as usize], NEAR)
            .unwrap_or_else(|| far.get_or_init(|| flooded(layout, pitch, &finder))[k as usize])
    })?;
    let seams = layout
        .gutter_texels
        .par_iter()
        .enumerate()
        .map(|(k, gutter_texel)| rows.row(k as u32).into_seam(gutter_texel.texel))
        .collect();
    Ok((seams, ways))
}

/// The owned texel of the same chart that is nearest along both axes, if one is within so many texels.
fn nearest_owned(
    layout: &Layout,
    pitch: u32,
    gutter_texel: GutterTexel,
    farthest: i64,
) -> Option<u32> {
    let chart = layout.chart[gutter_texel.triangle as usize];
    let side = (layout.owner.len() / pitch as usize) as i64;
    let [x, y] = [gutter_texel.texel % pitch, gutter_texel.texel / pitch].map(i64::from);
    let owned = |x: i64, y: i64| {
        if !(0..side).contains(&x) || !(0..side).contains(&y) {
            return None;
        }
        let texel = (y * i64::from(pitch) + x) as u32;
        let owner = layout.owner[texel as usize];
        (owner != NONE && layout.chart[owner as usize] == chart).then_some(texel)
    };
    (1..=farthest).find_map(|ring| {
        (-ring..=ring).find_map(|k| {
            owned(x + k, y - ring)
                .or_else(|| owned(x + k, y + ring))
                .or_else(|| owned(x - ring, y + k))
                .or_else(|| owned(x + ring, y + k))
        })
    })
}

/// For every gutter texel an owned one of the same chart, about the nearest: a flood fill from all owned texels at once, through the
/// gutter. A sliver's gutter may be thousands of texels long, and its only owned texel at one end.
fn flooded(layout: &Layout, pitch: u32, finder: &Finder) -> Vec<u32> {
    let gutter_texels = &layout.gutter_texels;
    let chart_of = |k: u32| layout.chart[gutter_texels[k as usize].triangle as usize];
    let mut found = vec![NONE; gutter_texels.len()];
    let mut reached = Vec::new();
    for (k, &gutter_texel) in gutter_texels.iter().enumerate() {
        if let Some(texel) = nearest_owned(layout, pitch, gutter_texel, 1) {
            found[k] = texel;
            reached.push(k as u32);
        }
    }
    let mut next = 0;
    while next < reached.len() {
        let from = reached[next];
        next += 1;
        let texel = gutter_texels[from as usize].texel;
        let [x, y] = [texel % pitch, texel / pitch];
        for y in y.saturating_sub(1)..=y + 1 {
            for x in x.saturating_sub(1)..=(x + 1).min(pitch - 1) {
                let Some(to) = finder.find(y * pitch + x) else {
                    continue;
                };
                if found[to as usize] == NONE && chart_of(to) == chart_of(from) {
                    found[to as usize] = found[from as usize];
                    reached.push(to);
                }
            }
        }
    }
    if reached.len() < found.len() {
        // If the chart has disconnected parts, any of its texels.
        let mut any = vec![NONE; layout.chart_count as usize];
        for (texel, &owner) in layout.owner.iter().enumerate() {
            if owner != NONE {
                any[layout.chart[owner as usize] as usize] = texel as u32;
            }
        }
        for k in 0..found.len() as u32 {
            if found[k as usize] == NONE {
                found[k as usize] = any[chart_of(k) as usize];
            }
        }
    }
    found
}

/// The end of a walk over a chart's border.
struct Unfolded {
    /// In the texture.
    position: DVec2,
    triangle: u32,
    /// Maps steps in the chart where it begins to steps in the chart where it ends, texels.
    turn: DMat2,
    /// The direction of the open border that reflected it, in the chart where it begins; or zero.
    border: DVec2,
}

impl Unfolded {
    fn way(&self, chart: &[u32]) -> Way {
        let back = self.turn.inverse().as_mat2();
        let direct = self.border == DVec2::ZERO && back.is_finite();
        Way {
            position: self.position.as_vec2(),
            chart: if direct {
                chart[self.triangle as usize]
            } else {
                NONE
            },
            back,
            border: self.border.as_vec2(),
        }
    }
}

/// Texture position of the surface point under a gutter texel's centre, with the chart continued.
fn unfold(surface: &Surface, maps: &[AtlasMap], pitch: u32, gutter_texel: GutterTexel) -> Unfolded {
    let GutterTexel { texel, triangle } = gutter_texel;
    let centre = Vec2::new((texel % pitch) as f32, (texel / pitch) as f32).as_dvec2() + 0.5;
    let map = Affine::of(&maps[triangle as usize]);
    let border = map.nearest_border_point(centre);
    let standing = Unfolded {
        position: map.position_of(border),
        triangle,
        turn: DMat2::ZERO,
        border: DVec2::ZERO,
    };
    if !map.has_area() {
        // No triangle of its chart has area, so there is no direction to walk in.
        return standing;
    }
    let inside = border + INSET * (DVec2::splat(1.0 / 3.0) - border);
    let offset = map.uv_of(centre) - inside;
    let frame = Frame::of(surface, triangle);
    let step = frame.position(offset.x, offset.y);
    let length = step.length();
    if !(length > 0.0 && length.is_finite()) {
        return standing;
    }
    let start = SurfacePoint {
        triangle,
        u: inside.x,
        v: inside.y,
    };
    let heading = step / length;
    let walk = |rule| walk(surface, start, heading, length, Some(MAX_CROSSINGS), rule);
    let stopped = walk(BorderRule::Stop);
    if stopped.status == WalkStatus::Border {
        let end = walk(BorderRule::Reflect).point;
        let at = Affine::of(&maps[stopped.point.triangle as usize]);
        return Unfolded {
            position: Affine::of(&maps[end.triangle as usize])
                .position_of(DVec2::new(end.u, end.v)),
            triangle: end.triangle,
            border: at.edge_at(DVec2::new(stopped.point.u, stopped.point.v)),
            ..standing
        };
    }
    let end = stopped.point;
    let there = Affine::of(&maps[end.triangle as usize]);
    // The walk is straight on the surface, so a step is rotated like the walk's heading.
    let rotation = DVec2::new(
        heading.dot(stopped.heading),
        heading.perp_dot(stopped.heading),
    );
    let end_frame = Frame::of(surface, end.triangle);
    let carried = |step: DVec2| {
        let uv = map.uv_of(map.origin + step);
        let rate = end_frame.uv_rate(rotation.rotate(frame.position(uv.x, uv.y)));
        rate.x * there.du + rate.y * there.dv
    };
    Unfolded {
        position: there.position_of(DVec2::new(end.u, end.v)),
        triangle: end.triangle,
        turn: DMat2::from_cols(carried(DVec2::X), carried(DVec2::Y)),
        border: DVec2::ZERO,
    }
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
    fn distances_do_not_depend_on_the_way_round() {
        let map = AtlasMap {
            origin: Vec2::splat(4.0),
            du: Vec2::new(8.0, 0.0),
            dv: Vec2::new(0.0, 8.0),
        };
        let mirrored = AtlasMap {
            du: map.dv,
            dv: map.du,
            ..map
        };
        for (x, y, distance) in [
            (6.0, 6.0, 0.0),
            (4.0, 12.0, 0.0),
            (6.0, 1.0, 3.0),
            (1.0, 0.0, 5.0),
        ] {
            for map in [map, mirrored] {
                let found = Affine::of(&map).distance(DVec2::new(x, y));
                assert!((found - distance).abs() < 1e-12, "{x} {y}: {found}");
            }
        }
    }

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
        let end = unfold(&surface, &maps, 64, gutter_texel).position;
        let uv = Affine::of(&maps[twin as usize / 3]).uv_of(end);
        // The weight of the twin's apex is how far behind the shared edge the walk ended.
        let weights = [1.0 - uv.x - uv.y, uv.x, uv.y];
        let apex = weights[(twin as usize % 3 + 2) % 3];
        assert!((apex - outside).abs() < 1e-5, "{apex} instead of {outside}");
    }
}
