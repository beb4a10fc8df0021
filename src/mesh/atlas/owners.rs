//! Data that follow from the places of triangles: each texel's owner, its surface area, and the gutter.
//!
//! All decisions are made with fixed-point numbers, so that nothing depends on rounding. The methods `charts` and `mesh` and layouts from
//! files use this. The texture is processed in bands of rows, in parallel; within a band triangles come in ascending order.

use glam::{DVec2, IVec2};
use rayon::prelude::*;

use super::super::surface::{AtlasMap, NONE, Surface};
use super::fixed::{Fixed, only_texel, twice_area};
use super::outline::Cells;
use super::{AtlasError, AtlasOptions, Control, GutterTexel, Layout, pitch_of};

/// Texel rows a band.
const BAND: u32 = 16;

/// Name of this work in progress reports, and the share of the atlas's total time before it starts.
pub(super) const DOING: &str = "giving out texels";
pub(super) const START: f32 = 0.72;

/// Owners, areas and gutter for maps whose corners are on the grid.
pub(super) fn derive(
    surface: &Surface,
    maps: Vec<AtlasMap>,
    chart: Vec<u32>,
    chart_count: u32,
    options: &AtlasOptions,
    control: &Control<'_>,
) -> Result<Layout, AtlasError> {
    control.step(DOING, START)?;
    let sheet = Sheet::new(surface, &maps, &chart, options);
    let (mut owner, area) = sheet.owners_and_areas();
    let only = sheet.only_texels(&owner, chart_count);
    for &(triangle, texel) in &only {
        owner[texel.y as usize * sheet.pitch + texel.x as usize] = triangle;
    }
    control.check()?;
    let gutter_texels = sheet.gutter(&owner, &only);
    Ok(Layout {
        maps,
        chart,
        chart_count,
        cell_size: 0,
        owner,
        area,
        gutter_texels,
    })
}

/// Charts that are too near to each other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Conflict {
    /// Triangles of two charts that both want one texel.
    pub triangles: [u32; 2],
    /// The factor by which they would have to be farther from each other.
    pub larger: f64,
}

/// The worst case of two charts that want the same texel, if there is any.
pub(super) fn conflict(
    surface: &Surface,
    maps: &[AtlasMap],
    chart: &[u32],
    options: &AtlasOptions,
) -> Option<Conflict> {
    Sheet::new(surface, maps, chart, options).conflict()
}

struct Sheet<'a> {
    fixed: Fixed,
    size: i32,
    pitch: usize,
    /// Per triangle, in units.
    corners: Vec<[IVec2; 3]>,
    surface: &'a Surface,
    chart: &'a [u32],
}

impl<'a> Sheet<'a> {
    fn new(
        surface: &'a Surface,
        maps: &[AtlasMap],
        chart: &'a [u32],
        options: &AtlasOptions,
    ) -> Self {
        let fixed = Fixed::new(options.size, options.gutter);
        Self {
            fixed,
            size: options.size as i32,
            pitch: pitch_of(options.size) as usize,
            corners: maps.par_iter().map(|map| fixed.corners_of(map)).collect(),
            surface,
            chart,
        }
    }

    fn band_count(&self) -> usize {
        (self.size as usize).div_ceil(BAND as usize)
    }

    /// Per band the items that reach into it, in their order; `rows` has the first row of each and one past its last.
    fn by_band(&self, rows: &[(i32, i32)]) -> Vec<Vec<u32>> {
        let mut bands = vec![Vec::new(); self.band_count()];
        for (item, &(first, end)) in rows.iter().enumerate() {
            let (first, end) = (first.max(0), end.min(self.size));
            if first < end {
                for band in
                    &mut bands[(first / BAND as i32) as usize..=((end - 1) / BAND as i32) as usize]
                {
                    band.push(item as u32);
                }
            }
        }
        bands
    }

    /// Per triangle the first row that it reaches into, and one past its last.
    fn rows_of_triangles(&self) -> Vec<(i32, i32)> {
        let rows = self.corners.par_iter().map(|corners| {
            let ys = corners.map(|corner| corner.y);
            let low = ys[0].min(ys[1]).min(ys[2]).div_euclid(self.fixed.texel);
            let high = ys[0].max(ys[1]).max(ys[2]).div_euclid(self.fixed.texel);
            (low, high + 1)
        });
        rows.collect()
    }

