//! Pictures of a layout: a colour for each chart, and the atlas texel by texel.
//!
//! Charts that touch, on the surface or in the texture, get different colours. A gutter is a darker shade of its chart;
//! edges at which charts end are drawn as light lines, open borders of the surface as amber ones.

use glam::{DVec2, Vec2};
use image::RgbaImage;
use rayon::prelude::*;

use crate::mesh::atlas::Atlas;
use crate::mesh::surface::{AtlasMap, NONE, Surface};

/// Red, green and blue as the eye sees them (sRGB).
type Color = [u8; 3];

/// Hues 30 degrees apart in OKLCH, of two alternating lightnesses, all of low chroma.
const PALETTE: [Color; 12] = [
    [99, 187, 192],
    [176, 119, 87],
    [140, 172, 225],
    [137, 139, 76],
    [195, 154, 204],
    [75, 151, 126],
    [219, 149, 149],
    [74, 144, 176],
    [199, 165, 108],
    [133, 125, 182],
    [142, 184, 133],
    [173, 113, 141],
];
const UNUSED: Color = [22, 23, 26];
const SEAM: Color = [244, 242, 235];
const BORDER: Color = [255, 196, 84];
const EDGE: Color = [30, 31, 35];
/// The share of its chart's light that a gutter has.
const GUTTER_LIGHT: f32 = 0.42;
/// The largest opacity of lines.
const SEAM_STRENGTH: f32 = 0.75;
const EDGE_STRENGTH: f32 = 0.4;
/// Edges of triangles that are smaller than this, in pixels, fade out: they would only be noise.
const EDGE_FADES: (f32, f32) = (1.8, 5.0);
/// Seams of charts that are smaller than this, in pixels along their side, fade out.
const SEAM_FADES: (f32, f32) = (5.0, 16.0);
/// The window's atlas shows no triangle edges beyond this size: they take the longest to draw, and at such sizes a
/// picture from afar shows none.
const EDGES_UP_TO: u32 = 4096;

/// Values of a pixel's last byte before it becomes alpha.
mod kind {
    pub const OWNED: u8 = 255;
    pub const OWNED_LINE: u8 = 254;
    pub const GUTTER: u8 = 128;
    pub const GUTTER_LINE: u8 = 127;
    pub const UNUSED: u8 = 0;
}

/// The atlas as a picture: each texel is a square of `scale` pixels.
///
/// # Panics
/// When a side would have more than `u32::MAX` pixels.
#[must_use]
pub fn picture(surface: &Surface, atlas: &Atlas, scale: u32) -> RgbaImage {
    let side = atlas
        .size
        .checked_mul(scale)
        .expect("the picture has a size");
    let painter = Painter {
        surface,
        atlas,
        colors: &chart_colors(surface, atlas),
        scale,
        pitch: side,
        edges: true,
    };
    let mut pixels = painter.paint();
    pixels.par_iter_mut().for_each(|pixel| pixel[3] = 255);
    RgbaImage::from_raw(side, side, pixels.into_flattened()).expect("a pixel for each")
}

/// Colours of charts for the device: a word for each texel, rows of `atlas.pitch`; red in the lowest byte, and in the highest 0
/// for unused texels, about 128 for gutter ones, and about 255 for owned ones.
pub(super) fn texel_words(surface: &Surface, atlas: &Atlas, colors: &[Color]) -> Vec<u32> {
    let painter = Painter {
        surface,
        atlas,
        colors,
        scale: 1,
        pitch: atlas.pitch,
        edges: atlas.size <= EDGES_UP_TO,
    };
    painter
        .paint()
        .into_par_iter()
        .map(u32::from_le_bytes)
        .collect()
}

/// For each triangle: its chart's colour, red in the lowest byte, and in bits 24 to 26 which of its edges are seams.
pub(super) fn triangle_words(surface: &Surface, atlas: &Atlas, colors: &[Color]) -> Vec<u32> {
    (0..atlas.chart.len() as u32)
        .into_par_iter()
        .map(|t| {
            let [r, g, b] = colors[atlas.chart[t as usize] as usize];
            let seams = (0..3).map(|k| u8::from(atlas.is_seam(surface, 3 * t + k)) << k);
            u32::from_le_bytes([r, g, b, seams.sum()])
        })
        .collect()
}

