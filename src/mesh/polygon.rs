//! Polygons cut into triangles.

use std::collections::VecDeque;

use glam::{DVec2, DVec3};

/// Cuts a polygon of n corners into n - 2 triangles between them, wound as it is, and hands each over as three corner
/// numbers.
///
/// Where the fan (0, k, k + 1) covers the polygon, as with every convex one, it is taken: files of points on triangles
/// count on these numbers. Elsewhere ears are clipped in the polygon's own plane. Returns false where that finds no
/// ear, as in polygons that cross themselves: the triangles then overlap.
pub(crate) fn triangulate(corners: &[DVec3], mut triangle: impl FnMut([u32; 3])) -> bool {
    let fan = (1..corners.len().saturating_sub(1) as u32).map(|k| [0, k, k + 1]);
    let normal = normal(corners);
    if corners.len() <= 3 || normal == DVec3::ZERO || fan_covers(corners, normal) {
        fan.for_each(triangle);
        return true;
    }
    let (right, up) = normal.any_orthonormal_pair();
    let points = corners.iter().map(|&corner| {
        // From the first corner, so that far from the origin no digits are lost.
        let from_first = corner - corners[0];
        DVec2::new(from_first.dot(right), from_first.dot(up))
    });
    Clipper::new(points.collect()).clip(&mut triangle)
}

/// The mean normal over the whole polygon (Newell), zero where it encloses no area.
fn normal(corners: &[DVec3]) -> DVec3 {
    let from_first = |k: usize| corners[k] - corners[0];
    let area = |k: usize| from_first(k).cross(from_first(k + 1));
    let sum: DVec3 = (1..corners.len().saturating_sub(1)).map(area).sum();
    sum.normalize_or_zero()
}

/// Whether none of the triangles (0, k, k + 1) faces backwards or is flat: in a polygon that does not cross itself they
/// then do not overlap either. Two corners at one place are harmless, nothing is lost with such a triangle.
fn fan_covers(corners: &[DVec3], normal: DVec3) -> bool {
    corners[1..].windows(2).all(|pair| {
        let [a, b] = [pair[0] - corners[0], pair[1] - corners[0]];
        let at_one_place = a == b || a == DVec3::ZERO || b == DVec3::ZERO;
        a.cross(b).dot(normal) > 0.0 || at_one_place
    })
}

/// How wide an ear must be, and how far other corners must keep off it.
#[derive(Clone, Copy)]
struct Margin {
    /// Least sine of its angle.
    sine: f64,
    /// Least distance from other corners.
    distance: f64,
}

/// A polygon in its plane, counterclockwise, of which ears are cut.
struct Clipper {
    points: Vec<DVec2>,
    previous: Vec<u32>,
    next: Vec<u32>,
    is_cut: Vec<bool>,
    grid: Grid,
    margin: Margin,
}

impl Clipper {
    fn new(points: Vec<DVec2>) -> Self {
        let count = points.len() as u32;
        let grid = Grid::new(&points);
        Self {
            previous: (0..count).map(|k| (k + count - 1) % count).collect(),
            next: (0..count).map(|k| (k + 1) % count).collect(),
            is_cut: vec![false; points.len()],
            // Corners on a straight line come out of files with errors in the last digit of a float32. As ears they
            // would make needles, so they are left to their neighbours.
            margin: Margin {
                sine: 1e-6,
                distance: 1e-7 * grid.size.max_element(),
            },
            points,
            grid,
        }
    }

    fn clip(mut self, triangle: &mut impl FnMut([u32; 3])) -> bool {
        let mut left = self.points.len();
        let mut all_ears = true;
        // Cutting an ear changes only the angles of its two neighbours: they alone are looked at again.
        let mut candidates: VecDeque<u32> = (0..left as u32).collect();
        // Corners that may be looked at once more where no ear is left: more would take quadratic time.
        let mut looks = 20 * left;
        let mut some = 0;
        while left > 3 {
            let ear = match candidates.pop_front() {
                Some(corner) => {
                    if self.is_cut[corner as usize] || !self.is_ear(corner) {
                        continue;
                    }
                    corner
                }
                None if self.margin.sine > 0.0 => {
                    self.margin = Margin {
                        sine: 0.0,
                        distance: 0.0,
                    };
                    candidates.extend(self.all_left(some));
                    continue;
                }
                None => {
                    // Any corner must do, and after it there may be ears again.
                    all_ears = false;
                    if looks >= left {
                        looks -= left;
                        candidates.extend(self.all_left(some));
                    }
                    some
                }
            };
            let (before, after) = (self.previous[ear as usize], self.next[ear as usize]);
            triangle([before, ear, after]);
            self.is_cut[ear as usize] = true;
            self.next[before as usize] = after;
            self.previous[after as usize] = before;
            candidates.extend([before, after]);
            some = after;
            left -= 1;
        }
        triangle([self.previous[some as usize], some, self.next[some as usize]]);
        all_ears
    }

