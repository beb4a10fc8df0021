//! What the heat equation says: in closed form where there is one, by finite elements in double precision elsewhere.

use std::collections::HashMap;

use glam::DVec3;
use myxo::mesh::surface::Surface;
use rayon::prelude::*;

/// The heat kernel of a sphere, per unit area, at an angle from its source: a sum of Legendre polynomials. `time` is
/// diffusivity times time.
pub fn sphere_kernel(radius: f64, time: f64, angle: f64) -> f64 {
    let x = angle.cos();
    let (mut before, mut here) = (1.0, x);
    let mut sum = 1.0;
    for l in 1..2000 {
        let l = f64::from(l);
        let factor = (-l * (l + 1.0) * time / (radius * radius)).exp();
        if factor < 1e-18 {
            break;
        }
        sum += (2.0 * l + 1.0) * factor * here;
        (before, here) = (here, ((2.0 * l + 1.0) * x * here - l * before) / (l + 1.0));
    }
    sum / (4.0 * std::f64::consts::PI * radius * radius)
}

/// The heat kernel of the plane, per unit area.
pub fn plane_kernel(time: f64, distance: f64) -> f64 {
    (-distance * distance / (4.0 * time)).exp() / (4.0 * std::f64::consts::PI * time)
}

/// Linear finite elements on the part of a surface about a point: cotangent stiffness (Pinkall and Polthier 1993),
/// lumped masses, small explicit steps. Each triangle is cut into `cuts * cuts`, which changes nothing of the surface.
pub struct Elements {
    cuts: u32,
    /// Per triangle of the surface that takes part: its vertices, row by row.
    vertices: HashMap<u32, Vec<u32>>,
    positions: Vec<DVec3>,
    mass: Vec<f64>,
    /// Per vertex: where its neighbours begin.
    starts: Vec<usize>,
    neighbours: Vec<(u32, f64)>,
}

/// The most that a triangle about a point asks for in steps of [`Elements`]: its cotangents by its area.
pub fn narrowness(surface: &Surface, centre: DVec3, reach: f64) -> f64 {
    let shapes = surface.corners.iter().filter_map(|corners| {
        let place = corners.map(|vertex| surface.positions[vertex as usize].as_dvec3());
        takes_part(place, centre, reach).then_some(place)
    });
    shapes
        .map(|[a, b, c]| {
            let double_area = (b - a).cross(c - a).length();
            let cotangent = |p: DVec3, q: DVec3, o: DVec3| (p - o).dot(q - o).abs() / double_area;
            (cotangent(a, b, c) + cotangent(b, c, a) + cotangent(c, a, b)) / double_area
        })
        .fold(0.0, f64::max)
}

fn takes_part([a, b, c]: [DVec3; 3], centre: DVec3, reach: f64) -> bool {
    let size = a.distance(b).max(b.distance(c)).max(c.distance(a));
    a.distance(centre) <= reach + size
}

/// What makes a cut triangle's vertex the same as another's.
#[derive(PartialEq, Eq, Hash)]
enum Name {
    Corner(u32),
    Edge(u32, u32, u32),
    Inside(u32, u32, u32),
}

impl Elements {
    pub fn new(surface: &Surface, cuts: u32, centre: DVec3, reach: f64) -> Self {
        let corner = |vertex: u32| surface.positions[vertex as usize].as_dvec3();
        let mut names: HashMap<Name, u32> = HashMap::new();
        let mut positions = Vec::new();
        let mut vertices = HashMap::new();
        let mut small = Vec::new();
        for (t, &corners) in surface.corners.iter().enumerate() {
            let [a, b, c] = corners.map(corner);
            if !takes_part([a, b, c], centre, reach) {
                continue;
            }
            let mut own = Vec::new();
            for j in 0..=cuts {
                for i in 0..=cuts - j {
                    let place = a
                        + (b - a) * f64::from(i) / f64::from(cuts)
                        + (c - a) * f64::from(j) / f64::from(cuts);
                    let name = name_of(corners, t as u32, cuts, i, j);
                    own.push(*names.entry(name).or_insert_with(|| {
                        positions.push(place);
                        positions.len() as u32 - 1
                    }));
                }
            }
            let at = |i: u32, j: u32| own[index(cuts, i, j)];
            for j in 0..cuts {
                for i in 0..cuts - j {
                    small.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
                    if i + j + 1 < cuts {
                        small.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                    }
                }
            }
            vertices.insert(t as u32, own);
        }
        let mut mass = vec![0.0; positions.len()];
        let mut weights: HashMap<(u32, u32), f64> = HashMap::new();
        for triangle in small {
            let [a, b, c] = triangle.map(|v: u32| positions[v as usize]);
            let double_area = (b - a).cross(c - a).length();
            for k in 0..3 {
                let [v, next, other] = [0, 1, 2].map(|i| triangle[(k + i) % 3]);
                mass[v as usize] += double_area / 6.0;
                let [p, q, o] = [v, next, other].map(|v| positions[v as usize]);
                let cotangent = (p - o).dot(q - o) / double_area;
                *weights.entry((v, next)).or_default() += 0.5 * cotangent;
                *weights.entry((next, v)).or_default() += 0.5 * cotangent;
            }
        }
        let mut sorted: Vec<((u32, u32), f64)> = weights.into_iter().collect();
        sorted.sort_unstable_by_key(|entry| entry.0);
        let mut starts = vec![0; positions.len() + 1];
        for &((v, _), _) in &sorted {
            starts[v as usize + 1] += 1;
        }
        for v in 0..positions.len() {
            starts[v + 1] += starts[v];
        }
        Self {
            cuts,
            vertices,
            positions,
            mass,
            starts,
            neighbours: sorted.into_iter().map(|((_, n), w)| (n, w)).collect(),
        }
    }

