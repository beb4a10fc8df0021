//! Distances, signs and crossings in double precision by looking at every triangle, written from the definitions: the
//! nearest of face, edges and corners; the sum of solid angles; the plane and its three sides.

use glam::DVec3;
use myxo::mesh::Mesh;

pub struct Model {
    pub triangles: Vec<[DVec3; 3]>,
    /// Half of the box's diagonal.
    pub radius: f64,
    pub centre: DVec3,
}

fn to_segment(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
    p.distance(a + t * (b - a))
}

/// On the left of all three sides?
fn is_over(p: DVec3, [a, b, c]: [DVec3; 3], normal: DVec3) -> bool {
    [(a, b), (b, c), (c, a)]
        .iter()
        .all(|&(from, to)| normal.cross(to - from).dot(p - from) >= 0.0)
}

pub fn to_triangle(p: DVec3, triangle: [DVec3; 3]) -> f64 {
    let [a, b, c] = triangle;
    let normal = (b - a).cross(c - a).normalize();
    if is_over(p, triangle, normal) {
        return (p - a).dot(normal).abs();
    }
    to_segment(p, a, b)
        .min(to_segment(p, b, c))
        .min(to_segment(p, c, a))
}

impl Model {
    pub fn of(mesh: &Mesh) -> Self {
        let (low, high) = mesh.bounds();
        let corner = |v: u32| mesh.positions[v as usize].as_dvec3();
        Self {
            triangles: mesh.corners.iter().map(|c| c.map(corner)).collect(),
            radius: 0.5 * low.as_dvec3().distance(high.as_dvec3()),
            centre: 0.5 * (low.as_dvec3() + high.as_dvec3()),
        }
    }

    pub fn distance(&self, p: DVec3) -> f64 {
        let distances = self.triangles.iter().map(|&t| to_triangle(p, t));
        distances.fold(f64::INFINITY, f64::min)
    }

    /// 1 inside, 0 outside.
    pub fn winding(&self, p: DVec3) -> f64 {
        let angle = |t: &[DVec3; 3]| {
            let [a, b, c] = t.map(|corner| corner - p);
            let (la, lb, lc) = (a.length(), b.length(), c.length());
            let rest = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
            2.0 * a.dot(b.cross(c)).atan2(rest)
        };
        self.triangles.iter().map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
    }

    /// The place on the way where the first triangle is crossed, with the sine of the angle, and the distance to a side of a
    /// triangle any crossing is, as a share of the model's radius.
    pub fn crossing(&self, from: DVec3, to: DVec3) -> (Option<(f64, f64)>, f64) {
        let mut first: Option<(f64, f64)> = None;
        let mut doubt = f64::INFINITY;
        for &triangle in &self.triangles {
            let [a, b, c] = triangle;
            let normal = (b - a).cross(c - a).normalize();
            let (start, end) = ((from - a).dot(normal), (to - a).dot(normal));
            let t = start / (start - end);
            if !(0.0..=1.0).contains(&t) {
                continue;
            }
            let p = from + t * (to - from);
            let to_side = to_segment(p, a, b)
                .min(to_segment(p, b, c))
                .min(to_segment(p, c, a));
            doubt = doubt.min(to_side / self.radius);
            if is_over(p, triangle, normal) && first.is_none_or(|(before, _)| t < before) {
                first = Some((t, (start - end).abs() / from.distance(to)));
            }
        }
        let ends = self.distance(from).min(self.distance(to));
        (first, doubt.min(ends / self.radius))
    }
}
