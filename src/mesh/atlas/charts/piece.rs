//! A flattened set of triangles, and its quality.

use glam::DVec2;

use super::flatten::flatten;
use super::metric::Metric;
use super::patch::{Patch, Places};
use crate::mesh::surface::{NONE, Surface};

/// A chart, or a part of one to be.
#[derive(Clone)]
pub(super) struct Piece {
    /// Ascending.
    pub triangles: Vec<u32>,
    /// Positions of their corners; the area is that on the surface.
    pub corners: Vec<[DVec2; 3]>,
    /// Half-edges of the surface at its border, including open ones.
    pub border: Vec<u32>,
    pub area: f64,
    /// Length of the border.
    pub perimeter: f64,
    pub quality: Quality,
}

/// The distortion of a flattened piece, as shares of its surface area, and measures of its shape.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Quality {
    /// Share of the area that shrinks too much.
    pub small: f64,
    /// Share of the area that grows too much.
    pub large: f64,
    /// Share of the area that is stretched too much in one direction.
    pub skewed: f64,
    /// Share of the area with extreme distortion.
    pub wild: f64,
    /// Area of the convex hull over the area: 1 is convex.
    pub hull: f64,
    /// Outer perimeter, without its teeth, squared over that of a disc of the same area: 1 is a disc.
    pub roundness: f64,
    /// Its share of the area of the whole surface.
    pub part: f64,
    /// Share of the area that is not developable.
    pub bent: f64,
}

/// Bounds on a piece. If less than 5 % of every chart is below and above the allowed growth of areas, the 5 % and 95 % percentiles of the
/// whole atlas lie within it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    /// Share of the area that may shrink, grow or skew too much, each.
    pub share: f64,
    pub wild: f64,
    pub hull: f64,
    pub roundness: f64,
    /// Largest share of the whole surface, for a piece that is not developable: a few large charts would leave gaps that no other chart
    /// fills.
    pub part: f64,
}

/// Bounds on all charts together. The roundness was chosen at 1024 x 1024: with 1.75 charts fill 0.65 to 0.72 of the texture, with 2.2 half
/// as many charts fill 0.58 to 0.69; with 1.5 hardly any pieces can be joined.
pub(super) const STRICT: Bounds = Bounds {
    share: 0.045,
    wild: 0.002,
    hull: 1.6,
    roundness: 1.75,
    part: 0.1,
};

/// Bounds on a single chart, as long as all together are within the strict bounds.
pub(super) const LOOSE: Bounds = Bounds {
    share: 0.2,
    wild: 0.005,
    ..STRICT
};

/// A triangle whose area changes more than this is bent: the piece is not developable there.
const UNROLLED: f64 = 0.01;

/// Areas shrink at most to this and grow at most to its counterpart.
const AREA: [f64; 2] = [0.856, 1.144];
/// The error of the estimated growth of areas.
const DOUBT: f64 = 0.01;
/// Growth beyond these is extreme.
const WILD_AREA: [f64; 2] = [0.6, 1.7];
/// Larger over smaller stretch of a triangle.
const SKEW: f64 = 1.145;
const WILD_SKEW: f64 = 1.6;

/// Why a set of triangles is no piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Refusal {
    /// The triangles form no disc.
    Shape,
    /// The flattened triangles fold, overlap or distort too much.
    Distortion,
}

impl Piece {
    /// One triangle, as it is.
    pub fn single(metric: &Metric, triangle: u32) -> Self {
        let shape = &metric.shapes[triangle as usize];
        let area = shape.area();
        let perimeter = shape.lengths.iter().sum::<f64>();
        Self {
            triangles: vec![triangle],
            corners: vec![[
                DVec2::ZERO,
                DVec2::new(shape.ab, 0.0),
                DVec2::new(shape.cp, shape.ch),
            ]],
            border: (3 * triangle..3 * triangle + 3).collect(),
            area,
            perimeter,
            quality: Quality {
                hull: 1.0,
                roundness: roundness(perimeter, area),
                ..Quality::default()
            },
        }
    }

