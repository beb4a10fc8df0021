//! The outlook of a texel is the distance up to which all of its chart is visible from it. Up to there a straight line in the texture that
//! ends in the chart is a walk on the surface, also beside the chart's border, up to the distortion of lengths and angles by flattening.
//!
//! Rays go from each texel until they leave the chart at its border. Parts of the chart behind that are hidden, and the outlook ends before
//! them. Charts beside each other have different hues, so the hue at the end of a line shows whether the end lies in the chart in which the
//! line began.

use glam::Vec2;
use rayon::prelude::*;

use super::super::surface::{NONE, Surface};
use super::Atlas;

/// The largest side of an atlas, in texels, whose rays go from texel to texel; in larger ones they go from cell to cell.
const FINE: u32 = 1536;
/// The length of rays, in cells.
const REACH: usize = 24;
/// Number of hues, counted from 1. Charts for which no hue is left have 0, and no sensor reads straight ahead there.
const HUES: u32 = 31;
/// The mark of a cell that no ray passes.
const WALL: u8 = 255;
/// The largest difference between the distance of two points and that of the centres of their cells.
const TO_CENTRES: f32 = 1.4143;
/// Gaps of a chart that are narrower than these, in cells, become walls, because rays would cross them.
const NARROW: [f32; 3] = [0.5, 1.0, 1.5];

/// Data of texels for straight lines, one entry each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outlooks {
    /// Hues, which differ between charts that lie near each other: 1 to 31; 0 where texels are not owned, or no hue was left.
    pub hues: Vec<u8>,
    /// All texels of the same hue within this distance can be reached by a straight line; in units of [`Atlas::outlook_unit`].
    pub distances: Vec<u8>,
}

impl Atlas {
    /// Unit of the distances of outlooks, texels.
    #[must_use]
    pub fn outlook_unit(&self) -> f32 {
        0.5 * self.cell() as f32
    }

    /// Texels along the side of a cell.
    fn cell(&self) -> usize {
        self.size.div_ceil(FINE) as usize
    }

    /// Computes the outlooks of all texels. They are at least as large as the `clearances` of the same surface.
    #[must_use]
    pub fn outlooks(&self, surface: &Surface, clearances: &[u8]) -> Outlooks {
        let of_charts = self.hues_of_charts();
        let hue = |&owner: &u32| match owner {
            NONE => 0,
            owner => of_charts[self.chart[owner as usize] as usize],
        };
        let hues: Vec<u8> = self.owner.par_iter().map(hue).collect();
        let cells = Cells::new(self, &hues, &self.walls(surface));
        let hidden = cells.nearest_hidden();
        let (pitch, cell) = (self.pitch as usize, self.cell());
        let mut distances = vec![0; hues.len()];
        let rows = distances.par_chunks_mut(pitch).enumerate();
        rows.for_each(|(y, row)| {
            for (x, distance) in row.iter_mut().enumerate() {
                let texel = y * pitch + x;
                let seen = hidden[y / cell * cells.width + x / cell];
                let clear = clearances[texel] / cell as u8;
                *distance = if hues[texel] == 0 { 0 } else { seen.max(clear) };
            }
        });
        Outlooks { hues, distances }
    }

    /// One hue for each chart; charts that are within a ray's length of each other have different hues.
    fn hues_of_charts(&self) -> Vec<u8> {
        let (pitch, side) = (self.pitch as usize, REACH * self.cell());
        let width = pitch.div_ceil(side);
        // The squares of the texture that each chart lies in.
        let rows = self.owner.par_chunks(side * pitch).enumerate();
        let mut places: Vec<(u32, u32)> = rows
            .flat_map_iter(|(row, owners)| {
                let charts = owners.iter().enumerate().filter(|&(_, &o)| o != NONE);
                let mut places: Vec<_> = charts
                    .map(|(i, &owner)| {
                        let place = row * width + i % pitch / side;
                        (self.chart[owner as usize], place as u32)
                    })
                    .collect();
                places.dedup();
                places.sort_unstable();
                places.dedup();
                places
            })
            .collect();
        places.par_sort_unstable();
        let mut taken = vec![0_u32; width * self.size.div_ceil(side as u32) as usize];
        let mut hues = vec![0; self.chart_count as usize];
        for of_chart in places.chunk_by(|a, b| a.0 == b.0) {
            let around = |place: u32| {
                let (x, y) = (place as usize % width, place as usize / width);
                let rows = y.saturating_sub(1)..=y + 1;
                rows.flat_map(move |y| (x.saturating_sub(1)..=x + 1).map(move |x| (x, y)))
                    .filter(move |&(x, _)| x < width)
                    .map(move |(x, y)| y * width + x)
            };
            let near = of_chart.iter().flat_map(|&(_, place)| around(place));
            let near = near.filter_map(|place| taken.get(place));
            let used = near.fold(1, |all, hues| all | hues);
            let hue = (!used).trailing_zeros();
            if hue <= HUES {
                hues[of_chart[0].0 as usize] = hue as u8;
                for &(_, place) in of_chart {
                    taken[place as usize] |= 1 << hue;
                }
            }
        }
        hues
    }