/// A colour for each chart. Charts beside each other get different ones, as far as there are enough.
#[must_use]
pub fn chart_colors(surface: &Surface, atlas: &Atlas) -> Vec<[u8; 3]> {
    let count = atlas.chart_count as usize;
    let beside = neighbours(surface, atlas);
    let starts: Vec<usize> = (0..=count as u32)
        .map(|chart| beside.partition_point(|&(a, _)| a < chart))
        .collect();
    // Those with the most neighbours first (Welsh and Powell 1967).
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by_key(|&chart| std::cmp::Reverse(starts[chart + 1] - starts[chart]));
    let mut color = vec![usize::MAX; count];
    let mut used = [0_usize; PALETTE.len()];
    for chart in order {
        let mut near = [0_usize; PALETTE.len()];
        for &(_, other) in &beside[starts[chart]..starts[chart + 1]] {
            if let Some(near) = near.get_mut(color[other as usize]) {
                *near += 1;
            }
        }
        let best = (0..PALETTE.len()).min_by_key(|&c| (near[c], used[c]));
        color[chart] = best.expect("there are colours");
        used[color[chart]] += 1;
    }
    color.into_iter().map(|c| PALETTE[c]).collect()
}

/// Pairs of neighbouring charts, on the surface or in the texture: both ways, sorted, each once.
fn neighbours(surface: &Surface, atlas: &Atlas) -> Vec<(u32, u32)> {
    /// Charts share long borders, so a sample of texels finds all neighbours.
    const MOST_LOOKED_AT: usize = 200_000;
    let over_edges = (0..surface.halfedges.len()).into_par_iter().map(|h| {
        let twin = surface.halfedges[h].twin;
        let other = if twin == NONE { h } else { twin as usize };
        (atlas.chart[h / 3], atlas.chart[other / 3])
    });
    let stride = atlas.gutter_texels.len().div_ceil(MOST_LOOKED_AT).max(1);
    let chart_at = |x: u32, y: u32| {
        if x >= atlas.size || y >= atlas.size {
            return None;
        }
        let texel = y * atlas.pitch + x;
        let triangle = match atlas.owner[texel as usize] {
            NONE => {
                let found = atlas
                    .gutter_texels
                    .binary_search_by_key(&texel, |g| g.texel);
                atlas.gutter_texels[found.ok()?].triangle
            }
            owner => owner,
        };
        Some(atlas.chart[triangle as usize])
    };
    let over_texels = atlas
        .gutter_texels
        .par_iter()
        .step_by(stride)
        .flat_map_iter(|gutter| {
            let own = atlas.chart[gutter.triangle as usize];
            let (x, y) = (gutter.texel % atlas.pitch, gutter.texel / atlas.pitch);
            // Slightly farther ones, too, which look like neighbours.
            [1, 2, 4, 8, 16]
                .into_iter()
                .flat_map(|away| [(away, 0), (0, away)])
                .filter_map(move |(dx, dy)| Some((own, chart_at(x + dx, y + dy)?)))
        });
    let mut pairs: Vec<(u32, u32)> = over_edges
        .chain(over_texels)
        .filter(|(a, b)| a != b)
        .flat_map_iter(|(a, b)| [(a, b), (b, a)])
        .collect();
    pairs.par_sort_unstable();
    pairs.dedup();
    pairs
}

struct Painter<'a> {
    surface: &'a Surface,
    atlas: &'a Atlas,
    /// One per chart.
    colors: &'a [Color],
    /// Pixels a texel.
    scale: u32,
    /// Pixels from one row to the next.
    pitch: u32,
    /// Draw the edges of triangles?
    edges: bool,
}