    fn owners(&self) -> Vec<u32> {
        let rows = self.rows_of_triangles();
        let bands = self.by_band(&rows);
        let mut owner = vec![NONE; self.pitch * self.size as usize];
        owner
            .par_chunks_mut(BAND as usize * self.pitch)
            .zip(&bands)
            .enumerate()
            .for_each(|(band, (owner, triangles))| {
                let first = band as i32 * BAND as i32;
                let end = first + (owner.len() / self.pitch) as i32;
                for &t in triangles {
                    let (low, high) = rows[t as usize];
                    self.own(t, low.max(first)..high.min(end), first, owner);
                }
            });
        owner
    }

    fn owners_and_areas(&self) -> (Vec<u32>, Vec<f32>) {
        let rows = self.rows_of_triangles();
        let bands = self.by_band(&rows);
        let mut owner = vec![NONE; self.pitch * self.size as usize];
        let mut area = vec![0.0; owner.len()];
        let texels = BAND as usize * self.pitch;
        owner
            .par_chunks_mut(texels)
            .zip(area.par_chunks_mut(texels))
            .zip(&bands)
            .enumerate()
            .for_each(|(band, ((owner, area), triangles))| {
                let first = band as i32 * BAND as i32;
                let end = first + (owner.len() / self.pitch) as i32;
                for &t in triangles {
                    let (low, high) = rows[t as usize];
                    let rows = low.max(first)..high.min(end);
                    self.own(t, rows.clone(), first, owner);
                    self.cover(t, rows, first, area);
                }
            });
        (owner, area)
    }

    fn conflict(&self) -> Option<Conflict> {
        let owner = self.owners();
        let cells = Cells {
            side: self.fixed.texel,
            reach: self.fixed.reach,
        };
        let edges = self.border();
        let rows: Vec<(i32, i32)> = edges.par_iter().map(|edge| cells.rows(edge.ends)).collect();
        let bands = self.by_band(&rows);
        let chart_of = |t: u32| self.chart[t as usize];
        let found: Vec<Option<Conflict>> = owner
            .par_chunks(BAND as usize * self.pitch)
            .zip(&bands)
            .enumerate()
            .map(|(band, (owner, in_band))| {
                let first = band as i32 * BAND as i32;
                let end = first + (owner.len() / self.pitch) as i32;
                let mut claimed = vec![NONE; owner.len()];
                let mut worst: Option<Conflict> = None;
                let mut meet = |conflict: Conflict| {
                    if worst.is_none_or(|worst| conflict.larger > worst.larger) {
                        worst = Some(conflict);
                    }
                };
                for &index in in_band {
                    let edge = &edges[index as usize];
                    let (low, high) = rows[index as usize];
                    for row in low.max(first)..high.min(end) {
                        let (from, to) = cells.columns(edge.ends, row);
                        for column in from.max(0)..to.min(self.size) {
                            let texel = (row - first) as usize * self.pitch + column as usize;
                            let (owner, before) = (owner[texel], claimed[texel]);
                            if before == NONE {
                                claimed[texel] = index;
                            } else if chart_of(edges[before as usize].of) != chart_of(edge.of) {
                                let before = &edges[before as usize];
                                let gap = gap(before.ends, edge.ends);
                                meet(Conflict {
                                    triangles: [before.of, edge.of],
                                    larger: f64::from(2 * self.fixed.reach + 1) / gap,
                                });
                            }
                            // If the owner's own border is not within reach, one chart lies inside of the other.
                            if owner != NONE && chart_of(owner) != chart_of(edge.of) {
                                meet(Conflict {
                                    triangles: [owner, edge.of],
                                    larger: 1.0,
                                });
                            }
                        }
                    }
                }
                worst
            })
            .collect();
        found
            .into_iter()
            .flatten()
            .reduce(|a, b| if b.larger > a.larger { b } else { a })
    }

    /// Makes a triangle the owner of the texels in some rows whose centres it holds, its edges included, unless an earlier triangle holds
    /// them.
    fn own(&self, t: u32, rows: std::ops::Range<i32>, first: i32, owner: &mut [u32]) {
        let mut corners = self.corners[t as usize];
        let area = twice_area(corners);
        if area == 0 {
            return;
        }
        if area < 0 {
            corners.swap(1, 2);
        }
        let texel = i64::from(self.fixed.texel);
        let half = texel / 2;
        for row in rows {
            let y = i64::from(row) * texel + half;
            // Centres are at x = column * texel + half; inside, `a * x + b >= 0` for each edge.
            let (mut from, mut to) = (0, i64::from(self.size));
            for k in 0..3 {
                let (p, q) = (corners[k].as_i64vec2(), corners[(k + 1) % 3].as_i64vec2());
                let a = p.y - q.y;
                let b = (q.x - p.x) * (y - p.y) - a * p.x;
                // a * (column * texel + half) + b >= 0
                let least = -(a * half + b);
                if a > 0 {
                    from = from.max(-(-least).div_euclid(a * texel));
                } else if a < 0 {
                    to = to.min((-least).div_euclid(-a * texel) + 1);
                } else if least > 0 {
                    to = from;
                }
            }
            if from < to {
                let start = (row - first) as usize * self.pitch;
                for owner in &mut owner[start + from as usize..start + to as usize] {
                    *owner = t.min(*owner);
                }
            }
        }
    }