    /// The corners that are left, from one of them on.
    fn all_left(&self, first: u32) -> Vec<u32> {
        let mut list = vec![first];
        let mut corner = self.next[first as usize];
        while corner != first {
            list.push(corner);
            corner = self.next[corner as usize];
        }
        list
    }

    /// Whether a corner is convex, and its triangle holds no other corner but ones at the places of its own.
    fn is_ear(&self, corner: u32) -> bool {
        let ends = [
            self.previous[corner as usize],
            corner,
            self.next[corner as usize],
        ];
        let [a, b, c] = ends.map(|end| self.points[end as usize]);
        let [ab, bc, ca] = [b - a, c - b, a - c];
        if ab.perp_dot(bc) <= self.margin.sine * ab.length() * bc.length() {
            return false;
        }
        let blocks = |other: u32| {
            let point = self.points[other as usize];
            let inside = |start: DVec2, along: DVec2| {
                along.perp_dot(point - start) >= -self.margin.distance * along.length()
            };
            !self.is_cut[other as usize]
                && ![a, b, c].contains(&point)
                && inside(a, ab)
                && inside(b, bc)
                && inside(c, ca)
        };
        !self.grid.any_near([a, b, c], self.margin.distance, blocks)
    }
}

/// Points by square cells, about one to each.
struct Grid {
    low: DVec2,
    size: DVec2,
    /// Cells along a side.
    side: usize,
    /// Where the points of each cell begin in `points`, row by row; one more at the end.
    starts: Vec<u32>,
    points: Vec<u32>,
}

impl Grid {
    fn new(points: &[DVec2]) -> Self {
        let low = points.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let high = points.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
        let side = (points.len() as f64).sqrt().ceil() as usize;
        let mut grid = Self {
            low,
            size: high - low,
            side,
            starts: vec![0; side * side + 1],
            points: vec![0; points.len()],
        };
        let cells: Vec<usize> = points
            .iter()
            .map(|&point| {
                let [column, row] = grid.cell(point);
                row * side + column
            })
            .collect();
        for &cell in &cells {
            grid.starts[cell + 1] += 1;
        }
        for cell in 0..side * side {
            grid.starts[cell + 1] += grid.starts[cell];
        }
        let mut free = grid.starts.clone();
        for (point, cell) in cells.into_iter().enumerate() {
            grid.points[free[cell] as usize] = point as u32;
            free[cell] += 1;
        }
        grid
    }

    /// Column and row of a place, the nearest ones outside of the grid.
    fn cell(&self, place: DVec2) -> [usize; 2] {
        let in_cells = (place - self.low) / self.size * self.side as f64;
        // Of a polygon without height this is NaN, which becomes 0.
        in_cells.to_array().map(|c| (c as usize).min(self.side - 1))
    }

    /// Whether a test holds for any point in or near a triangle. Asks for the points of all cells that the triangle
    /// touches, row by row: a needle's bounding box would hold far more.
    fn any_near(&self, triangle: [DVec2; 3], distance: f64, test: impl Fn(u32) -> bool) -> bool {
        let [a, b, c] = triangle;
        // Rounding must not lose a point on the border of a cell.
        let margin = DVec2::splat(distance) + 1e-9 * self.size;
        let [_, first] = self.cell(a.min(b).min(c) - margin);
        let [_, last] = self.cell(a.max(b).max(c) + margin);
        let height = self.size.y / self.side as f64;
        (first..=last).any(|row| {
            let bottom = self.low.y + row as f64 * height;
            let (low, high) = (bottom - margin.y, bottom + height + margin.y);
            let Some((left, right)) = span(triangle, low, high) else {
                return false;
            };
            let [left, _] = self.cell(DVec2::new(left - margin.x, bottom));
            let [right, _] = self.cell(DVec2::new(right + margin.x, bottom));
            let from = self.starts[row * self.side + left] as usize;
            let to = self.starts[row * self.side + right + 1] as usize;
            self.points[from..to].iter().any(|&point| test(point))
        })
    }
}

/// The lowest and the highest x of a triangle between two heights.
fn span(triangle: [DVec2; 3], low: f64, high: f64) -> Option<(f64, f64)> {
    let mut found: Option<(f64, f64)> = None;
    for k in 0..3 {
        let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
        let (bottom, top) = if a.y <= b.y { (a, b) } else { (b, a) };
        if top.y < low || bottom.y > high {
            continue;
        }
        let at = |y: f64| {
            let t = (y - bottom.y) / (top.y - bottom.y);
            bottom.x + t * (top.x - bottom.x)
        };
        let start = if bottom.y < low { at(low) } else { bottom.x };
        let end = if top.y > high { at(high) } else { top.x };
        let (left, right) = found.unwrap_or((start, start));
        found = Some((left.min(start).min(end), right.max(start).max(end)));
    }
    found
}