impl Painter<'_> {
    fn paint(&self) -> Vec<[u8; 4]> {
        let side = self.atlas.size * self.scale;
        let mut pixels = vec![with_kind(UNUSED, kind::UNUSED); self.pitch as usize * side as usize];
        pixels
            .par_chunks_mut(self.pitch as usize)
            .zip(0..side)
            .for_each(|(row, y)| {
                for (x, pixel) in (0..side).zip(row) {
                    if let Some(color) = self.owned(x, y) {
                        *pixel = with_kind(color, kind::OWNED);
                    }
                }
            });
        self.paint_gutter(&mut pixels);
        self.paint_seams(&mut pixels);
        pixels
    }

    /// The colour of a pixel on a texel that a triangle owns.
    fn owned(&self, x: u32, y: u32) -> Option<Color> {
        let atlas = self.atlas;
        let texel = (y / self.scale) as usize * atlas.pitch as usize + (x / self.scale) as usize;
        let owner = atlas.owner[texel];
        if owner == NONE {
            return None;
        }
        let color = self.colors[atlas.chart[owner as usize] as usize];
        if !self.edges {
            return Some(color);
        }
        let pixel = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
        let line = edge_strength(
            &atlas.maps[owner as usize],
            pixel / f64::from(self.scale),
            self.scale as f32,
        );
        Some(mix(color, EDGE, EDGE_STRENGTH * line))
    }

    fn paint_gutter(&self, pixels: &mut [[u8; 4]]) {
        let Atlas { pitch, chart, .. } = self.atlas;
        for gutter in &self.atlas.gutter_texels {
            let color = self.colors[chart[gutter.triangle as usize] as usize];
            let color = color.map(|c| (f32::from(c) * GUTTER_LIGHT) as u8);
            let corner = [gutter.texel % pitch, gutter.texel / pitch].map(|c| c * self.scale);
            for y in corner[1]..corner[1] + self.scale {
                let first = y as usize * self.pitch as usize + corner[0] as usize;
                pixels[first..first + self.scale as usize].fill(with_kind(color, kind::GUTTER));
            }
        }
    }

    /// Lines along all edges at which charts end.
    fn paint_seams(&self, pixels: &mut [[u8; 4]]) {
        let strength = self.seam_strengths();
        for h in 0..self.surface.halfedges.len() as u32 {
            let strength = strength[self.atlas.chart[h as usize / 3] as usize];
            if strength > 0.0 && self.atlas.is_seam(self.surface, h) {
                let is_border = self.surface.halfedges[h as usize].twin == NONE;
                let color = if is_border { BORDER } else { SEAM };
                self.paint_line(pixels, self.atlas.edge(h), color, strength);
            }
        }
    }

    /// Per chart, because seams would cover tiny charts.
    fn seam_strengths(&self) -> Vec<f32> {
        let mut area = vec![0.0; self.atlas.chart_count as usize];
        for (map, &chart) in self.atlas.maps.iter().zip(&self.atlas.chart) {
            area[chart as usize] += 0.5 * map.du.perp_dot(map.dv).abs();
        }
        area.into_iter()
            .map(|area: f32| SEAM_STRENGTH * fade(area.sqrt() * self.scale as f32, SEAM_FADES))
            .collect()
    }

    fn paint_line(&self, pixels: &mut [[u8; 4]], ends: [Vec2; 2], color: Color, strength: f32) {
        let side = self.atlas.size * self.scale;
        let [a, b] = ends.map(|end| end * self.scale as f32);
        // Close enough that no pixel on the line is skipped, except where the line only cuts a corner.
        let steps = (2.0 * (b - a).abs().max_element()).ceil().max(1.0);
        for step in 0..=steps as u32 {
            let at = a.lerp(b, step as f32 / steps);
            let at = at.clamp(Vec2::ZERO, Vec2::splat(side as f32 - 0.5));
            let pixel = &mut pixels[at.y as usize * self.pitch as usize + at.x as usize];
            let lined = match pixel[3] {
                kind::OWNED => kind::OWNED_LINE,
                kind::GUTTER => kind::GUTTER_LINE,
                // There is a line already, or, at a chart's corner, rounding has left the chart.
                _ => continue,
            };
            let [r, g, b, _] = *pixel;
            *pixel = with_kind(mix([r, g, b], color, strength), lined);
        }
    }
}

