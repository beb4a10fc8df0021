//! Polygons cut into triangles.

use std::collections::VecDeque;
use std::ops::Range;

use glam::{DVec2, DVec3};

/// Cuts a polygon of n corners into n - 2 triangles between them, wound as it is, and calls `triangle` with the three corner numbers of
/// each.
///
/// If the fan (0, k, k + 1) covers the polygon, as with every convex one, it is used: files of points on triangles rely on this numbering.
/// Otherwise ears are clipped in the polygon's own plane. Returns false where the triangles may overlap: where no ear is left, as in
/// polygons that cross themselves, and where the search for ears takes too long.
pub(crate) fn triangulate(corners: &[DVec3], mut triangle: impl FnMut([u32; 3])) -> bool {
    let fan = (1..corners.len().saturating_sub(1) as u32).map(|k| [0, k, k + 1]);
    let normal = normal(corners);
    let is_fan = corners.len() <= 3 || normal == DVec3::ZERO || fan_covers(corners, normal);
    if is_fan {
        fan.for_each(triangle);
        // In a symmetric bow the triangles cancel out.
        return corners.len() <= 3 || normal != DVec3::ZERO || fan_is_flat(corners);
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

/// Whether none of the triangles (0, k, k + 1) has an area, but for rounding.
fn fan_is_flat(corners: &[DVec3]) -> bool {
    corners[1..].windows(2).all(|pair| {
        let [a, b] = [pair[0] - corners[0], pair[1] - corners[0]];
        a.cross(b).length() <= 1e-12 * a.length() * b.length()
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
    tree: Tree,
    margin: Margin,
    /// How many more boxes and points of the tree may be visited, so that no polygon takes quadratic time.
    visits: usize,
}

/// Visits for each corner; combs and coasts take about a hundred, stars of long needles several hundred.
const VISITS: usize = 1000;
/// Visits beyond that: polygons of a few hundred corners never run out of them.
const SPARE_VISITS: usize = 1_000_000;

impl Clipper {
    fn new(points: Vec<DVec2>) -> Self {
        let count = points.len() as u32;
        let tree = Tree::new(&points);
        Self {
            previous: (0..count).map(|k| (k + count - 1) % count).collect(),
            next: (0..count).map(|k| (k + 1) % count).collect(),
            is_cut: vec![false; points.len()],
            // Corners on a straight line come out of files with errors in the last digit of a float32. As ears they
            // would make needles, so they are left to their neighbours.
            margin: Margin {
                sine: 1e-6,
                distance: 1e-7 * tree.size().max_element(),
            },
            visits: SPARE_VISITS + VISITS * points.len(),
            points,
            tree,
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
            if self.visits == 0 {
                let corners = self.all_left(some);
                let ends = corners[1..].windows(2);
                ends.for_each(|pair| triangle([some, pair[0], pair[1]]));
                return false;
            }
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
        let last = [self.previous[some as usize], some, self.next[some as usize]];
        triangle(last);
        // Of a bow one ear is cut, and what is left faces backwards.
        let [a, b, c] = last.map(|end| self.points[end as usize]);
        let [ab, bc] = [b - a, c - b];
        all_ears && ab.perp_dot(bc) >= -1e-6 * ab.length() * bc.length()
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
    fn is_ear(&mut self, corner: u32) -> bool {
        let ends = [
            self.previous[corner as usize],
            corner,
            self.next[corner as usize],
        ];
        let [a, b, c] = ends.map(|end| self.points[end as usize]);
        let [ab, bc] = [b - a, c - b];
        if ab.perp_dot(bc) <= self.margin.sine * ab.length() * bc.length() {
            return false;
        }
        let reach = Reach::new([a, b, c], self.margin.distance);
        let blocks = |other: u32| {
            let point = self.points[other as usize];
            !self.is_cut[other as usize]
                && ![a, b, c].contains(&point)
                && reach.touches(point, point)
        };
        let mut visits = 0;
        let is_blocked = self.tree.any_within(&reach, &mut visits, &blocks);
        self.visits = self.visits.saturating_sub(visits);
        !is_blocked
    }
}

/// A triangle and everything up to a distance from it.
struct Reach {
    corners: [DVec2; 3],
    distance: f64,
    low: DVec2,
    high: DVec2,
}

impl Reach {
    fn new(corners: [DVec2; 3], distance: f64) -> Self {
        let [a, b, c] = corners;
        Self {
            corners,
            distance,
            low: a.min(b).min(c) - distance,
            high: a.max(b).max(c) + distance,
        }
    }

    /// Whether a box may hold a point within reach; exact for a box that is a point. Rounding never excludes the box of
    /// a point within reach, because every operation on coordinates is monotonic.
    fn touches(&self, low: DVec2, high: DVec2) -> bool {
        let overlaps = low.cmple(self.high).all() && high.cmpge(self.low).all();
        overlaps
            && (0..3).all(|k| {
                let start = self.corners[k];
                let along = self.corners[(k + 1) % 3] - start;
                // The corner of the box that lies farthest to the left of this edge.
                let x = if along.y > 0.0 { low.x } else { high.x };
                let y = if along.x > 0.0 { high.y } else { low.y };
                along.perp_dot(DVec2::new(x, y) - start) >= -self.distance * along.length()
            })
    }
}

/// Boxes round points, halved and halved again across their longer sides.
struct Tree {
    /// Box `k` is halved into `2 k + 1` and `2 k + 2`.
    boxes: Vec<Bounds>,
    /// The points by box.
    order: Vec<u32>,
}

#[derive(Clone, Copy, Default)]
struct Bounds {
    low: DVec2,
    high: DVec2,
}

/// Boxes of so few points are not halved.
const LEAF: usize = 8;

impl Tree {
    fn new(points: &[DVec2]) -> Self {
        let mut tree = Self {
            boxes: Vec::new(),
            order: (0..points.len() as u32).collect(),
        };
        halve(points, &mut tree.order, 0, &mut tree.boxes);
        tree
    }

    fn size(&self) -> DVec2 {
        self.boxes[0].high - self.boxes[0].low
    }

    /// Whether a test holds for any point within reach. Asks for a few others, too, and counts what it visits. Cut
    /// corners stay in the tree: few of them lie within later ears.
    fn any_within(&self, reach: &Reach, visits: &mut usize, test: &impl Fn(u32) -> bool) -> bool {
        self.any_in(0, 0..self.order.len(), reach, visits, test)
    }

    fn any_in(
        &self,
        bounds: usize,
        places: Range<usize>,
        reach: &Reach,
        visits: &mut usize,
        test: &impl Fn(u32) -> bool,
    ) -> bool {
        *visits += 1;
        let Bounds { low, high } = self.boxes[bounds];
        if !reach.touches(low, high) {
            return false;
        }
        if places.len() <= LEAF {
            *visits += places.len();
            return self.order[places].iter().any(|&point| test(point));
        }
        let middle = places.start + places.len() / 2;
        self.any_in(2 * bounds + 1, places.start..middle, reach, visits, test)
            || self.any_in(2 * bounds + 2, middle..places.end, reach, visits, test)
    }
}

/// Sorts points into the two halves of a box, and those into theirs.
fn halve(points: &[DVec2], order: &mut [u32], place: usize, boxes: &mut Vec<Bounds>) {
    let all = order.iter().map(|&point| points[point as usize]);
    let low = all.clone().fold(DVec2::INFINITY, DVec2::min);
    let high = all.fold(DVec2::NEG_INFINITY, DVec2::max);
    if boxes.len() <= place {
        boxes.resize(place + 1, Bounds::default());
    }
    boxes[place] = Bounds { low, high };
    if order.len() <= LEAF {
        return;
    }
    let size = high - low;
    let axis = usize::from(size.y > size.x);
    let along = |point: u32| points[point as usize][axis];
    let middle = order.len() / 2;
    order.select_nth_unstable_by(middle, |&a, &b| along(a).total_cmp(&along(b)));
    let (first, second) = order.split_at_mut(middle);
    halve(points, first, 2 * place + 1, boxes);
    halve(points, second, 2 * place + 2, boxes);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A polygon that takes too long is finished as a fan: n - 2 triangles, and the report says that they may overlap.
    #[test]
    fn a_spent_budget_leaves_a_fan() {
        let count = 1000_u32;
        let zigzag = (0..count).map(|k| {
            let angle = std::f64::consts::TAU * f64::from(k) / f64::from(count);
            DVec2::from_angle(angle) * f64::from(1 + k % 2)
        });
        for visits in [0, 1, 5_000, SPARE_VISITS] {
            let mut clipper = Clipper::new(zigzag.clone().collect());
            clipper.visits = visits;
            let mut triangles = Vec::new();
            let covers = clipper.clip(&mut |triangle| triangles.push(triangle));
            assert_eq!(covers, visits == SPARE_VISITS, "{visits} visits");
            assert_eq!(triangles.len(), count as usize - 2, "{visits} visits");
            let mut uses = vec![0; count as usize];
            for [a, b, c] in triangles {
                assert!(a != b && b != c && c != a);
                uses[a as usize] += 1;
                uses[b as usize] += 1;
                uses[c as usize] += 1;
            }
            assert!(uses.iter().all(|&uses| uses > 0), "{visits} visits");
        }
    }
}
