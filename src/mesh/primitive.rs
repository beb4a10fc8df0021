//! The shapes of the built-in meshes. All are centred at the origin, with +Y up, and closed ones face outwards.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};

use super::Mesh;
use super::soup::Soup;
use crate::portable::sin_cos;

/// A cube with edges of 2 about the origin; each face is a grid of `divisions` squared quads of two triangles.
#[must_use]
pub fn cube(divisions: u32) -> Mesh {
    assert!(divisions > 0, "a cube's edges need a division at least");
    let n = divisions;
    let mut known = HashMap::new();
    let mut builder = Builder::default();
    let coordinate = |i: u32| f64::from(2 * i) / f64::from(n) - 1.0;
    let mut vertex = |builder: &mut Builder, at: [u32; 3]| {
        *known
            .entry(at)
            .or_insert_with(|| builder.vertex(DVec3::from_array(at.map(coordinate))))
    };
    for axis in 0..3 {
        for end in [0, n] {
            // On the far side (u, v, axis) is right-handed; on the near side u and v trade places.
            let (u, v) = if end == n {
                ((axis + 1) % 3, (axis + 2) % 3)
            } else {
                ((axis + 2) % 3, (axis + 1) % 3)
            };
            for j in 0..n {
                for i in 0..n {
                    let mut corner = |di: u32, dj: u32| {
                        let mut at = [0; 3];
                        at[axis] = end;
                        at[u] = i + di;
                        at[v] = j + dj;
                        vertex(&mut builder, at)
                    };
                    let quad = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                    builder.quad(quad);
                }
            }
        }
    }
    builder.finish("cube")
}

/// A torus about the Y axis: radius 1 to the middle of the tube, `tube` the tube's own radius,
/// `major` segments around the axis and `minor` around the tube; `2 * major * minor` triangles.
#[must_use]
pub fn torus(major: u32, minor: u32, tube: f64) -> Mesh {
    assert!(
        major >= 3 && minor >= 3,
        "a torus needs three segments each way"
    );
    let mut builder = Builder::default();
    for i in 0..major {
        let (sin_major, cos_major) = sin_cos(turn(i, major));
        for j in 0..minor {
            let (sin_minor, cos_minor) = sin_cos(turn(j, minor));
            let out = 1.0 + tube * cos_minor;
            builder.vertex(DVec3::new(
                out * cos_major,
                tube * sin_minor,
                out * sin_major,
            ));
        }
    }
    let at = |i: u32, j: u32| (i % major) * minor + j % minor;
    for i in 0..major {
        for j in 0..minor {
            builder.quad([at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]);
        }
    }
    builder.finish("torus")
}

/// A sphere of radius 1: an icosahedron whose triangles are quartered `subdivisions` times; `20 * 4^subdivisions`.
#[must_use]
pub fn icosphere(subdivisions: u32) -> Mesh {
    let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut points: Vec<DVec3> = Vec::new();
    for (one, other) in [
        (1.0, golden),
        (-1.0, golden),
        (1.0, -golden),
        (-1.0, -golden),
    ] {
        points.push(DVec3::new(one, other, 0.0).normalize());
        points.push(DVec3::new(0.0, one, other).normalize());
        points.push(DVec3::new(other, 0.0, one).normalize());
    }
    let mut corners = hull_of_icosahedron(&points);
    for _ in 0..subdivisions {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                let point = (points[a as usize] + points[b as usize]).normalize();
                points.push(point);
                points.len() as u32 - 1
            })
        };
        let mut finer = Vec::with_capacity(4 * corners.len());
        for &[a, b, c] in &corners {
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        corners = finer;
    }
    let builder = Builder {
        positions: points.iter().map(|point| point.as_vec3()).collect(),
        corners,
    };
    builder.finish("icosphere")
}

/// The 20 triples of points that are one edge apart, wound outwards.
fn hull_of_icosahedron(points: &[DVec3]) -> Vec<[u32; 3]> {
    let near = |a: usize, b: usize| points[a].dot(points[b]) > 0.4;
    let mut corners = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(c, a) {
                    let outward = points[a].dot(points[b].cross(points[c])) > 0.0;
                    let [b, c] = if outward { [b, c] } else { [c, b] };
                    corners.push([a as u32, b as u32, c as u32]);
                }
            }
        }
    }
    corners
}

/// A square of 2 by 2 in the XZ plane that faces +Y, of `columns` (along X) by `rows` (along Z) quads.
#[must_use]
pub fn plane(columns: u32, rows: u32) -> Mesh {
    assert!(
        columns > 0 && rows > 0,
        "a plane needs a quad at least each way"
    );
    let mut builder = Builder::default();
    let coordinate = |i: u32, n: u32| f64::from(2 * i) / f64::from(n) - 1.0;
    for j in 0..=rows {
        for i in 0..=columns {
            builder.vertex(DVec3::new(coordinate(i, columns), 0.0, coordinate(j, rows)));
        }
    }
    let at = |i: u32, j: u32| j * (columns + 1) + i;
    for j in 0..rows {
        for i in 0..columns {
            builder.quad([at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]);
        }
    }
    builder.finish("plane")
}