    /// Flattens triangles, given in ascending order, if they are a disc and stay within bounds.
    pub fn new(
        surface: &Surface,
        metric: &Metric,
        triangles: &[u32],
        bounds: &Bounds,
        places: &mut Places,
    ) -> Result<Self, Refusal> {
        if let &[triangle] = triangles {
            return Ok(Self::single(metric, triangle));
        }
        let patch = Patch::new(surface, triangles, places).ok_or(Refusal::Shape)?;
        let area = metric.area(triangles);
        let hopeful = |growths: &[f64]| is_hopeful(metric, triangles, growths, bounds);
        let positions = flatten(&patch, metric, hopeful).ok_or(Refusal::Distortion)?;
        let at = |corners: &[u32; 3]| corners.map(|vertex| positions[vertex as usize]);
        let mut corners: Vec<_> = patch.corners[..triangles.len()].iter().map(at).collect();
        let flat_area: f64 = corners.iter().map(signed_area).sum();
        let scale = (area / flat_area).sqrt();
        if !(scale.is_finite() && scale > 0.0) {
            return Err(Refusal::Distortion);
        }
        for corner in corners.iter_mut().flatten() {
            *corner *= scale;
        }
        let curve: Vec<DVec2> = patch
            .border
            .iter()
            .map(|&h| scale * positions[patch.vertex_of(h) as usize])
            .collect();
        let border = border_of(&patch);
        let perimeter: f64 = border.iter().map(|&h| metric.length(h)).sum();
        let hull = hull_area(&curve);
        let mut quality = Quality {
            hull: hull / area,
            roundness: roundness(
                smooth_perimeter(&curve, metric.is_coarse[triangles[0] as usize]),
                area,
            ),
            part: area / metric.total,
            ..Quality::default()
        };
        for (&t, corners) in triangles.iter().zip(&corners) {
            if !quality.add(metric, t, corners, 1.0 / area) {
                return Err(Refusal::Distortion);
            }
        }
        if !quality.within(bounds) || crosses_itself(&curve) {
            return Err(Refusal::Distortion);
        }
        Ok(Self {
            triangles: triangles.to_vec(),
            corners,
            border,
            area,
            perimeter,
            quality,
        })
    }
}

/// Can triangles whose areas grow by about these factors stay within bounds?
fn is_hopeful(metric: &Metric, triangles: &[u32], growths: &[f64], bounds: &Bounds) -> bool {
    let (mut area, mut grown) = (0.0, 0.0);
    let areas = triangles.iter().map(|&t| metric.shapes[t as usize].area());
    for (own, growth) in areas.clone().zip(growths) {
        area += own;
        grown += own * growth;
    }
    let (mut small, mut large) = (0.0, 0.0);
    for (own, growth) in areas.zip(growths) {
        let growth = growth * area / grown;
        if growth < AREA[0] - DOUBT {
            small += own;
        }
        if growth > AREA[1] + DOUBT {
            large += own;
        }
    }
    small.max(large) <= (bounds.share + DOUBT) * area
}

impl Quality {
    /// Counts a flattened triangle; false when it is folded over.
    fn add(&mut self, metric: &Metric, triangle: u32, corners: &[DVec2; 3], unit: f64) -> bool {
        let shape = &metric.shapes[triangle as usize];
        let p = (corners[1] - corners[0]) / shape.ab;
        let h = (corners[2] - corners[0] - shape.cp * p) / shape.ch;
        let growth = p.perp_dot(h);
        if growth.is_nan() || growth <= 0.0 || signed_area(corners) <= 0.0 {
            return false;
        }
        // The sum of the larger stretch over the smaller and of its inverse.
        let skew = (p.length_squared() + h.length_squared()) / growth;
        let share = shape.area() * unit;
        if (growth - 1.0).abs() > UNROLLED {
            self.bent += share;
        }
        let beyond = |limit: f64| skew > limit + 1.0 / limit;
        if growth < AREA[0] {
            self.small += share;
        }
        if growth > AREA[1] {
            self.large += share;
        }
        if beyond(SKEW) {
            self.skewed += share;
        }
        if beyond(WILD_SKEW) || !(WILD_AREA[0]..=WILD_AREA[1]).contains(&growth) {
            self.wild += share;
        }
        true
    }

    pub fn within(&self, bounds: &Bounds) -> bool {
        self.small <= bounds.share
            && self.large <= bounds.share
            && self.skewed <= bounds.share
            && self.wild <= bounds.wild
            && self.hull <= bounds.hull
            && self.roundness <= bounds.roundness
            && (self.part <= bounds.part || self.bent <= bounds.wild)
    }
}

/// Areas that shrink, grow and skew too much, from which the percentiles of the whole atlas follow.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Spending([f64; 3]);

impl Spending {
    pub fn plus(&self, other: &Self) -> Self {
        Self([0, 1, 2].map(|k| self.0[k] + other.0[k]))
    }

    pub fn minus(&self, other: &Self) -> Self {
        Self([0, 1, 2].map(|k| self.0[k] - other.0[k]))
    }

    /// Is it within the strict share of the whole area, or no more than before?
    pub fn within(&self, before: &Self, area: f64) -> bool {
        let limit = STRICT.share * area;
        let pairs = self.0.iter().zip(&before.0);
        pairs
            .into_iter()
            .all(|(now, before)| *now <= limit.max(*before))
    }
}

impl Piece {
    pub fn spending(&self) -> Spending {
        let Quality {
            small,
            large,
            skewed,
            ..
        } = self.quality;
        Spending([small, large, skewed].map(|share| share * self.area))
    }
}