    /// Adds a triangle's surface area to the texels in some rows, to each its part. If the triangle has no area in the texture, all of it
    /// goes to the texel under the centroid.
    fn cover(&self, t: u32, rows: std::ops::Range<i32>, first: i32, area: &mut [f32]) {
        let corners = self.corners[t as usize];
        let whole = self.surface.area(t);
        let texels = twice_area(corners).unsigned_abs() as f64
            / (2.0 * f64::from(self.fixed.texel) * f64::from(self.fixed.texel));
        let start = |row: i32| (row - first) as usize * self.pitch;
        if texels == 0.0 {
            let [a, b, c] = corners;
            let texel = (a + b + c).map(|k| k.div_euclid(3 * self.fixed.texel));
            if rows.contains(&texel.y) {
                area[start(texel.y) + texel.x as usize] += whole as f32;
            }
            return;
        }
        let unit = 1.0 / f64::from(self.fixed.texel);
        let density = whole / texels;
        let triangle = corners.map(|corner| corner.as_dvec2() * unit);
        for row in rows {
            let area = &mut area[start(row)..][..self.pitch];
            let y = f64::from(row);
            let slab = Polygon::of(&triangle).above(y).below(y + 1.0);
            let Some((left, right)) = slab.columns() else {
                continue;
            };
            // Cells within the spans at both the lower and the upper side of the row are covered wholly.
            let (full_from, full_to) = match (span_at(&triangle, y), span_at(&triangle, y + 1.0)) {
                (Some(low), Some(high)) => (low.0.max(high.0).ceil(), low.1.min(high.1).floor()),
                _ => (0.0, 0.0),
            };
            let mut rest = slab;
            let mut column = left;
            while column < right {
                let x = column as f64;
                if x >= full_from && x < full_to {
                    let to = (full_to as usize).min(right);
                    for area in &mut area[column..to] {
                        *area += density as f32;
                    }
                    rest = rest.right_of(to as f64);
                    column = to;
                } else {
                    let cell = rest.left_of(x + 1.0);
                    rest = rest.right_of(x + 1.0);
                    area[column] += (density * cell.area()) as f32;
                    column += 1;
                }
            }
        }
    }

    /// The single texels of charts that hold no texel's centre, by chart.
    fn only_texels(&self, owner: &[u32], chart_count: u32) -> Vec<(u32, IVec2)> {
        let mut owns = vec![false; chart_count as usize];
        for &triangle in owner {
            if triangle != NONE {
                owns[self.chart[triangle as usize] as usize] = true;
            }
        }
        let mut without: Vec<(u32, u32)> = (0..self.chart.len() as u32)
            .map(|t| (self.chart[t as usize], t))
            .filter(|&(chart, _)| !owns[chart as usize])
            .collect();
        without.sort_unstable();
        without
            .chunk_by(|a, b| a.0 == b.0)
            .map(|chart| {
                let triangles = chart.iter().map(|&(_, t)| (t, self.corners[t as usize]));
                only_texel(self.fixed, triangles)
            })
            .collect()
    }

