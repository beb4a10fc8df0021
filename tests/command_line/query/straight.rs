//! Straight walks in double precision on the bare triangles of a file: no welding by the library, no tangent frames and
//! no stored rotations, so nothing is shared with the tested code.

use std::collections::HashMap;

use glam::{DVec3, Vec3};

/// The triangles of a model as its file has them.
pub struct Model {
    pub positions: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
    /// For each edge of each triangle, the triangle on its other side.
    across: Vec<[Option<usize>; 3]>,
}

/// The end of a walk.
pub struct End {
    pub face: usize,
    pub position: DVec3,
    pub direction: DVec3,
    pub travelled: f64,
    pub at_border: bool,
    /// The least distance from a vertex at which the path has crossed an edge, in lengths of that edge.
    pub nearest_vertex: f64,
    pub crossings: u32,
}

impl Model {
    pub fn new(positions: &[Vec3], triangles: Vec<[u32; 3]>) -> Self {
        // Vertices with identical positions are one.
        let mut first: HashMap<[u32; 3], u32> = HashMap::new();
        let welded: Vec<u32> = (0..)
            .zip(positions)
            .map(|(i, p)| {
                *first
                    .entry(p.to_array().map(|x| (x + 0.0).to_bits()))
                    .or_insert(i)
            })
            .collect();
        let edge = |t: &[u32; 3], k: usize| {
            let [a, b] = [t[k], t[(k + 1) % 3]].map(|i| welded[i as usize]);
            (a.min(b), a.max(b))
        };
        let mut sides: HashMap<(u32, u32), Vec<usize>> = HashMap::new();
        for (face, t) in triangles.iter().enumerate() {
            for k in 0..3 {
                sides.entry(edge(t, k)).or_default().push(face);
            }
        }
        let other = |face: usize, k: usize| match sides[&edge(&triangles[face], k)][..] {
            [a, b] if a == face => Some(b),
            [a, b] if b == face => Some(a),
            [_] => None,
            _ => panic!("the models of these tests are manifold"),
        };
        Self {
            across: (0..triangles.len())
                .map(|face| [0, 1, 2].map(|k| other(face, k)))
                .collect(),
            positions: positions.iter().map(|p| p.as_dvec3()).collect(),
            triangles,
        }
    }

    pub fn corners(&self, face: usize) -> [DVec3; 3] {
        self.triangles[face].map(|i| self.positions[i as usize])
    }

    pub fn point(&self, face: usize, weights: [f64; 3]) -> DVec3 {
        let [a, b, c] = self.corners(face);
        (weights[0] * a + weights[1] * b + weights[2] * c) / weights.iter().sum::<f64>()
    }

    pub fn normal(&self, face: usize) -> DVec3 {
        let [a, b, c] = self.corners(face);
        (b - a).cross(c - a).normalize()
    }

    /// Distance of a point from the nearest edge of a triangle.
    pub fn to_edge(&self, face: usize, point: DVec3) -> f64 {
        let corners = self.corners(face);
        (0..3)
            .map(|k| {
                let (start, along) = (corners[k], corners[(k + 1) % 3] - corners[k]);
                let t = ((point - start).dot(along) / along.length_squared()).clamp(0.0, 1.0);
                point.distance(start + t * along)
            })
            .fold(f64::INFINITY, f64::min)
    }

    /// The largest distance of a vertex from the middle of the bounding box.
    pub fn radius(&self) -> f64 {
        let low = self.positions.iter().copied().reduce(DVec3::min).unwrap();
        let high = self.positions.iter().copied().reduce(DVec3::max).unwrap();
        let middle = 0.5 * (low + high);
        let distances = self.positions.iter().map(|p| p.distance(middle));
        distances.fold(0.0, f64::max)
    }

    /// The largest ratio of a triangle's longest edge to the height above it.
    pub fn skewness(&self) -> f64 {
        let of = |face: usize| {
            let [a, b, c] = self.corners(face);
            let longest = [b - a, c - b, a - c].map(DVec3::length_squared);
            longest.into_iter().fold(0.0, f64::max) / (b - a).cross(c - a).length()
        };
        (0..self.triangles.len()).map(of).fold(0.0, f64::max)
    }

    /// Walks in a direction of the start's plane, and stops at borders.
    pub fn walk(&self, face: usize, weights: [f64; 3], direction: DVec3, length: f64) -> End {
        let mut end = End {
            face,
            position: self.point(face, weights),
            direction,
            travelled: 0.0,
            at_border: false,
            nearest_vertex: f64::INFINITY,
            crossings: 0,
        };
        let mut entered_from = None;
        loop {
            let corners = self.corners(end.face);
            let normal = self.normal(end.face);
            let left = length - end.travelled;
            // Inward normals of the edges, in the triangle's plane.
            let exit = (0..3)
                .filter(|&k| entered_from.is_none() || self.across[end.face][k] != entered_from)
                .filter_map(|k| {
                    let along = corners[(k + 1) % 3] - corners[k];
                    let inward = normal.cross(along).normalize();
                    let speed = -end.direction.dot(inward);
                    let height = (end.position - corners[k]).dot(inward);
                    (speed > 0.0).then(|| (height.max(0.0) / speed, k, along))
                })
                .min_by(|a, b| a.0.total_cmp(&b.0));
            let Some((way, k, along)) = exit.filter(|exit| exit.0 < left) else {
                end.position += left * end.direction;
                end.travelled = length;
                return end;
            };
            end.travelled += way;
            let place = (end.position + way * end.direction - corners[k]).dot(along)
                / along.length_squared();
            end.nearest_vertex = end.nearest_vertex.min(place.abs()).min((1.0 - place).abs());
            end.position = corners[k] + place.clamp(0.0, 1.0) * along;
            let Some(next) = self.across[end.face][k] else {
                end.at_border = true;
                return end;
            };
            end.crossings += 1;
            // The part along the edge stays; the part across it continues into the neighbour's plane.
            let along = along.normalize();
            let inward = normal.cross(along);
            let middle: DVec3 = self.corners(next).into_iter().sum::<DVec3>() / 3.0;
            let to_middle = middle - end.position;
            let onward = (to_middle - to_middle.dot(along) * along).normalize();
            let (stays, turns) = (end.direction.dot(along), -end.direction.dot(inward));
            end.direction = (stays * along + turns * onward).normalize();
            entered_from = Some(end.face);
            end.face = next;
        }
    }
}