/// The coverage of a pixel by an edge line, 0 to 1; `position` in texels.
fn edge_strength(map: &AtlasMap, position: DVec2, pixels_per_texel: f32) -> f32 {
    let (du, dv) = (map.du.as_dvec2(), map.dv.as_dvec2());
    let twice_area = du.perp_dot(dv).abs();
    let lengths = [(dv - du).length(), dv.length(), du.length()];
    let in_radius = twice_area / (lengths[0] + lengths[1] + lengths[2]);
    let fade = fade(in_radius as f32 * pixels_per_texel, EDGE_FADES);
    if fade <= 0.0 {
        return 0.0;
    }
    let offset = position - map.origin.as_dvec2();
    let (u, v) = (
        offset.perp_dot(dv) / du.perp_dot(dv),
        du.perp_dot(offset) / du.perp_dot(dv),
    );
    // The weight of a corner times the height over the edge that it does not touch.
    let weights = [1.0 - u - v, u, v];
    let distance = (0..3)
        .map(|k| weights[k].abs() * twice_area / lengths[k])
        .fold(f64::INFINITY, f64::min);
    fade * (1.0 - distance as f32 * pixels_per_texel).clamp(0.0, 1.0)
}

fn fade(size: f32, (none, full): (f32, f32)) -> f32 {
    ((size - none) / (full - none)).clamp(0.0, 1.0)
}

fn mix(a: Color, b: Color, share: f32) -> Color {
    std::array::from_fn(|k| {
        let (a, b) = (f32::from(a[k]), f32::from(b[k]));
        (a + share * (b - a)).round() as u8
    })
}

fn with_kind([r, g, b]: Color, kind: u8) -> [u8; 4] {
    [r, g, b, kind]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn charts_that_touch_have_different_colours() {
        for (mesh, size) in [("cube", 61), ("torus?major=12&minor=8", 200)] {
            let (surface, atlas) = Atlas::of_cells(mesh, size);
            let colors = chart_colors(&surface, &atlas);
            assert_eq!(colors.len(), atlas.chart_count as usize);
            let pairs = neighbours(&surface, &atlas);
            assert!(pairs.len() > colors.len(), "{mesh}");
            for (a, b) in pairs {
                assert_ne!(
                    colors[a as usize], colors[b as usize],
                    "{mesh}: {a} and {b}"
                );
            }
        }
    }

    #[test]
    fn every_texel_is_what_the_atlas_says() {
        let (surface, atlas) = Atlas::of_cells("cube", 61);
        let colors = chart_colors(&surface, &atlas);
        let words = texel_words(&surface, &atlas, &colors);
        assert_eq!(words.len(), atlas.texel_count());
        let gutter: Vec<u32> = atlas.gutter_texels.iter().map(|g| g.texel).collect();
        for (texel, word) in (0..).zip(words) {
            let found = word.to_le_bytes()[3];
            let expected = if atlas.owner[texel as usize] != NONE {
                [kind::OWNED, kind::OWNED_LINE]
            } else if gutter.contains(&texel) {
                [kind::GUTTER, kind::GUTTER_LINE]
            } else {
                [kind::UNUSED, kind::UNUSED]
            };
            assert!(expected.contains(&found), "texel {texel} is {found}");
        }
    }

    #[test]
    fn a_larger_picture_shows_the_same_texels() {
        let (surface, atlas) = Atlas::of_cells("cube", 61);
        let (small, large) = (picture(&surface, &atlas, 1), picture(&surface, &atlas, 3));
        assert_eq!(large.dimensions(), (183, 183));
        let unused = |image: &RgbaImage, x, y| image.get_pixel(x, y).0[..3] == UNUSED;
        for (x, y, _) in large.enumerate_pixels() {
            assert_eq!(
                unused(&large, x, y),
                unused(&small, x / 3, y / 3),
                "{x} {y}"
            );
            assert_eq!(large.get_pixel(x, y).0[3], 255);
        }
    }

    #[test]
    fn triangles_know_their_seams() {
        let (surface, atlas) = Atlas::of_cells("cube", 61);
        let colors = chart_colors(&surface, &atlas);
        let words = triangle_words(&surface, &atlas, &colors);
        // Two triangles a cell: one edge of each lies inside of it.
        assert!(words.iter().all(|word| (word >> 24).count_ones() == 2));
        let twin = |h: u32| surface.halfedges[h as usize].twin / 3;
        for (t, word) in (0..).zip(&words) {
            for k in (0..3).filter(|k| word >> (24 + k) & 1 == 0) {
                assert_eq!(
                    atlas.chart[t as usize],
                    atlas.chart[twin(3 * t + k) as usize]
                );
            }
        }
    }
}