    fn neighbours(&self, v: usize) -> &[(u32, f64)] {
        &self.neighbours[self.starts[v]..self.starts[v + 1]]
    }

    /// How many steps a time takes, which goes by the smallest and narrowest triangle.
    pub fn steps(&self, time: f64) -> u64 {
        let rate = |v: usize| self.neighbours(v).iter().map(|n| n.1.abs()).sum::<f64>();
        let rates = (0..self.mass.len()).map(|v| rate(v) / self.mass[v]);
        let fastest = rates.fold(0.0, f64::max);
        (time * fastest / 0.9).ceil().max(200.0) as u64
    }

    /// Spreads what `start` gives at each place for a time, per unit diffusivity.
    pub fn spread(&self, start: impl Fn(DVec3) -> f64, time: f64) -> Vec<f64> {
        let mut values: Vec<f64> = self.positions.iter().map(|&p| start(p)).collect();
        let neighbours = |v: usize| self.neighbours(v);
        let steps = self.steps(time);
        let step = time / steps as f64;
        for _ in 0..steps {
            values = (0..values.len())
                .into_par_iter()
                .with_min_len(1024)
                .map(|v| {
                    let here = values[v];
                    let flux: f64 = neighbours(v)
                        .iter()
                        .map(|&(n, weight)| weight * (values[n as usize] - here))
                        .sum();
                    here + step * flux / self.mass[v]
                })
                .collect();
        }
        values
    }

    /// The value at a point of the surface, if it takes part.
    pub fn at(&self, values: &[f64], triangle: u32, u: f64, v: f64) -> Option<f64> {
        let own = self.vertices.get(&triangle)?;
        let (x, y) = (u * f64::from(self.cuts), v * f64::from(self.cuts));
        let i = (x as u32).min(self.cuts - 1);
        let j = (y as u32).min(self.cuts - 1 - i);
        let (x, y) = (x - f64::from(i), y - f64::from(j));
        let value = |i: u32, j: u32| values[own[index(self.cuts, i, j)] as usize];
        let (b, c) = (value(i + 1, j), value(i, j + 1));
        Some(if x + y <= 1.0 || i + j + 1 == self.cuts {
            let a = value(i, j);
            a + x * (b - a) + y * (c - a)
        } else {
            let d = value(i + 1, j + 1);
            d + (1.0 - x) * (c - d) + (1.0 - y) * (b - d)
        })
    }
}

fn index(cuts: u32, i: u32, j: u32) -> usize {
    (j * (cuts + 1) - j * j.saturating_sub(1) / 2 + i) as usize
}

fn name_of(corners: [u32; 3], triangle: u32, cuts: u32, i: u32, j: u32) -> Name {
    let k = cuts - i - j;
    let edge = |from: u32, to: u32, along: u32| {
        if from < to {
            Name::Edge(from, to, along)
        } else {
            Name::Edge(to, from, cuts - along)
        }
    };
    match (i, j, k) {
        (_, 0, 0) => Name::Corner(corners[1]),
        (0, _, 0) => Name::Corner(corners[2]),
        (0, 0, _) => Name::Corner(corners[0]),
        (_, 0, _) => edge(corners[0], corners[1], i),
        (0, _, _) => edge(corners[0], corners[2], j),
        (_, _, 0) => edge(corners[1], corners[2], j),
        _ => Name::Inside(triangle, i, j),
    }
}