    /// The gutter texels, ascending.
    fn gutter(&self, owner: &[u32], only: &[(u32, IVec2)]) -> Vec<GutterTexel> {
        let cells = Cells {
            side: self.fixed.texel,
            reach: self.fixed.reach,
        };
        let edges = self.border();
        let rows: Vec<(i32, i32)> = edges.par_iter().map(|edge| cells.rows(edge.ends)).collect();
        let bands = self.by_band(&rows);
        let gutter = self.fixed.gutter.min(1 << 15) as i32;
        let around: Vec<(i32, i32)> = only
            .iter()
            .map(|(_, texel)| (texel.y - gutter, texel.y + gutter + 1))
            .collect();
        let around = self.by_band(&around);
        let found: Vec<Vec<GutterTexel>> = owner
            .par_chunks(BAND as usize * self.pitch)
            .zip(bands.par_iter().zip(&around))
            .enumerate()
            .map(|(band, (owner, (in_band, around)))| {
                let first = band as i32 * BAND as i32;
                let end = first + (owner.len() / self.pitch) as i32;
                // Distance in the high bits, triangle in the low ones: the nearest is the least.
                let mut nearest = vec![u64::MAX; owner.len()];
                let mut meet = |row: i32, from: i32, to: i32, key: &dyn Fn(DVec2) -> u64| {
                    for column in from.max(0)..to.min(self.size) {
                        let texel = (row - first) as usize * self.pitch + column as usize;
                        if owner[texel] == NONE {
                            let centre = (IVec2::new(column, row) * self.fixed.texel
                                + self.fixed.texel / 2)
                                .as_dvec2();
                            nearest[texel] = nearest[texel].min(key(centre));
                        }
                    }
                };
                for &index in in_band {
                    let edge = &edges[index as usize];
                    let (low, high) = rows[index as usize];
                    for row in low.max(first)..high.min(end) {
                        let (from, to) = cells.columns(edge.ends, row);
                        meet(row, from, to, &|centre| edge.key(centre));
                    }
                }
                for &index in around {
                    let (triangle, texel) = only[index as usize];
                    for row in (texel.y - gutter).max(first)..(texel.y + gutter + 1).min(end) {
                        // Farther than any texel within reach of an edge.
                        let key = u64::from(u32::MAX) << 32 | u64::from(triangle);
                        meet(row, texel.x - gutter, texel.x + gutter + 1, &|_| key);
                    }
                }
                nearest
                    .iter()
                    .enumerate()
                    .filter(|&(_, &key)| key != u64::MAX)
                    .map(|(texel, &key)| GutterTexel {
                        texel: (first as usize * self.pitch + texel) as u32,
                        triangle: key as u32,
                    })
                    .collect()
            })
            .collect();
        found.concat()
    }

    /// The borders of all charts: edges without a neighbour beside them in the same chart.
    fn border(&self) -> Vec<BorderEdge> {
        (0..self.corners.len() as u32)
            .into_par_iter()
            .flat_map_iter(|t| (0..3).map(move |corner| (t, corner)))
            .filter(|&(t, corner)| self.glued(t, corner).is_none())
            .map(|(t, corner)| BorderEdge {
                ends: self.ends(t, corner),
                of: t,
                triangle: self.with_area(t),
            })
            .collect()
    }

    fn ends(&self, t: u32, corner: u32) -> [IVec2; 2] {
        let corners = &self.corners[t as usize];
        [corners[corner as usize], corners[(corner as usize + 1) % 3]]
    }

    /// The neighbour beyond an edge, if it is beside the edge in the texture, too.
    fn glued(&self, t: u32, corner: u32) -> Option<u32> {
        let twin = self.surface.halfedges[(3 * t + corner) as usize].twin;
        if twin == NONE || self.chart[twin as usize / 3] != self.chart[t as usize] {
            return None;
        }
        let [a, b] = self.ends(t, corner);
        (self.ends(twin / 3, twin % 3) == [b, a]).then_some(twin / 3)
    }

    /// The nearest triangle with area in the texture in the same chart, by the number of edges between; it may be the triangle itself. If
    /// the chart has none, the triangle itself.
    fn with_area(&self, t: u32) -> u32 {
        if twice_area(self.corners[t as usize]) != 0 {
            return t;
        }
        let mut seen = vec![t];
        let mut next = 0;
        while next < seen.len() {
            for corner in 0..3 {
                if let Some(neighbour) = self.glued(seen[next], corner) {
                    if twice_area(self.corners[neighbour as usize]) != 0 {
                        return neighbour;
                    }
                    if !seen.contains(&neighbour) {
                        seen.push(neighbour);
                    }
                }
            }
            next += 1;
        }
        t
    }
}

/// An edge where a chart ends.
struct BorderEdge {
    ends: [IVec2; 2],
    /// The triangle whose edge it is.
    of: u32,
    /// The triangle whose map continues into the gutter beyond.
    triangle: u32,
}