    /// The texels where a chart is so near to itself that there may be no texel between.
    fn walls(&self, surface: &Surface) -> Vec<u32> {
        let owner_at = |point: Vec2| {
            let within = point.cmpge(Vec2::ZERO).all() && point.max_element() < self.size as f32;
            let owner = within.then(|| self.owner[self.texel_at(point)]);
            owner.filter(|&owner| owner != NONE)
        };
        let cell = self.cell() as f32;
        let last = self.size as f32 - 0.5;
        let seams = (0..surface.halfedges.len() as u32).into_par_iter();
        let seams = seams.filter(|&halfedge| self.is_seam(surface, halfedge));
        seams
            .flat_map_iter(|halfedge| {
                let (triangle, corner) = (halfedge as usize / 3, halfedge as usize % 3);
                let corners = surface.corners[triangle];
                let ends = [corners[corner], corners[(corner + 1) % 3]];
                let own = self.chart[triangle];
                let [a, b] = self.edge(halfedge);
                let aside = (b - a).normalize_or_zero().perp();
                let pieces = (2.0 * (b - a).abs().max_element()).ceil().max(1.0);
                let points = (0..=pieces as u32).map(move |i| a + (b - a) * (i as f32 / pieces));
                points.flat_map(move |point| {
                    // On one side is the edge's own triangle. Where two edges meet, the triangle of the other edge is equally near.
                    let is_other = |way: f32| {
                        owner_at(point + way * cell * aside).is_some_and(|owner| {
                            let corners = surface.corners[owner as usize];
                            self.chart[owner as usize] == own
                                && !corners.iter().any(|corner| ends.contains(corner))
                        })
                    };
                    let is_own = |way: f32| {
                        owner_at(point + way * cell * aside)
                            .is_some_and(|owner| self.chart[owner as usize] == own)
                    };
                    let is_narrow = |side: f32| {
                        NARROW.iter().any(|way| is_other(side * way))
                            && NARROW.iter().any(|way| is_own(-side * way))
                    };
                    let is_narrow = is_narrow(1.0) || is_narrow(-1.0);
                    let around = [-0.5, 0.0, 0.5].map(|way| point + way * cell * aside);
                    let around = around.into_iter().filter(move |_| is_narrow);
                    around.map(move |point| {
                        self.texel_at(point.clamp(Vec2::ZERO, Vec2::splat(last))) as u32
                    })
                })
            })
            .collect()
    }

    fn texel_at(&self, point: Vec2) -> usize {
        point.y as usize * self.pitch as usize + point.x as usize
    }
}

/// The texture in cells of one texel or more, with a margin of a ray's length, so that rays need no test for the end of the texture.
struct Cells {
    width: usize,
    height: usize,
    /// From one row to the next.
    pitch: usize,
    /// The hue of the cell's texels; 0 where they have none, or several.
    own: Vec<u8>,
    /// The hue whose rays pass the cell: that of a cell with a single hue, otherwise 0; or a [`WALL`].
    passed: Vec<u8>,
}

impl Cells {
    fn new(atlas: &Atlas, hues: &[u8], walls: &[u32]) -> Self {
        let (cell, texels) = (atlas.cell(), atlas.pitch as usize);
        let (width, height) = (texels.div_ceil(cell), (atlas.size as usize).div_ceil(cell));
        let pitch = width + 2 * REACH;
        let mut own = vec![0; pitch * (height + 2 * REACH)];
        let mut passed = own.clone();
        let rows = own.par_chunks_mut(pitch).zip(passed.par_chunks_mut(pitch));
        let rows = rows.skip(REACH).zip(hues.par_chunks(cell * texels));
        rows.for_each(|((own, passed), hues)| {
            for x in 0..width {
                let of_row = |row: &[u8]| {
                    let row = &row[x * cell..((x + 1) * cell).min(texels)];
                    (
                        row.iter().fold(0, |a, &b| a.max(b)),
                        row.iter().fold(255, |a, &b| a.min(b)),
                    )
                };
                let both = hues.chunks(texels).map(of_row);
                let (most, least) = both.fold((0, 255), |a, b| (a.0.max(b.0), a.1.min(b.1)));
                let one = hues.chunks(texels).all(|row| {
                    let row = &row[x * cell..((x + 1) * cell).min(texels)];
                    row.iter().all(|&hue| hue == 0 || hue == most)
                });
                own[REACH + x] = if one { most } else { 0 };
                passed[REACH + x] = if most == least { most } else { 0 };
            }
        });
        for &texel in walls {
            let (x, y) = (
                texel as usize % texels / cell,
                texel as usize / texels / cell,
            );
            passed[(REACH + y) * pitch + REACH + x] = WALL;
        }
        Self {
            width,
            height,
            pitch,
            own,
            passed,
        }
    }