/// As [`plane`], with opposite sides glued: walks that leave by one side come in by the other.
#[must_use]
pub fn periodic_plane(columns: u32, rows: u32) -> Mesh {
    let quad = |i: u32, j: u32| j * columns + i;
    // A quad has its sides at lower X and at higher Z in its first triangle, the two others in its second.
    let [low_x, high_z, high_x, low_z] = [(0, 0), (0, 1), (1, 1), (1, 2)];
    let pair = |one: u32, of_one: (u32, u32), other: u32, of_other: (u32, u32)| {
        let face = |quad: u32, side: (u32, u32)| 2 * quad + side.0;
        [
            face(one, of_one),
            of_one.1,
            face(other, of_other),
            of_other.1,
        ]
    };
    let along_x = (0..rows).map(|j| pair(quad(0, j), low_x, quad(columns - 1, j), high_x));
    let along_z = (0..columns).map(|i| pair(quad(i, 0), low_z, quad(i, rows - 1), high_z));
    let pairs: Vec<[u32; 4]> = along_x.chain(along_z).collect();
    plane(columns, rows)
        .glued(&pairs)
        .expect("opposite sides have edges of one length")
}

/// A capsule of radius 0.5 about the Y axis, `length` between the centres of its half spheres;
/// `segments` around, `rings` in each half sphere, and as many along the side as make its quads nearly square.
#[must_use]
pub fn capsule(segments: u32, rings: u32, length: f64) -> Mesh {
    assert!(
        segments >= 3 && rings >= 1,
        "a capsule needs three segments and a ring"
    );
    let radius = 0.5;
    let side_rings = (length / (TAU * radius / f64::from(segments)))
        .round()
        .clamp(1.0, 4096.0) as u32;
    // Heights and radii of the circles, bottom to top, without the poles.
    let mut circles = Vec::new();
    for i in 1..=rings {
        let (sin, cos) = sin_cos(0.5 * PI * f64::from(i) / f64::from(rings));
        circles.push((-0.5 * length - radius * cos, radius * sin));
    }
    for i in 1..side_rings {
        circles.push((
            length * (f64::from(i) / f64::from(side_rings) - 0.5),
            radius,
        ));
    }
    for i in 0..rings {
        let (sin, cos) = sin_cos(0.5 * PI * f64::from(i) / f64::from(rings));
        circles.push((0.5 * length + radius * sin, radius * cos));
    }
    let mut builder = Builder::default();
    let bottom = builder.vertex(DVec3::new(0.0, -0.5 * length - radius, 0.0));
    for &(height, around) in &circles {
        for i in 0..segments {
            let (sin, cos) = sin_cos(turn(i, segments));
            builder.vertex(DVec3::new(around * cos, height, around * sin));
        }
    }
    let top = builder.vertex(DVec3::new(0.0, 0.5 * length + radius, 0.0));
    let at = |ring: u32, i: u32| 1 + ring * segments + i % segments;
    let last = circles.len() as u32 - 1;
    for i in 0..segments {
        builder.triangle([bottom, at(0, i), at(0, i + 1)]);
    }
    for ring in 0..last {
        for i in 0..segments {
            builder.quad([
                at(ring, i),
                at(ring + 1, i),
                at(ring + 1, i + 1),
                at(ring, i + 1),
            ]);
        }
    }
    for i in 0..segments {
        builder.triangle([top, at(last, i + 1), at(last, i)]);
    }
    builder.finish("capsule")
}

fn turn(i: u32, n: u32) -> f64 {
    TAU * f64::from(i) / f64::from(n)
}

#[derive(Default)]
pub(super) struct Builder {
    positions: Vec<Vec3>,
    corners: Vec<[u32; 3]>,
}

impl Builder {
    pub(super) fn vertex(&mut self, position: DVec3) -> u32 {
        self.positions.push(position.as_vec3());
        self.positions.len() as u32 - 1
    }

    fn triangle(&mut self, corners: [u32; 3]) {
        self.corners.push(corners);
    }

    pub(super) fn quad(&mut self, [a, b, c, d]: [u32; 4]) {
        self.triangle([a, b, c]);
        self.triangle([a, c, d]);
    }

    pub(super) fn finish(self, name: &str) -> Mesh {
        let soup = Soup {
            positions: self
                .positions
                .iter()
                .map(|position| position.as_dvec3())
                .collect(),
            triangles: self.corners,
            ..Soup::default()
        };
        Mesh::from_soup(name, soup).expect("the shape has an inside")
    }
}