fn roundness(perimeter: f64, area: f64) -> f64 {
    perimeter * perimeter / (4.0 * std::f64::consts::PI * area)
}

/// The most parts into which a border is divided for its perimeter.
const BORDER_PARTS: usize = 64;
/// On coarse parts of the surface there are fewer parts, so that each averages over a tooth of the border, but enough to show its shape.
/// Fine parts keep the stricter measure: without it, a capsule is cut into 73 charts instead of 12.
const EDGES_A_PART: f64 = 2.5;
const FEWEST_PARTS: usize = 12;

/// The perimeter of a border without its teeth, which are as small as triangles and do not matter: the perimeter of the polygon of mean
/// positions over equal parts of the border.
fn smooth_perimeter(curve: &[DVec2], is_coarse: bool) -> f64 {
    let parts = if is_coarse {
        ((curve.len() as f64 / EDGES_A_PART) as usize).clamp(FEWEST_PARTS, BORDER_PARTS)
    } else {
        BORDER_PARTS
    };
    let ends = || (0..curve.len()).map(|k| (curve[k], curve[(k + 1) % curve.len()]));
    let part = ends().map(|(a, b)| a.distance(b)).sum::<f64>() / parts as f64;
    let mut means = vec![DVec2::ZERO; parts];
    let (mut index, mut room) = (0, part);
    for (mut a, b) in ends() {
        let mut left = a.distance(b);
        while left > 0.0 {
            let way = left.min(room);
            let to = a + way / left * (b - a);
            means[index] += way / part * a.midpoint(to);
            (a, left, room) = (to, left - way, room - way);
            if room <= 0.0 {
                (index, room) = ((index + 1).min(parts - 1), part);
            }
        }
    }
    (0..parts)
        .map(|k| means[k].distance(means[(k + 1) % parts]))
        .sum()
}

pub(super) fn signed_area([a, b, c]: &[DVec2; 3]) -> f64 {
    0.5 * (b - a).perp_dot(c - a)
}

fn border_of(patch: &Patch) -> Vec<u32> {
    let count = 3 * patch.triangles.len() as u32;
    let of_surface = |h: u32| 3 * patch.triangles[h as usize / 3] + h % 3;
    (0..count)
        .filter(|&h| {
            let twin = patch.twins[h as usize];
            twin == NONE || twin >= count
        })
        .map(of_surface)
        .collect()
}

/// Area of the convex hull of some points (the monotone chain of Andrew, 1979).
fn hull_area(points: &[DVec2]) -> f64 {
    let mut points = points.to_vec();
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let half = |points: &mut dyn Iterator<Item = &DVec2>| {
        let mut chain: Vec<DVec2> = Vec::new();
        for &point in points {
            while let [.., a, b] = chain[..]
                && (b - a).perp_dot(point - a) <= 0.0
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain
    };
    let mut hull = half(&mut points.iter());
    hull.pop();
    hull.extend(half(&mut points.iter().rev()));
    let pairs = hull.iter().zip(hull.iter().cycle().skip(1));
    0.5 * pairs.map(|(a, b)| a.perp_dot(*b)).sum::<f64>()
}

/// Do two edges of a closed curve meet that are not neighbours?
fn crosses_itself(curve: &[DVec2]) -> bool {
    let n = curve.len();
    let (low, high) = curve.iter().fold(
        (DVec2::INFINITY, DVec2::NEG_INFINITY),
        |(low, high), &point| (low.min(point), high.max(point)),
    );
    // Sweep along the longer side.
    let turned = (high - low).y > (high - low).x;
    let at = |i: usize| {
        let point = curve[i % n];
        if turned {
            DVec2::new(point.y, point.x)
        } else {
            point
        }
    };
    let mut order: Vec<(f64, f64, u32)> = (0..n)
        .map(|i| {
            let (a, b) = (at(i).x, at(i + 1).x);
            (a.min(b), a.max(b), i as u32)
        })
        .collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (k, &(_, end, i)) in order.iter().enumerate() {
        let i = i as usize;
        let (a, b) = (at(i), at(i + 1));
        let (bottom, top) = (a.y.min(b.y), a.y.max(b.y));
        for &(start, _, j) in &order[k + 1..] {
            if start > end {
                break;
            }
            let j = j as usize;
            if (i + 1) % n == j || (j + 1) % n == i {
                continue;
            }
            let (c, d) = (at(j), at(j + 1));
            if c.y.max(d.y) < bottom || c.y.min(d.y) > top {
                continue;
            }
            let side = |p: DVec2, q: DVec2, r: DVec2| (q - p).perp_dot(r - p);
            if side(a, b, c) * side(a, b, d) <= 0.0 && side(c, d, a) * side(c, d, b) <= 0.0 {
                return true;
            }
        }
    }
    false
}