    /// Per cell: the distance up to which nothing is hidden, in halves of a cell.
    fn nearest_hidden(&self) -> Vec<u8> {
        let rings = rings(self.pitch);
        let most = rings.iter().map(Vec::len).max().unwrap_or(1);
        let mut nearest = vec![0; self.width * self.height];
        let rows = nearest.par_chunks_mut(self.width).enumerate();
        rows.for_each_init(
            || [(); 2].map(|()| vec![IN_CHART; most * self.width]),
            |[before, after], (y, nearest)| {
                let first = (REACH + y) * self.pitch + REACH;
                let row = |way: isize| -> std::ops::Range<usize> {
                    let first = first.wrapping_add_signed(way);
                    first..first + self.width
                };
                let own = &self.own[row(0)];
                if own.iter().all(|&hue| hue == 0) {
                    return;
                }
                nearest.fill(half_cells(REACH as f32 + 1.0));
                let passed = &self.passed[row(0)];
                before[..self.width].fill(IN_CHART);
                advance(after, before, own, passed);
                std::mem::swap(before, after);
                for ring in &rings {
                    for (cell, after) in ring.iter().zip(after.chunks_mut(self.width)) {
                        let hues = &self.own[row(cell.way)];
                        let passed = &self.passed[row(cell.way)];
                        let before = &before[cell.before * self.width..][..self.width];
                        hide(nearest, cell.distance, before, own, hues);
                        advance(after, before, own, passed);
                    }
                    std::mem::swap(before, after);
                }
            },
        );
        nearest
    }
}

/// A ray has been in the chart up to here.
const IN_CHART: u8 = 0;
/// The ray has just come to a cell that is partly outside of the chart.
const BESIDE: u8 = 1;
/// The ray has left the chart: parts of the chart behind that are hidden.
const LEFT: u8 = 255;

/// All bits or none, for loops without branches, which process many cells at once.
fn mask(is: bool) -> u8 {
    if is { 255 } else { 0 }
}

/// Ends outlooks before a cell of the chart if the ray to it has left the chart.
fn hide(nearest: &mut [u8], distance: u8, before: &[u8], own: &[u8], hues: &[u8]) {
    let cells = before.iter().zip(own).zip(hues);
    for (nearest, ((&before, &own), &hue)) in nearest.iter_mut().zip(cells) {
        let is_hidden = mask(before == LEFT) & mask(hue == own);
        *nearest = (*nearest).min(distance | !is_hidden);
    }
}

/// Advances rays by one cell. A single cell outside of the chart does not end a ray: borders are jagged, and gutters continue the
/// surface.
fn advance(after: &mut [u8], before: &[u8], own: &[u8], passed: &[u8]) {
    let cells = before.iter().zip(own).zip(passed);
    for (after, ((&before, &own), &passed)) in after.iter_mut().zip(cells) {
        let inside = mask(passed == own);
        let beside = BESIDE | mask(before != IN_CHART);
        *after = (inside & mask(before == LEFT)) | (!inside & beside) | mask(passed == WALL);
    }
}

/// The least distance between points of two cells, in halves of a cell, from the distance of the cells' centres.
fn half_cells(cells: f32) -> u8 {
    (2.0 * (cells - TO_CENTRES)).max(0.0) as u8
}

/// A cell on the rays from a central one.
struct Cell {
    /// Its index minus that of the central cell.
    way: isize,
    /// Up to this distance no point of it is reached, halves of a cell.
    distance: u8,
    /// The cell of the previous ring through which the ray goes.
    before: usize,
}

/// The cells around a central one up to a ray's length, in rings of equal distance along the longer axis.
fn rings(pitch: usize) -> Vec<Vec<Cell>> {
    let mut places = vec![[0, 0]];
    let mut rings = Vec::new();
    for k in 1..=REACH as i32 {
        let square = (-k..=k).flat_map(|y| (-k..=k).map(move |x| [x, y]));
        let ring = square.filter(|[x, y]| x.abs().max(y.abs()) == k);
        let ring: Vec<[i32; 2]> = ring
            .filter(|[x, y]| x * x + y * y <= (REACH * REACH) as i32)
            .collect();
        let inwards = |end: i32| (f64::from(end) * f64::from(k - 1) / f64::from(k)).round() as i32;
        let cell = |&[x, y]: &[i32; 2]| Cell {
            way: y as isize * pitch as isize + x as isize,
            distance: half_cells(f64::from(x * x + y * y).sqrt() as f32),
            before: (places
                .iter()
                .position(|&place| place == [inwards(x), inwards(y)]))
            .expect("what lies on the way to a cell in reach is in reach"),
        };
        rings.push(ring.iter().map(cell).collect());
        places = ring;
    }
    rings
}