impl BorderEdge {
    /// A key that orders by distance to a place, then by triangle.
    fn key(&self, place: DVec2) -> u64 {
        let [a, b] = self.ends.map(|end| end.as_dvec2());
        let along = (place - a).dot(b - a) / (b - a).length_squared().max(1.0);
        let distance = (a + along.clamp(0.0, 1.0) * (b - a) - place).length_squared();
        u64::from((distance as f32).to_bits()) << 32 | u64::from(self.triangle)
    }
}

/// The distance between two edges that do not cross, along the axis along which it is larger, in units.
fn gap(a: [IVec2; 2], b: [IVec2; 2]) -> f64 {
    // The nearest places are an end of one and some place on the other.
    let from_end = |end: IVec2, [p, q]: [IVec2; 2]| {
        let (start, along) = ((p - end).as_dvec2(), (q - p).as_dvec2());
        let at = |t: f64| (start + t.clamp(0.0, 1.0) * along).abs().max_element();
        let turns = [
            0.0,
            1.0,
            -start.x / along.x,
            -start.y / along.y,
            -(start.x - start.y) / (along.x - along.y),
            -(start.x + start.y) / (along.x + along.y),
        ];
        let finite = turns.into_iter().filter(|t| t.is_finite());
        finite.map(at).fold(f64::INFINITY, f64::min)
    };
    let ends = a.map(|end| from_end(end, b)).into_iter();
    ends.chain(b.map(|end| from_end(end, a)))
        .fold(f64::INFINITY, f64::min)
}

/// The span of a horizontal line in a triangle, if it crosses the triangle.
fn span_at(triangle: &[DVec2; 3], y: f64) -> Option<(f64, f64)> {
    let (mut from, mut to) = (f64::INFINITY, f64::NEG_INFINITY);
    for k in 0..3 {
        let (p, q) = (triangle[k], triangle[(k + 1) % 3]);
        if p.y.min(q.y) <= y && y <= p.y.max(q.y) {
            for x in if p.y == q.y {
                [p.x, q.x]
            } else {
                [p.x + (q.x - p.x) * ((y - p.y) / (q.y - p.y)); 2]
            } {
                from = from.min(x);
                to = to.max(x);
            }
        }
    }
    (from <= to).then_some((from, to))
}

/// A triangle, or its part between two horizontal and two vertical lines: at most seven corners.
#[derive(Clone, Copy)]
struct Polygon {
    corners: [DVec2; 8],
    count: usize,
}

impl Polygon {
    fn of(triangle: &[DVec2; 3]) -> Self {
        let mut corners = [DVec2::ZERO; 8];
        corners[..3].copy_from_slice(triangle);
        Self { corners, count: 3 }
    }

    /// The part where a linear function is not negative (Sutherland and Hodgman 1974).
    fn cut(self, inside: impl Fn(DVec2) -> f64) -> Self {
        let mut cut = Self {
            corners: [DVec2::ZERO; 8],
            count: 0,
        };
        for k in 0..self.count {
            let (p, q) = (self.corners[k], self.corners[(k + 1) % self.count]);
            let (at_p, at_q) = (inside(p), inside(q));
            if at_p >= 0.0 {
                cut.push(p);
            }
            if at_p * at_q < 0.0 {
                cut.push(p + (q - p) * (at_p / (at_p - at_q)));
            }
        }
        cut
    }

    fn push(&mut self, corner: DVec2) {
        // A convex polygon gains one corner a cut; rounding could only add coinciding ones.
        if self.count < self.corners.len() {
            self.corners[self.count] = corner;
            self.count += 1;
        }
    }

    fn above(self, y: f64) -> Self {
        self.cut(|p| p.y - y)
    }

    fn below(self, y: f64) -> Self {
        self.cut(|p| y - p.y)
    }

    fn right_of(self, x: f64) -> Self {
        self.cut(|p| p.x - x)
    }

    fn left_of(self, x: f64) -> Self {
        self.cut(|p| x - p.x)
    }

    /// The texel columns that it lies in: first, and one past the last.
    fn columns(&self) -> Option<(usize, usize)> {
        let corners = &self.corners[..self.count];
        let least = corners.iter().map(|p| p.x).reduce(f64::min)?;
        let most = corners.iter().map(|p| p.x).reduce(f64::max)?;
        Some((least.floor() as usize, most.ceil() as usize))
    }

    fn area(&self) -> f64 {
        let corners = &self.corners[..self.count];
        let Some(&origin) = corners.first() else {
            return 0.0;
        };
        let twice: f64 = corners
            .windows(2)
            .map(|pair| (pair[0] - origin).perp_dot(pair[1] - origin))
            .sum();
        0.5 * twice.abs()
    }
}
